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

/// A solution under construction, as it is passed between the steps of the adjustment.
struct Solution {
  AdjustmentProblem* problem = nullptr;
  BlockState* state = nullptr;
  SolveReport* solve = nullptr;
  std::optional<ReducedSystem>* system = nullptr;  ///< without a loss, at the state
  PointDefects* defects = nullptr;
};

/// True where a correction is farther from its prior value than any prior allows: a pass may have
/// converged to the mirror image of its place.
[[nodiscard]] bool ContradictsPriors(const AdjustmentProblem& problem, const BlockState& state);

/// The first pass that lost two or more looks at control points, and at least as many as it keeps:
/// its path is then undecided, since another one may fit the lost looks.
[[nodiscard]] std::optional<std::size_t> PassThatLosesControl(const AdjustmentProblem& problem);

/// How a solution contradicts itself, if it does, from least to most.
enum class Contradiction {
  kNone,
  kTest,  ///< although a search or a loss left out wrong looks, the global test fails, or a pass
          ///< lost more looks than chance explains, compared with the others
  kUnsolved,  ///< not converged: of the looks nothing is known
  kGross,     ///< points at mirror solutions, priors contradicted, a quarter of the looks left out,
              ///< or half of those that decide about a pass, or more v'Pv than wrong standard
              ///< deviations explain
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

/// The looks and points that such a search left out, in words.
[[nodiscard]] std::string DescribeConsensus(const AdjustmentProblem& problem,
                                            const SnoopingReport& report);

}  // namespace sarblock
