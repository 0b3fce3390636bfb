// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "ceres_engine.h"
#include "model/problem.h"
#include "normals/reduced_system.h"
#include "weak_directions.h"

namespace sarblock {

/// Looks of a pass that take part, and those that were left out.
struct LookCounts {
  std::size_t kept = 0, lost = 0;

  /// Part that was left out; 0 of none.
  [[nodiscard]] double LostShare() const {
    return lost == 0 ? 0.0 : static_cast<double>(lost) / static_cast<double>(kept + lost);
  }
  /// False where two looks or more, and at least as many as were kept, were left out.
  [[nodiscard]] bool Decide() const { return lost < 2 || lost < kept; }
};

/// Looks of one pass at points of two looks and more. `deciding` are those at points of three looks
/// and more: two looks nearly always meet, wherever their paths are, so they do not check the
/// paths.
struct PassLooks {
  LookCounts all, deciding;
};

/// Counts, by pass, the looks that take part by `look_used` (AdjustmentProblem) and those that do
/// not. Looks that the block rejects are not counted.
[[nodiscard]] std::vector<PassLooks> CountPassLooks(const Block& block,
                                                    const std::vector<std::uint8_t>& look_used);

/// The first pass whose deciding looks do not Decide().
[[nodiscard]] std::optional<std::size_t> UndecidedPass(const std::vector<PassLooks>& by_pass);

/// The first pass that lost more of its deciding looks than chance explains: a pass whose path
/// converged to a wrong place loses good looks. It lost at least a fifth of them and at least twice
/// the part that the others lost, and the probability of so many is below `chance` for all passes
/// together: a binomial distribution with the frequency of the other passes
/// (docs/theory/consensus.md, eq. (4)).
[[nodiscard]] std::optional<std::size_t> PassThatLosesMore(const std::vector<PassLooks>& by_pass,
                                                           double chance = 0.05);

/// Whole Newton steps on the undamped reduced equations, the finish of both engines; the weights
/// follow them until they no longer change. The gradient keeps digits that the cost has lost, and
/// the undamped sum keeps digits that the shorter sum of the solver has lost. Ends where the
/// decrement is within the tolerance or no longer shrinks. `system` is formed at the state and
/// factored when it returns true; false where the block cannot be factored there. Fills the
/// decrement of `solve`.
[[nodiscard]] bool NewtonFinish(const AdjustOptions& options,
                                AdjustmentProblem* problem,
                                BlockState* state,
                                ReducedSystem* system,
                                SolveReport* solve,
                                ProgressSink* progress);

/// Solves a problem by the engine that is asked for; least squares end with whole Newton steps, the
/// same for both engines. `solved`, where given, becomes the reduced system, without a loss and
/// undamped, formed at the solution. If it holds one at the beginning, that is formed at the state,
/// and the first step is made of it.
[[nodiscard]] SolveReport SolveRounds(const Weighting& weighting,
                                      const AdjustOptions& options,
                                      AdjustmentProblem* problem,
                                      BlockState* state,
                                      ProgressSink* progress,
                                      std::optional<ReducedSystem>* solved = nullptr);

/// Newton step that a robust solution still has to go, in sigmas over all unknowns together;
/// infinite where a look has no value or the equations under the loss cannot be solved.
[[nodiscard]] double NewtonDecrementUnderLoss(const Weighting& weighting,
                                              const AdjustmentProblem& problem,
                                              const BlockState& state,
                                              ProgressSink* progress);

/// Points that diverged from a poor start: to where their looks leave a direction open, or to the
/// mirror solution, above the antennas or on the side they do not look to. Control points are
/// fixed. `system` is the reduced one, without a loss, at the state.
[[nodiscard]] std::vector<std::size_t> MirrorSolutions(const AdjustmentProblem& problem,
                                                       const BlockState& state,
                                                       const ReducedSystem& system);

/// Solves once more and counts its iterations with those before; `system`, where given, becomes the
/// reduced system at the solution.
void SolveOnce(const AdjustOptions& options,
               AdjustmentProblem* problem,
               BlockState* state,
               SolveReport* solve,
               std::optional<ReducedSystem>* system,
               ProgressSink* progress);

/// Whether looks on fixed paths agree at their intersection: a position is determined, their v'Pv
/// is within its 99.9 percent point, and it lies below and on the side of every look.
[[nodiscard]] bool Agree(const std::vector<FixedPathLook>& looks,
                         const Intersection& met,
                         const Frame& frame);

/// Takes a point that was left out back into the problem where all its looks, but those that the
/// block itself rejects, meet on the corrected paths within their noise and where they look; true
/// if so. The point starts from there.
[[nodiscard]] bool TakeBack(std::size_t point, AdjustmentProblem* problem, BlockState* state);

/// Starts mirror solutions again from the intersection on the corrected paths and solves once more;
/// those that remain are left out by name. Points that were left out while corrections
/// were wrong are taken back, each once, and the solution is tested again until nothing changes.
/// `system` is the reduced system, without a loss, at the solution.
void RecoverMirrorSolutions(const AdjustOptions& options,
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
