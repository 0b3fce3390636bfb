// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <cstdint>
#include <vector>

namespace sarblock {

/// What the runs say of `covariance_m2`, by point in east, north, up, which they were compared
/// with. docs/theory/montecarlo.md, Eq. 1 to 4. `seed` is that of the draws.
[[nodiscard]] MonteCarloReport ReportMonteCarlo(const MonteCarloDraws& draws,
                                                std::uint64_t seed,
                                                const std::vector<SymmetricEnu>& covariance_m2);

}  // namespace sarblock
