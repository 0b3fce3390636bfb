// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/problem.h"
#include "point_sweep.h"

namespace sarblock {

/// Tests whose correlation exceeds this count as the same test.
inline constexpr double kSameTest = 0.999;
/// A point is still determined where, in its weakest direction, this part of its information is
/// left: its standard deviation grows a hundredfold at most.
inline constexpr double kMinInformationPart = 1e-4;

/// The observations of a point any one of which alone may have caused its largest |w|.
struct SuspectSet {
  double largest_w = 0.0;
  bool azimuth = false;              ///< the component of the largest |w|
  std::vector<std::uint64_t> looks;  ///< the one of the largest |w| first
  bool control = false;              ///< the known position too
  bool rest_determines = false;      ///< what is left determines the point
};

/// If k were the blunder, w_i corrected for it would be standard normal (docs/theory/quality.md,
/// eq. (14)):
///     w_i.k = (w_i - rho w_k) / sqrt(1 - rho^2)
/// so k may be the cause of the largest, w_i, unless |w_i.k| > N^-1((1 + separation) / 2). Both
/// components of a look count as the look.
[[nodiscard]] SuspectSet FindSuspects(const PointResiduals& residuals, double separation);

/// True where the point is determined without the looks (and the known position) of the set.
[[nodiscard]] bool RestDetermines(const PointResiduals& residuals, const SuspectSet& set);

/// How far a removal can affect other points: the sum of |w| sqrt(h / r) over the removed
/// observations, h the part of a residual that the corrections absorb. Any correlation with a test
/// of another point is at most sqrt(h_i h_k / (r_i r_k)), docs/theory/quality.md, eq. (15).
[[nodiscard]] double ReachOf(const PointResiduals& residuals, const SuspectSet& set);

/// True where the point's largest |w| would stay above `critical` after any removals of that
/// reach in other points.
[[nodiscard]] bool StaysSuspect(const PointResiduals& residuals, double max_reach, double critical);

/// "its observations contradict each other and none can be identified as wrong: A1, A2".
[[nodiscard]] std::string DescribeContradiction(const Block& block, const SuspectSet& set);

/// Observations that have a test.
[[nodiscard]] std::size_t CountTests(const LookQuality& quality,
                                     const std::vector<ControlQuality>& control);

/// Fills result->looks.reason from the problem, the looks dropped by a robust loss and the report.
void FillReasons(const AdjustmentProblem& problem,
                 const std::vector<std::size_t>& dropped,
                 AdjustResult* result);

/// Rounds after which the search ends, far more than a usable block needs.
inline constexpr int kMaxSearchRounds = 200;

/// A solution that leaves out more than this part of the looks as blunders, outliers or mirror
/// solutions has not found blunders: the looks share an error, and the remaining ones fit only
/// because the others are gone.
inline constexpr double kMaxLeftOut = 0.25;

/// Solves `problem` from `state` under a loss, with the looks now in use; updates both.
using SolveAgain = std::function<void(RobustLoss)>;

/// The search for blunders (data snooping, Baarda 1968), from a solved state;
/// docs/theory/quality.md.
///
/// Each round tests every observation of the solution. Above the critical value the largest |w| of
/// a point is a candidate; which observations of its point might hold the error instead is decided
/// by the correlation of the tests (blunder_search.h).
///
/// A look alone is a located blunder; it is rejected. Several looks are suspects, none of which is
/// called a blunder: all of them are left out if the rest still determines the point, else the
/// whole point is. A known position among the suspects is left out with them, but never so that
/// fewer than three control points remain. Nothing is removed where the passes would fall into more
/// components, a pass would lose its last look or the corrections would no longer be determined: it
/// is reported. Several candidates go in one round, in the order of |w|, where even the largest
/// correlation that the corrections allow between two points could not explain the one by the
/// other. Then the block is solved again from where it is. At the end looks left out whose
/// residuals turned out small are taken back, once each. `found` are findings made before, whose
/// looks and points are left out already: they are taken back in the same way. A known position is
/// left out only where a search was asked for.
///
/// Leaves `problem` and `state` at the solution without the blunders. A search that has left out
/// more than kMaxLeftOut of the looks it began with has not found blunders: it aborts, leaves
/// `problem` and `state` as they were and returns nothing.
[[nodiscard]] std::optional<SnoopingReport> SearchBlunders(const AdjustOptions& options,
                                                           const SolveAgain& solve,
                                                           AdjustmentProblem* problem,
                                                           BlockState* state,
                                                           ProgressSink* progress,
                                                           std::vector<BlunderFinding> found = {});

}  // namespace sarblock
