// SPDX-License-Identifier: Apache-2.0
// Two routes: a block whose points are taken in the order of their passes, and the same block
// adjusted as it stands. Sums differ in their order alone; the tolerances are those of the steps
// still to go.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "adjust/adjust.h"
#include "adjust/adjust_given.h"
#include "support/scene_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kPosition_m = 1e-5;  // of standard deviations of metres
constexpr double kRelative = 1e-6;

bool Ordered(const AdjustResult& result) {
  return std::any_of(result.stages.begin(), result.stages.end(), [](const StageCost& stage) {
    return stage.stage == "order";
  });
}

/// Both not given, or near each other.
template <typename Numbers>
void ExpectNear(const Numbers& a, const Numbers& b, double tolerance, const char* name) {
  ASSERT_EQ(a.size(), b.size()) << name;
  for (auto at = a.begin(), other = b.begin(); at != a.end(); ++at, ++other) {
    ASSERT_EQ(std::isnan(*at), std::isnan(*other)) << name << " " << at - a.begin();
    if (std::isnan(*at)) continue;
    const double bound = tolerance * std::max(1.0, std::abs(static_cast<double>(*other)));
    ASSERT_NEAR(*at, *other, bound) << name << " " << at - a.begin();
  }
}

template <typename Column>
void ExpectNearByThree(const Column& a, const Column& b, double tolerance, const char* name) {
  ASSERT_EQ(a.size(), b.size()) << name;
  for (std::size_t i = 0; i < a.size(); ++i) ExpectNear(a[i], b[i], tolerance, name);
}

std::vector<std::array<std::uint64_t, 3>> Named(const SnoopingReport& report) {
  std::vector<std::array<std::uint64_t, 3>> named;
  for (const BlunderFinding& finding : report.findings) {
    for (const std::uint64_t look : finding.looks) {
      named.push_back({finding.point, look, static_cast<std::uint64_t>(finding.action)});
    }
  }
  std::sort(named.begin(), named.end());
  return named;
}

