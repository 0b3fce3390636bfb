// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/options.h"

namespace sarblock {

/// What `auto` stands for; anything else stands for itself. The choices are the references of the
/// study of speed against accuracy, which says at every size whether something beats them
/// (docs/studies/tradeoff.md).
[[nodiscard]] Engine Resolve(Engine asked);
[[nodiscard]] CovarianceMethod Resolve(CovarianceMethod asked);

}  // namespace sarblock
