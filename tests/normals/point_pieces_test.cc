// SPDX-License-Identifier: Apache-2.0
// The sum over points is cut into pieces that depend on the block alone: its bytes do not depend on
// the threads, and what it takes is counted.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "core/threads.h"
#include "normals/pieces.h"
#include "normals/reduced_system.h"
#include "support/small_blocks.h"
#include "support/thread_ranks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Points seen by three of 40 passes that follow one another, in the order of their passes or not.
test::KnownBlock Strip(std::size_t points, bool shuffled) {
  test::BlockPlan plan;
  plan.points = points;
  plan.looks_per_point = 3;
  plan.extent_m = 870.0;
  plan.relief_m = 130.0;
  plan.sigma.range_m = 0.7;
  plan.sigma.azimuth = 0.9;
  for (std::size_t i = 0; i < 40; ++i) {
    const auto at = static_cast<double>(i);
    plan.passes.push_back({i % 2 == 0 ? LookSide::kLeft : LookSide::kRight,
                           std::fmod(47.3 * at, 360.0),
                           7000.0 + 131.0 * at,
                           6100.0 + 97.0 * at});
  }
  test::KnownBlock known = test::MakeBlock(plan);
  if (!shuffled) {  // by the first pass, a stable sort of the points with their looks
    Looks& looks = known.block.looks;
    std::vector<std::size_t> order(points);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return looks.pass[looks.offsets[a]] < looks.pass[looks.offsets[b]];
    });
    Looks sorted = looks;
    std::vector<Eigen::Vector3d> truth_m(points);
    std::size_t at = 0;
    for (std::size_t k = 0; k < points; ++k) {
      truth_m[k] = known.truth_m[order[k]];
      sorted.offsets[k] = at;
      for (std::size_t i = looks.offsets[order[k]]; i < looks.offsets[order[k] + 1]; ++i, ++at) {
        sorted.pass[at] = looks.pass[i];
        sorted.time_s[at] = looks.time_s[i];
        sorted.range_m[at] = looks.range_m[i];
      }
    }
    looks = sorted;
    known.truth_m = truth_m;
  }
  return known;
}

std::vector<CorrectionGroup> Positions(int degree) {
  PositionCorrection position;
  position.degree = degree;
  position.prior_sigma_m.fill(std::vector<double>(static_cast<std::size_t>(degree) + 1, 2.3));
  return {{"position", position, {}, false}};
}

BlockState StateAt(const test::KnownBlock& known, AdjustmentProblem* problem) {
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(known.truth_m.size(), {0.31, -0.22, 0.17});
  state.corrections.setConstant(problem->layout.size(), 0.13);
  UpdateWeights(state, problem);
  return state;
}

template <typename Values>
bool SameBytes(const Values& a, const Values& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(*a.data())) ==
             0;
}

std::size_t WholeOf(const BlockPattern& pattern) {
  return pattern.ValueBegin(pattern.slot_count()) +
         PointPiece::kVectors * static_cast<std::size_t>(pattern.rows());
}

// Invariance: the threads decide how many pieces are summed at a time, never what they add up to.
TEST(PointPiecesTest, ThreadsDoNotChangeAByteOfTheSums) {
  const test::KnownBlock known = Strip(9300, true);
  AdjustmentProblem problem(known.block, Positions(11));
  const BlockState state = StateAt(known, &problem);
  for (const double damping : {0.0, 1e-3}) {
    std::vector<double> first_s;
    Eigen::VectorXd first_side, first_diagonal;
    double first_cost = 0.0;
    for (const int threads : {1, 2, 3, 8}) {
      const ThreadLimit limit(threads);
      ReducedSystem system(problem);
      EXPECT_LT(system.pieces().GroupEnd(0, threads), system.pieces().size());
      system.Form(state, {}, nullptr, damping);
      const std::span<const double> values = system.matrix().sparse.values();
      if (threads == 1) {
        first_s.assign(values.begin(), values.end());
        first_side = system.right_side();
        first_diagonal = system.full_diagonal();
        first_cost = system.cost();
      }
      EXPECT_TRUE(SameBytes(std::vector<double>(values.begin(), values.end()), first_s)) << threads;
      EXPECT_TRUE(SameBytes(system.right_side(), first_side)) << threads;
      EXPECT_TRUE(SameBytes(system.full_diagonal(), first_diagonal)) << threads;
      EXPECT_EQ(system.cost(), first_cost) << threads;
    }
  }
}

