// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/result_file.h"
#include "sarblock/model/options.h"

#include <vector>

namespace sarblock {

/// The correction groups that a result was made with, given or chosen, from the configuration in
/// its summary; none of `intersect`. Throws InputError where the configuration is not one that
/// `adjust` writes.
[[nodiscard]] std::vector<CorrectionGroup> CorrectionsOf(const ResultFile& result);

}  // namespace sarblock
