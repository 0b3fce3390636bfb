// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"
#include "sarblock/simulate/simulate.h"

#include <array>
#include <cstdint>
#include <string>

namespace sarblock {

/// Errors of adjustments of drawn blocks against a predicted covariance.
struct Verification {
  int runs = 0;                   ///< compared
  int failed = 0;                 ///< not converged, or a point not solved
  std::string why;                ///< of the first that failed
  std::array<double, 3> rms_m{};  ///< east, north, up, over all points and runs
  double nees_1 = 0.0;            ///< mean of e' Q^-1 e / 3
  Interval bound;                 ///< that holds nees_1 with probability `level`
};

/// Draws noise, paths and control `runs` times about the same nominal block, adjusts each draw and
/// compares. Points without coordinates of their own start where they are planned: it is the
/// covariance that is verified, not the way to a start. Runs go side by side; the result does not
/// depend on the number of threads. The bound is that of a chi-square with runs times
/// SquareFreedom() degrees over these degrees: points of one run hang together, runs do not.
[[nodiscard]] Verification Verify(const Scene& scene,
                                  const SimulatedBlock& simulated,
                                  const AdjustOptions& options,
                                  const AdjustResult& predicted,
                                  int runs,
                                  std::uint64_t seed,
                                  double level,
                                  ProgressSink* progress);

}  // namespace sarblock