// Invariance: what ranks make of their pieces is what one process makes, weights included, in the
// order of the block and in that of the passes.
TEST(PointPiecesTest, RanksDoNotChangeAByteOfTheSums) {
  for (const bool shuffled : {false, true}) {
    const test::KnownBlock known = Strip(5000, shuffled);
    AdjustmentProblem problem(known.block, Positions(11));
    const BlockState state = StateAt(known, &problem);
    BlockState moved = state;
    moved.corrections.setConstant(1.9);
    std::vector<LookWeights> weights = problem.weights;
    ReducedSystem alone(problem);
    alone.Form(moved, {.renewed = &weights}, nullptr);
    EXPECT_FALSE(SameBytes(weights, problem.weights));
    for (const int size : {2, 3}) {
      test::RunRanks(size, [&](Ranks*) {
        std::vector<LookWeights> shared = problem.weights;
        ReducedSystem system(problem);
        EXPECT_GT(system.pieces().size(), 32U);
        system.Form(moved, {.renewed = &shared}, nullptr);
        EXPECT_TRUE(SameBytes(system.matrix().sparse.values(), alone.matrix().sparse.values()));
        EXPECT_TRUE(SameBytes(system.right_side(), alone.right_side()));
        EXPECT_TRUE(SameBytes(system.full_diagonal(), alone.full_diagonal()));
        EXPECT_TRUE(SameBytes(shared, weights));
        EXPECT_EQ(system.cost(), alone.cost());
        EXPECT_EQ(system.weight_change(), alone.weight_change());
        EXPECT_EQ(system.gradient(), alone.gradient());
        EXPECT_EQ(system.point_step_square(), alone.point_step_square());
      });
    }
  }
}

// Second route: a block cut into one piece is summed point by point.
TEST(PointPiecesTest, PiecesAddUpToTheSumPointByPoint) {
  test::KnownBlock known = Strip(127, false);
  AdjustmentProblem one(known.block, Positions(1));
  const BlockState state = StateAt(known, &one);
  ReducedSystem whole(one);
  ASSERT_EQ(whole.pieces().size(), 1U);
  whole.Form(state, {}, nullptr);
  // The same points again and again: every sum is an exact multiple but for its rounding.
  constexpr std::size_t kTimes = 32;
  test::KnownBlock many = known;
  Looks& looks = many.block.looks;
  for (std::size_t k = 1; k < kTimes; ++k) {
    const std::size_t before = looks.size();
    for (std::size_t j = 0; j < 127; ++j) {
      many.block.points.ids.Append("again" + std::to_string(127 * k + j));
      many.block.points.role.push_back(known.block.points.role[j]);
      many.block.points.given_m.push_back(known.block.points.given_m[j]);
      many.truth_m.push_back(known.truth_m[j]);
      looks.offsets.push_back(before + known.block.looks.offsets[j + 1]);
    }
    for (std::size_t i = 0; i < known.block.looks.size(); ++i) {
      looks.pass.push_back(known.block.looks.pass[i]);
      looks.flags.push_back(known.block.looks.flags[i]);
      looks.time_s.push_back(known.block.looks.time_s[i]);
      looks.range_m.push_back(known.block.looks.range_m[i]);
      if (!looks.cone.empty()) looks.cone.push_back(known.block.looks.cone[i]);
    }
  }
  AdjustmentProblem repeated(many.block, Positions(1));
  BlockState state_of_many = StateAt(many, &repeated);
  ReducedSystem pieces(repeated);
  ASSERT_GT(pieces.pieces().size(), 16U);
  pieces.Form(state_of_many, {}, nullptr);
  // Priors, 1 / 2.3^2 on every diagonal element, are added once.
  const double prior = 1.0 / (2.3 * 2.3), times = kTimes;
  const Eigen::MatrixXd expected =
      kTimes *
      (whole.matrix().ToDense() - prior * Eigen::MatrixXd::Identity(whole.rows(), whole.rows()));
  const Eigen::MatrixXd sum =
      pieces.matrix().ToDense() - prior * Eigen::MatrixXd::Identity(whole.rows(), whole.rows());
  EXPECT_LT((sum - expected).norm(), 1e-13 * expected.norm());
  const double of_priors = 0.5 * prior * 0.13 * 0.13 * whole.rows();
  EXPECT_NEAR(pieces.cost() - of_priors, times * (whole.cost() - of_priors), 1e-12 * pieces.cost());
}

