// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <optional>
#include <vector>

#include "ceres_engine.h"
#include "determinacy/point_defects.h"
#include "determinacy/rank_report.h"
#include "model/problem.h"
#include "normals/reduced_system.h"

namespace sarblock {

/// Solves and repeats while the weights still move with the solution.
[[nodiscard]] SolveReport SolveRounds(const Weighting& weighting,
                                      const AdjustOptions& options,
                                      AdjustmentProblem* problem,
                                      BlockState* state,
                                      ProgressSink* progress);

/// Points that a poor start led away: to where their looks leave a direction open, or to the mirror
/// solution, above the antennas or on the side they do not look to. Control points are held.
/// `formed` becomes the reduced system, without a loss, at the state.
[[nodiscard]] std::vector<std::size_t> LostPoints(const AdjustmentProblem& problem,
                                                  const BlockState& state,
                                                  std::optional<ReducedSystem>* formed,
                                                  ProgressSink* progress);

/// Solves once more and counts its iterations with those before.
void SolveOnce(const AdjustOptions& options,
               AdjustmentProblem* problem,
               BlockState* state,
               SolveReport* solve,
               ProgressSink* progress);

/// Starts lost points again from the intersection on the corrected paths and solves once more; what
/// is still lost then is left out by name. `system` is the reduced system, without a loss, at the
/// solution, or nothing where points were left out.
void RecoverLostPoints(const AdjustOptions& options,
                       AdjustmentProblem* problem,
                       BlockState* state,
                       SolveReport* solve,
                       std::optional<ReducedSystem>* system,
                       PointDefects* defects,
                       ProgressSink* progress);

/// Newton steps on the reduced system without damping, whose gradient keeps the digits that the
/// solver's shorter sums lose on badly scaled blocks. Ends where the step is what the solver
/// promises, no longer shrinks, or the iterations are used up. Returns all that is left, in sigmas:
/// where large residuals meet bent equations each step is a fixed part of the one before, and many
/// small ones are to come. The weights follow the state. Like every solve it has an allowance of
/// iterations of its own: those before may have gone to points that were lost. `system` and `rank`,
/// its report, become those of the state reached.
[[nodiscard]] double Polish(const AdjustOptions& options,
                            AdjustmentProblem* problem,
                            BlockState* state,
                            std::optional<ReducedSystem>* system,
                            RankReport* rank,
                            SolveReport* solve,
                            ProgressSink* progress);

}  // namespace sarblock
