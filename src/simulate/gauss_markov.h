// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "smooth_curve.h"

namespace sarblock {

/// A third-order Gauss-Markov process at nodes T/64 apart from `start_s` on both ways until they
/// cover [from_s, to_s], which holds start_s. Each step is exact (docs/theory/wander.md, eqs. (5)
/// to (8)); between the nodes the curve differs from the process by 5e-7 of its rms. The draw is a
/// function of seed and stream: a longer span continues a shorter one.
[[nodiscard]] SmoothCurve DrawGaussMarkov(double rms,
                                          double time_constant_s,
                                          double start_s,
                                          double from_s,
                                          double to_s,
                                          std::uint64_t seed,
                                          std::uint64_t stream);

}  // namespace sarblock