void ExpectTheSame(const AdjustResult& a, const AdjustResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.assessment.verdict, b.assessment.verdict);
  EXPECT_NEAR(a.sigma0_squared, b.sigma0_squared, 1e-9);
  EXPECT_EQ(a.points.status, b.points.status);
  ASSERT_EQ(a.points.reason.size(), b.points.reason.size());
  for (std::size_t i = 0; i < a.points.reason.size(); ++i) {
    // Of looks that contradict each other alike, rounding decides which is named first.
    ASSERT_EQ(a.points.reason[i].empty(), b.points.reason[i].empty()) << i;
  }
  EXPECT_EQ(a.points.looks, b.points.looks);
  ExpectNearByThree(a.points.position_m, b.points.position_m, kPosition_m * 1e-3, "position");
  ExpectNearByThree(a.points.covariance_m2, b.points.covariance_m2, kRelative, "covariance");
  ExpectNearByThree(
      a.points.fixed_path_covariance_m2, b.points.fixed_path_covariance_m2, kRelative, "fixed");
  ExpectNear(a.points.intersection_rad, b.points.intersection_rad, kRelative, "intersection");
  ExpectNear(a.points.redundancy, b.points.redundancy, kRelative, "redundancy");
  ExpectNear(a.points.sigma_leberl_up_m, b.points.sigma_leberl_up_m, kRelative, "up");
  ExpectNear(a.points.sigma_leberl_across_m, b.points.sigma_leberl_across_m, kRelative, "across");
  ExpectNear(a.points.sigma_leberl_path_up_m, b.points.sigma_leberl_path_up_m, kRelative, "p up");
  ExpectNear(a.points.sigma_leberl_path_across_m,
             b.points.sigma_leberl_path_across_m,
             kRelative,
             "p across");
  ExpectNear(a.points.leberl_across_azimuth_rad,
             b.points.leberl_across_azimuth_rad,
             kRelative,
             "direction");
  ExpectNear(a.looks.range_residual_m, b.looks.range_residual_m, kPosition_m, "range");
  ExpectNear(a.looks.azimuth_residual_m, b.looks.azimuth_residual_m, kPosition_m, "azimuth");
  ExpectNear(a.looks.weight, b.looks.weight, kRelative, "weight");
  EXPECT_EQ(a.looks.rejected, b.looks.rejected);
  EXPECT_EQ(a.looks.reason, b.looks.reason);
  for (std::size_t k = 0; k < 2; ++k) {
    ExpectNear(a.quality.redundancy[k], b.quality.redundancy[k], 1e-5, "r");
    ExpectNear(a.quality.w[k], b.quality.w[k], 1e-4, "w");
    ExpectNear(a.quality.shift_m[k], b.quality.shift_m[k], 1e-5, "shift");
  }
  ASSERT_EQ(a.control_quality.size(), b.control_quality.size());
  for (std::size_t k = 0; k < a.control_quality.size(); ++k) {
    EXPECT_EQ(a.control_quality[k].point, b.control_quality[k].point);
    EXPECT_EQ(a.control_quality[k].component, b.control_quality[k].component);
    EXPECT_NEAR(a.control_quality[k].residual_m, b.control_quality[k].residual_m, kPosition_m);
  }
  EXPECT_EQ(a.assessment.tests.worst_control, b.assessment.tests.worst_control);
  ASSERT_EQ(a.assessment.tests.worst.size(), b.assessment.tests.worst.size());
  for (std::size_t k = 0; k < a.assessment.tests.worst.size(); ++k) {
    EXPECT_EQ(a.assessment.tests.worst[k].look, b.assessment.tests.worst[k].look);
    EXPECT_EQ(a.assessment.tests.worst[k].point, b.assessment.tests.worst[k].point);
  }
  ASSERT_EQ(a.checks.size(), b.checks.size());
  for (std::size_t k = 0; k < a.checks.size(); ++k) {
    EXPECT_EQ(a.checks[k].point, b.checks[k].point);
    EXPECT_LT((a.checks[k].error_enu_m - b.checks[k].error_enu_m).norm(), kPosition_m);
  }
  ASSERT_EQ(a.pairs.size(), b.pairs.size());
  for (std::size_t k = 0; k < a.pairs.size(); ++k) {
    ASSERT_EQ(a.pairs[k].a, b.pairs[k].a) << k;
    ASSERT_EQ(a.pairs[k].b, b.pairs[k].b) << k;
    ASSERT_LT((a.pairs[k].difference_enu_m - b.pairs[k].difference_enu_m).norm(), kPosition_m);
    ExpectNear(a.pairs[k].covariance_m2, b.pairs[k].covariance_m2, kRelative, "pair");
  }
  ASSERT_EQ(a.snooping.has_value(), b.snooping.has_value());
  if (a.snooping) {
    EXPECT_EQ(Named(*a.snooping), Named(*b.snooping));
    EXPECT_EQ(a.snooping->robust, b.snooping->robust);
  }
}

AdjustResult AdjustUnordered(const test::SceneBlock& made, const PointPairs& pairs = {}) {
  AdjustResult result = AdjustGiven(made.block, made.options, {}, pairs, nullptr, nullptr);
  DescribePaths(made.block, made.options, &result);
  return result;
}

TEST(OrderedPointsTest, GivesTheResultOfTheBlockAsItStands) {
  test::SceneBlock made = test::NetInNoOrder({"adjust.pairs=\"neighbours\""});
  made.block.looks.flags[17] |= Looks::kRejected;
  const AdjustResult expected = AdjustUnordered(made);
  EXPECT_FALSE(expected.checks.empty());
  EXPECT_FALSE(expected.pairs.empty());
  EXPECT_FALSE(expected.control_quality.empty());
  EXPECT_FALSE(expected.assessment.tests.worst.empty());
  const AdjustResult result = Adjust(made.block, made.options);
  ASSERT_TRUE(Ordered(result));
  ExpectTheSame(result, expected);
  const AdjustResult in_place = Adjust(&made.block, made.options);
  EXPECT_EQ(in_place.points.position_m, result.points.position_m);
  EXPECT_EQ(in_place.looks.range_residual_m, result.looks.range_residual_m);
}

TEST(OrderedPointsTest, NamesTheSameLooks) {
  test::SceneBlock made =
      test::NetInNoOrder({"adjust.quality.snooping=\"iterative\"", "adjust.quality.alpha=1e-6"});
  for (std::size_t i = 40; i < made.block.looks.size(); i += 6007) {
    made.block.looks.range_m[i] += 9.0;
  }
  const AdjustResult expected = AdjustUnordered(made);
  ASSERT_TRUE(expected.snooping.has_value());
  EXPECT_GE(expected.snooping->findings.size(), 3U);
  ExpectTheSame(Adjust(made.block, made.options), expected);
}

