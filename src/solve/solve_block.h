// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <optional>
#include <vector>

#include "ceres_engine.h"
#include "determinacy/point_defects.h"
#include "model/problem.h"
#include "normals/reduced_system.h"

namespace sarblock {

/// Whole Newton steps on the undamped reduced equations, the weights formed anew with each: the
/// finish of both engines. The gradient keeps digits that the cost has lost, and an undamped sum
/// those that the solver's shorter one has. Ends where the decrement is what the tolerance asks for
/// or no longer shrinks. `system` is formed at the state and factored when it returns true; false
/// where the block cannot be factored there. Fills decrement and contraction of `solve`.
[[nodiscard]] bool NewtonFinish(const AdjustOptions& options,
                                AdjustmentProblem* problem,
                                BlockState* state,
                                ReducedSystem* system,
                                SolveReport* solve,
                                ProgressSink* progress);

/// Solves a problem by the engine that is asked for, the weights formed anew as the solution comes
/// near; least squares end with whole Newton steps, the same for both engines. `solved`, where
/// given, becomes the reduced system, without a loss and undamped, formed at the solution.
[[nodiscard]] SolveReport SolveRounds(const Weighting& weighting,
                                      const AdjustOptions& options,
                                      AdjustmentProblem* problem,
                                      BlockState* state,
                                      ProgressSink* progress,
                                      std::optional<ReducedSystem>* solved = nullptr);

/// Newton step that a robust solution still has to go, in sigmas over all unknowns together;
/// infinite where a look has no value or the equations under the loss cannot be solved.
[[nodiscard]] double StepLeftUnderLoss(const Weighting& weighting,
                                       const AdjustmentProblem& problem,
                                       const BlockState& state,
                                       ProgressSink* progress);

/// Points that a poor start led away: to where their looks leave a direction open, or to the mirror
/// solution, above the antennas or on the side they do not look to. Control points are fixed.
/// `system` is the reduced one, without a loss, at the state.
[[nodiscard]] std::vector<std::size_t> MisplacedPoints(const AdjustmentProblem& problem,
                                                       const BlockState& state,
                                                       const ReducedSystem& system);

/// Solves once more and counts its iterations with those before; `system` as in SolveRounds.
void SolveOnce(const AdjustOptions& options,
               AdjustmentProblem* problem,
               BlockState* state,
               SolveReport* solve,
               std::optional<ReducedSystem>* system,
               ProgressSink* progress);

/// Takes a point that was left out back into the problem where all its looks, but those that the
/// block itself rejects, meet on the corrected paths within their noise and where they look; true
/// if so. The point starts from there.
[[nodiscard]] bool TakeBack(std::size_t point, AdjustmentProblem* problem, BlockState* state);

/// Starts misplaced points again from the intersection on the corrected paths and solves once more;
/// what is still misplaced then is left out by name. Points that were left out while corrections
/// were wrong are taken back, each once, and the solution is tested again until nothing changes.
/// `system` is the reduced system, without a loss, at the solution.
void RecoverMisplacedPoints(const AdjustOptions& options,
                            AdjustmentProblem* problem,
                            BlockState* state,
                            SolveReport* solve,
                            std::optional<ReducedSystem>* system,
                            PointDefects* defects,
                            ProgressSink* progress);

/// Leaves out the looks whose corrected time of reading lies beyond the ends of their path; returns
/// them.
[[nodiscard]] std::vector<std::size_t> LeaveOutBeyondPaths(const BlockState& state,
                                                           AdjustmentProblem* problem);

}  // namespace sarblock