// By count, whatever the order of the points and the threads: partial sums never take more than
// twice what they are summed to, and two of them are summed side by side at least.
TEST(PointPiecesTest, PartialSumsTakeTwiceTheWholeAtMostAndAreNeverSerial) {
  for (const bool shuffled : {false, true}) {
    const test::KnownBlock known = Strip(5000, shuffled);
    const AdjustmentProblem problem(known.block, Positions(7));
    const ReducedPattern found = FindPattern(problem, true);
    const PointPieces pieces(problem, *found.pattern, found.bordered, 0);
    const std::size_t whole = WholeOf(*found.pattern);
    EXPECT_EQ(pieces.limit(), 2 * whole);
    ASSERT_GT(pieces.size(), 32U);
    for (const int threads : {1, 2, 8, 64}) {
      EXPECT_LE(pieces.MaxDoubles(threads), 2 * whole);
      for (std::size_t first = 0; first < pieces.size();) {
        const std::size_t end = pieces.GroupEnd(first, threads);
        EXPECT_GE(end - first, std::min<std::size_t>(2, pieces.size() - first));
        first = end;
      }
    }
  }
}

// By count: neighbours in the order of the pieces share blocks, so that a piece touches a few of
// the 40 passes; in the order of a shuffled block each would touch nearly all.
TEST(PointPiecesTest, TakesShuffledPointsInTheOrderOfTheirPasses) {
  const test::KnownBlock known = Strip(5000, true);
  const AdjustmentProblem problem(known.block, Positions(11));
  const ReducedPattern found = FindPattern(problem, true);
  const PointPieces pieces(problem, *found.pattern, found.bordered, 0);
  std::vector<std::size_t> points;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    EXPECT_LE(pieces[k].blocks.size(), 8U) << k;
    for (std::size_t place = pieces[k].begin; place < pieces[k].end; ++place) {
      points.push_back(pieces.PointAt(place));
    }
  }
  EXPECT_FALSE(std::is_sorted(points.begin(), points.end()));
  std::sort(points.begin(), points.end());
  std::vector<std::size_t> all(known.block.points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  EXPECT_EQ(points, all);  // each once
}

// By count: what the prediction says of partial sums and matrix is what is allocated.
TEST(PointPiecesTest, TheSystemNeedsWhatIsCounted) {
  const test::KnownBlock known = Strip(2000, false);
  const AdjustmentProblem problem(known.block, Positions(2));
  ReducedSystem system(problem);
  const SystemNeeds needs = system.Needs(2);
  EXPECT_EQ(needs.border, 0U);
  EXPECT_EQ(needs.partial_sums, system.pieces().MaxDoubles(2));
  const BlockState state = [&] {
    BlockState at;
    at.start_m = known.truth_m;
    at.displacement_m.assign(known.truth_m.size(), Eigen::Vector3d::Zero());
    at.corrections.setZero(problem.layout.size());
    return at;
  }();
  EXPECT_EQ(system.matrix().rows(), 0);  // nothing is allocated before it is formed
  system.Form(state, {}, nullptr);
  EXPECT_EQ(needs.matrix, system.matrix().sparse.values().size());
  // Hand count: 2,000 points of three looks in three passes of nine corrections each: 27 columns,
  // three rows left of six.
  EXPECT_EQ(needs.operations, 2000 * 0.5 * 27 * 27 * 3);
}

}  // namespace
}  // namespace sarblock