/// Hand arithmetic: points 2, 0, 1 with three, one and two looks stand at the places 0, 1, 2.
TEST(OrderedPointsTest, MovesWhatIsListedByLookAndByPoint) {
  Block block;
  for (const char* id : {"P0", "P1", "P2"}) {
    block.points.ids.Append(id);
    block.points.role.push_back(PointRole::kTie);
    block.points.given_m.emplace_back(Eigen::Vector3d::Zero());
  }
  block.looks.offsets = {0, 1, 3, 6};
  block.looks.pass.assign(6, 0);
  const OrderedPoints ordered({2, 0, 1}, &block);
  EXPECT_THAT(block.looks.offsets, testing::ElementsAre(0U, 3U, 4U, 6U));
  AdjustResult result;
  result.points.looks = {3, 1, 2};
  result.points.reason = {"two", "zero", "one"};
  result.looks.weight = {0.3F, 0.4F, 0.5F, 0.0F, 0.1F, 0.2F};
  result.looks.reason = {RejectReason::kGiven, {}, {}, RejectReason::kRobust, {}, {}};
  result.snooping.emplace();
  result.snooping->robust = {1, 5};  // of the points 2 and 1
  result.snooping->findings.push_back({.point = 0, .looks = {2}, .note = {}});
  result.snooping->findings.push_back({.point = 2, .looks = {4, 5}, .note = {}});  // point 1
  result.assessment.tests.worst.push_back({.look = 3, .point = 1});                // point 0
  result.checks.push_back({.point = 0, .chi_square = 2.5});
  result.checks.push_back({.point = 1, .chi_square = 0.5});
  result.control_quality.push_back({.point = 0, .component = 2});
  result.control_quality.push_back({.point = 2, .component = 1});
  result.control_quality.push_back({.point = 2, .component = 2});
  result.assessment.tests.worst_control = 2;
  ordered.RestoreResult(true, &result);
  EXPECT_THAT(result.points.looks, testing::ElementsAre(1U, 2U, 3U));
  EXPECT_THAT(result.points.reason, testing::ElementsAre("zero", "one", "two"));
  EXPECT_THAT(result.looks.weight, testing::ElementsAre(0.0F, 0.1F, 0.2F, 0.3F, 0.4F, 0.5F));
  EXPECT_EQ(result.looks.reason[0], RejectReason::kRobust);
  EXPECT_EQ(result.looks.reason[3], RejectReason::kGiven);
  EXPECT_THAT(result.snooping->robust, testing::ElementsAre(2U, 4U));
  EXPECT_EQ(result.snooping->findings[0].point, 1U);
  EXPECT_EQ(result.snooping->findings[1].point, 2U);
  EXPECT_THAT(result.snooping->findings[1].looks, testing::ElementsAre(5U));
  EXPECT_THAT(result.snooping->findings[0].looks, testing::ElementsAre(1U, 2U));
  EXPECT_EQ(result.assessment.tests.worst[0].look, 0U);
  EXPECT_EQ(result.assessment.tests.worst[0].point, 0U);
  EXPECT_EQ(result.checks[0].point, 0U);
  EXPECT_EQ(result.checks[0].chi_square, 0.5);
  EXPECT_EQ(result.checks[1].point, 2U);
  EXPECT_EQ(result.control_quality[0].point, 1U);
  EXPECT_EQ(result.control_quality[2].point, 2U);
  EXPECT_EQ(result.assessment.tests.worst_control, 1U);
}

TEST(OrderedPointsTest, KeepsPairsAsTheyWereAsked) {
  test::SceneBlock made = test::NetInNoOrder({});
  made.options.pairs = PairChoice::kList;
  const PointPairs asked = {{4001, 17}, {17, 23}, {5003, 100}};
  const AdjustResult expected = AdjustUnordered(made, asked);
  ASSERT_EQ(expected.pairs.size(), 3U);
  const AdjustResult result = Adjust(made.block, made.options, asked);
  ASSERT_TRUE(Ordered(result));
  ExpectTheSame(result, expected);
}

