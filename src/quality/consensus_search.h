// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <optional>
#include <string>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include "solve/reduced_engine.h"
#include "solve/weak_directions.h"

namespace sarblock {

/// A solution in the making, as the rooms of the adjustment hand it on.
struct Solution {
  AdjustmentProblem* problem = nullptr;
  BlockState* state = nullptr;
  SolveReport* solve = nullptr;
  std::optional<ReducedSystem>* system = nullptr;  ///< without a loss, at the state
  PointDefects* defects = nullptr;
};

/// True where a correction is farther from what its prior says than any prior allows: a pass may
/// have settled in the mirror image of its place.
[[nodiscard]] bool ContradictsPriors(const AdjustmentProblem& problem, const BlockState& state);

/// The first pass that lost two looks at control points or more, and as many as it keeps: they
/// decide nothing, another path may fit those that went.
[[nodiscard]] std::optional<std::size_t> PassThatLosesControl(const AdjustmentProblem& problem);

/// Whether a solution as it was asked for is one.
enum class Contradiction {
  kNone,
  kTest,  ///< after a search or under a loss, which leave out what is wrong, the global test fails,
          ///< or a pass loses more looks than chance explains beside the others
  kGross,  ///< not converged, points led to where no look looks, priors contradicted, a quarter of
           ///< the looks gone, or half of those that decide about a pass, or more v'Pv than wrong
           ///< standard deviations explain
};
[[nodiscard]] Contradiction FindContradiction(const AdjustOptions& options,
                                              const Solution& solution);

/// Solves a block whose least-squares solution contradicts itself once more by consensus
/// (solve/consensus.h), least squares, and a search for blunders that takes back what was left out
/// and fits. Keeps the old solution and returns no report if there is no consensus, if too many
/// observations would be left out for single errors, or if all agree.
struct ConsensusOutcome {
  std::optional<SnoopingReport> adopted;
  bool agreed = false;  ///< there is a consensus, adopted or not
};
[[nodiscard]] ConsensusOutcome SearchByConsensus(const AdjustOptions& options,
                                                 const Solution& solution,
                                                 ProgressSink* progress);

/// What such a search left out, for people.
[[nodiscard]] std::string DescribeConsensus(const AdjustmentProblem& problem,
                                            const SnoopingReport& report);

}  // namespace sarblock
