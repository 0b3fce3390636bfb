// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

namespace sarblock {

/// What `auto` stands for; anything else stands for itself. No other choice is both faster and at
/// least as accurate in the recorded study of speed against accuracy (docs/studies/tradeoff.md); a
/// test holds them against its table.
[[nodiscard]] Engine Resolve(Engine asked);
[[nodiscard]] CovarianceMethod Resolve(CovarianceMethod asked);
/// `corrections` is the number of parameters of the passes, the rows of the reduced matrix.
[[nodiscard]] CeresSolver Resolve(CeresSolver asked, int corrections);

}  // namespace sarblock