/// Figures of drawn noise are those of their points: the points without looks have none.
TEST(OrderedPointsTest, ListsDrawnNoiseByPoint) {
  test::SceneBlock made = test::NetInNoOrder({"adjust.covariance=\"montecarlo\""});
  made.options.montecarlo_runs = 3;
  const std::vector<std::uint32_t> starved = {123, 4567};
  for (const std::uint32_t point : starved) {
    const auto& offsets = made.block.looks.offsets;
    for (std::uint64_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      made.block.looks.flags[i] |= Looks::kRejected;
    }
  }
  const AdjustResult result = Adjust(made.block, made.options);
  ASSERT_TRUE(Ordered(result));
  ASSERT_TRUE(result.montecarlo.has_value());
  for (std::uint32_t point = 0; point < made.block.points.size(); ++point) {
    const bool solved = IsSolved(result.points.status[point]);
    ASSERT_EQ(solved, std::find(starved.begin(), starved.end(), point) == starved.end());
    ASSERT_EQ(std::isnan(result.montecarlo->square[point]), !solved) << point;
    ASSERT_EQ(std::isnan(result.montecarlo->sample_m2[point][0]), !solved) << point;
  }
}

/// A pair is the first point with the second, in the axes at the first. Closed form.
TEST(OrderedPointsTest, TurnsPairsToTheAxesOfTheirFirstPoint) {
  Block block;
  block.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const std::vector<Eigen::Vector3d> p_m = {
      {4.0e6, 1.1e6, 4.83e6}, {4.1e6, 1.0e6, 4.77e6}, {4.2e6, 0.7e6, 4.73e6}};
  for (const char* id : {"P0", "P1", "P2"}) {
    block.points.ids.Append(id);
    block.points.role.push_back(PointRole::kTie);
    block.points.given_m.emplace_back(Eigen::Vector3d::Zero());
    block.looks.offsets.push_back(0);
  }
  const OrderedPoints ordered({2, 0, 1}, &block);
  AdjustResult result;
  result.points.position_m = {p_m[2], p_m[0], p_m[1]};
  Eigen::Matrix3d c_m2;  // of the difference, in the axes of the frame
  c_m2 << 3.0, 0.7, -0.3, 0.7, 2.0, 0.4, -0.3, 0.4, 5.0;
  const auto pair_at =
      [&](std::uint32_t a, std::uint32_t b, std::size_t first, std::size_t second) {
        const Eigen::Matrix3d enu = block.frame.EnuFromFrame(p_m[first]);
        PairResult pair;
        pair.a = a;
        pair.b = b;
        pair.difference_enu_m = enu * (p_m[second] - p_m[first]);
        pair.covariance_m2 = SymmetricOf(enu * c_m2 * enu.transpose());
        return pair;
      };
  result.pairs = {pair_at(0, 1, 2, 0), pair_at(1, 2, 0, 1)};
  ordered.RestoreResult(true, &result);
  ASSERT_EQ(result.pairs.size(), 2U);
  const std::vector<PairResult> expected = {pair_at(0, 1, 0, 1), pair_at(0, 2, 0, 2)};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(result.pairs[k].a, expected[k].a);
    EXPECT_EQ(result.pairs[k].b, expected[k].b);
    EXPECT_LT((result.pairs[k].difference_enu_m - expected[k].difference_enu_m).norm(), 1e-8);
    ExpectNear(result.pairs[k].covariance_m2, expected[k].covariance_m2, 1e-12, "pair");
  }
}

void ExpectTheSameBlock(const Block& a, const Block& b) {
  for (std::size_t point = 0; point < b.points.size(); ++point) {
    ASSERT_EQ(a.points.ids[point], b.points.ids[point]);
  }
  EXPECT_EQ(a.looks.offsets, b.looks.offsets);
  EXPECT_EQ(a.looks.pass, b.looks.pass);
  EXPECT_EQ(a.looks.range_m, b.looks.range_m);
  EXPECT_EQ(a.looks.time_s, b.looks.time_s);
}

TEST(OrderedPointsTest, LeavesTheBlockAsItWasAlsoByARefusal) {
  test::SceneBlock made = test::NetInNoOrder({"adjust.covariance=\"none\""});
  const Block before = made.block;
  EXPECT_TRUE(Ordered(Adjust(&made.block, made.options)));
  ExpectTheSameBlock(made.block, before);
  made.options.memory_mib = 0.01;
  EXPECT_THROW(static_cast<void>(Adjust(&made.block, made.options)), InputError);
  ExpectTheSameBlock(made.block, before);
}

}  // namespace
}  // namespace sarblock
