// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/paper_block.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Action = BlunderFinding::Action;

AdjustOptions Searching(Snooping snooping = Snooping::kIterative) {
  PositionCorrection position;
  position.prior_sigma_m.fill({3.0});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  options.quality.snooping = snooping;
  options.quality.family_wise = FamilyWise::kSidak;
  return options;
}

/// Four passes, 30 points seen by `looks` of them, five of them control.
test::KnownBlock Noisy(std::size_t looks, std::uint64_t seed = 7) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 30;
  plan.looks_per_point = looks;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(seed, 1.0, &known);
  for (const std::size_t point : {0U, 6U, 12U, 18U, 24U}) {
    test::AddKnownPoint(point, {0.4, 0.4, 0.4}, &known);
  }
  return known;
}

void ShiftRange(std::uint64_t look, double sigmas, Block* block) {
  block->looks.range_m[look] += sigmas * block->SigmaOf(look).range_m;
}

std::set<std::uint64_t> RejectedLooks(const AdjustResult& result) {
  std::set<std::uint64_t> looks;
  for (std::uint64_t i = 0; i < result.looks.rejected.size(); ++i) {
    if (result.looks.rejected[i] != 0) looks.insert(i);
  }
  return looks;
}

// Invariance: nothing is wrong, nothing is done, and the result is that without the search.
TEST(BlunderSearchTest, LeavesAGoodBlockAlone) {
  const test::KnownBlock known = Noisy(0);
  AdjustOptions options = Searching();
  const AdjustResult searched = Adjust(known.block, options);
  options.quality.snooping = Snooping::kNone;
  const AdjustResult plain = Adjust(known.block, options);
  ASSERT_TRUE(searched.snooping.has_value());
  EXPECT_TRUE(searched.snooping->findings.empty());
  EXPECT_TRUE(RejectedLooks(searched).empty());
  EXPECT_FALSE(plain.snooping.has_value());
  EXPECT_EQ(searched.points.position_m[3], plain.points.position_m[3]);
}

/// The range of every second look by 20 to 60 sigma of either sign.
test::KnownBlock HalfWrong() {
  test::KnownBlock known = Noisy(0);
  for (std::uint64_t i = 0; i < known.block.looks.size(); i += 2) {
    const double size = 20.0 + 40.0 * std::abs(std::sin(1.7 * static_cast<double>(i)));
    ShiftRange(i, i % 4 == 0 ? size : -size, &known.block);
  }
  return known;
}

bool AnyStartsWith(const std::vector<std::string>& texts, const std::string& begin) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
    return text.rfind(begin, 0) == 0;
  });
}

// Invariance: what a search would leave out is too much, and the result is that without it.
TEST(BlunderSearchTest, GivesWayWhereMoreThanAQuarterOfTheLooksWouldGo) {
  const test::KnownBlock known = HalfWrong();
  for (const auto& [snooping, consensus] : {std::pair{Snooping::kIterative, false},
                                            std::pair{Snooping::kRobust, false},
                                            std::pair{Snooping::kIterative, true}}) {
    AdjustOptions options = Searching(snooping);
    options.quality.consensus = consensus;
    const AdjustResult result = Adjust(known.block, options);
    EXPECT_FALSE(result.snooping.has_value());
    EXPECT_TRUE(RejectedLooks(result).empty());
    EXPECT_EQ(result.assessment.verdict, Verdict::kNotAccepted);
    EXPECT_TRUE(AnyStartsWith(result.assessment.reasons, "the search for blunders was aborted"));
    options.quality.snooping = Snooping::kNone;
    const AdjustResult plain = Adjust(known.block, options);
    EXPECT_FALSE(AnyStartsWith(plain.assessment.reasons, "the search for blunders was aborted"));
    for (std::size_t j = 0; j < known.block.points.size(); ++j) {
      // Both end at the same minimum, to the tolerance of the steps.
      EXPECT_LT((result.points.position_m[j] - plain.points.position_m[j]).norm(), 1e-4) << j;
    }
  }
}

TEST(BlunderSearchTest, IsNotMadeWhereThereIsNoSolution) {
  test::KnownBlock known = Noisy(0);
  Looks& looks = known.block.looks;
  for (std::uint64_t i = 0; i < looks.size(); ++i) {
    if (looks.pass[i] == 1) looks.range_m[i] *= 0.001;  // kilometres
  }
  AdjustOptions options = Searching();
  options.max_iterations = 4;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_EQ(result.status, AdjustStatus::kNotConverged);
  EXPECT_FALSE(result.snooping.has_value());
  EXPECT_EQ(result.assessment.verdict, Verdict::kNotAccepted);
  EXPECT_TRUE(AnyStartsWith(result.warnings, "no search for blunders was made"));
}

// Two routes: the search against an adjustment of the block whose file rejects the same look.
TEST(BlunderSearchTest, LocatesAWrongRangeAmongFourLooks) {
  test::KnownBlock known = Noisy(0);
  const std::uint64_t wrong = known.block.looks.offsets[10] + 3;  // the crossing pass
  ShiftRange(wrong, 25.0, &known.block);
  const AdjustResult result = Adjust(known.block, Searching());
  ASSERT_EQ(result.snooping->findings.size(), 1U);
  const BlunderFinding& finding = result.snooping->findings[0];
  EXPECT_TRUE(finding.located());
  EXPECT_EQ(finding.point, 10U);
  EXPECT_EQ(finding.looks, std::vector<std::uint64_t>{wrong});
  EXPECT_FALSE(finding.azimuth);
  EXPECT_EQ(finding.action, Action::kRejected);
  EXPECT_EQ(RejectedLooks(result), std::set<std::uint64_t>{wrong});
  EXPECT_EQ(result.looks.reason[wrong], RejectReason::kBlunder);

  known.block.looks.flags[wrong] |= Looks::kRejected;
  AdjustOptions options = Searching();
  options.quality.snooping = Snooping::kNone;
  const AdjustResult again = Adjust(known.block, options);
  EXPECT_EQ(again.looks_used, result.looks_used);
  EXPECT_EQ(again.looks.reason[wrong], RejectReason::kGiven);
  // Both stop within 1e-6 sigma of the solution; metres here.
  EXPECT_LT((again.points.position_m[10] - result.points.position_m[10]).norm(), 1e-5);
  EXPECT_NEAR(again.sigma0_squared, result.sigma0_squared, 1e-8);
}

// Theory: a tie point with two looks has one degree of freedom. Nothing is claimed of the look; the
// point goes, with the names of both.
TEST(BlunderSearchTest, ClaimsNothingOfTwoLooks) {
  test::KnownBlock known = Noisy(2);
  const std::uint64_t wrong = known.block.looks.offsets[9] + 1;
  known.block.looks.time_s[wrong] += 0.2;  // 35 m; the one degree of freedom is along the flight
  const AdjustResult result = Adjust(known.block, Searching());
  ASSERT_EQ(result.snooping->findings.size(), 1U);
  const BlunderFinding& finding = result.snooping->findings[0];
  EXPECT_FALSE(finding.located());
  EXPECT_EQ(finding.point, 9U);
  EXPECT_EQ(std::set<std::uint64_t>(finding.looks.begin(), finding.looks.end()),
            (std::set<std::uint64_t>{wrong - 1, wrong}));
  EXPECT_EQ(finding.action, Action::kPointLeftOut);
  EXPECT_EQ(result.points.status[9], PointStatus::kApart);
  EXPECT_TRUE(result.points.position_m[9].allFinite());
  EXPECT_NE(result.points.reason[9].find("contradict"), std::string::npos);
  EXPECT_EQ(result.looks.reason[wrong], RejectReason::kSuspect);
  EXPECT_EQ(result.looks.reason[wrong - 1], RejectReason::kSuspect);
}

/// Points of three parallel passes beside a row of controls.
test::KnownBlock Parallel() {
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 12; ++i) {
    points_m.emplace_back(211.0 * i, 11300.0 + 517.0 * (i % 5), 37.0 * (i % 3));
  }
  test::KnownBlock known;
  known.truth_m = points_m;
  known.block = test::MakePaperBlock({{0.0, 9100.0}, {2900.0, 9400.0}, {5300.0, 9200.0}}, points_m);
  test::AddNoise(3, 1.0, &known);
  for (const std::size_t point : {0U, 4U, 8U, 11U})
    test::AddKnownPoint(point, {0.3, 0.3, 0.3}, &known);
  return known;
}

// Theory: three parallel passes have one range too many for the two coordinates across the flight,
// so their range tests are one; of three azimuths two are too many, and they can be distinguished.
TEST(BlunderSearchTest, KnowsThatParallelRangesCannotBeToldApart) {
  test::KnownBlock known = Parallel();
  const std::uint64_t look = known.block.looks.offsets[6] + 1;
  ShiftRange(look, 80.0, &known.block);
  const AdjustResult by_range = Adjust(known.block, Searching());
  ASSERT_EQ(by_range.snooping->findings.size(), 1U);
  EXPECT_EQ(by_range.snooping->findings[0].looks.size(), 3U);
  EXPECT_EQ(by_range.points.status[6], PointStatus::kApart);

  known = Parallel();
  known.block.looks.time_s[look] += 40.0 * known.block.SigmaOf(look).azimuth / 211.0;
  const AdjustResult by_azimuth = Adjust(known.block, Searching());
  ASSERT_EQ(by_azimuth.snooping->findings.size(), 1U);
  EXPECT_EQ(by_azimuth.snooping->findings[0].looks, std::vector<std::uint64_t>{look});
  EXPECT_TRUE(by_azimuth.snooping->findings[0].azimuth);
  EXPECT_EQ(by_azimuth.points.status[6], PointStatus::kAdjusted);
}

TEST(BlunderSearchTest, ReleasesAWrongControlPointWhileThreeRemain) {
  test::KnownBlock known = Noisy(0);
  known.block.points.given_m[12] += Eigen::Vector3d(0.0, 0.0, 20.0);
  const AdjustResult result = Adjust(known.block, Searching());
  ASSERT_EQ(result.snooping->findings.size(), 1U);
  EXPECT_EQ(result.snooping->findings[0].point, 12U);
  EXPECT_TRUE(result.snooping->findings[0].control);
  EXPECT_TRUE(result.snooping->findings[0].located());
  EXPECT_EQ(result.snooping->findings[0].action, Action::kControlReleased);
  EXPECT_TRUE(RejectedLooks(result).empty());
  // The point is now where its looks are: within five of its sigmas of the truth.
  const SymmetricEnu& q = result.points.covariance_m2[12];
  EXPECT_LT((result.points.position_m[12] - known.truth_m[12]).norm(),
            5.0 * std::sqrt(q[0] + q[1] + q[2]));

  for (const std::size_t point : {6U, 24U}) {
    known.block.points.role[point] = PointRole::kTie;
    std::erase_if(known.block.points.known, [&](const auto& k) { return k.point == point; });
  }
  const AdjustResult kept = Adjust(known.block, Searching());
  ASSERT_FALSE(kept.snooping->findings.empty());
  EXPECT_TRUE(std::all_of(kept.snooping->findings.begin(),
                          kept.snooping->findings.end(),
                          [](const auto& f) { return !f.control || f.action == Action::kKept; }));
}

// A block of two halves that one point holds together: its wrong look is named and stays.
TEST(BlunderSearchTest, DoesNotCutABlockInTwo) {
  test::KnownBlock known = Noisy(0);
  Looks& looks = known.block.looks;
  for (std::size_t point = 0; point < known.block.points.size(); ++point) {
    for (std::uint64_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const bool first_half = looks.pass[i] == 0 || looks.pass[i] == 2;
      const bool keep = point == 15 ? looks.pass[i] != 3 : first_half == (point % 2 == 0);
      if (!keep) looks.flags[i] |= Looks::kRejected;
    }
  }
  const std::uint64_t bridge = looks.offsets[15] + 1;
  ASSERT_EQ(looks.pass[bridge], 1U);
  looks.time_s[bridge] += 0.6;  // a hundred metres
  const AdjustResult result = Adjust(known.block, Searching());
  const auto found = std::find_if(result.snooping->findings.begin(),
                                  result.snooping->findings.end(),
                                  [](const auto& f) { return f.point == 15; });
  ASSERT_NE(found, result.snooping->findings.end());
  EXPECT_EQ(found->action, Action::kKept);
  EXPECT_NE(found->note.find("not be connected"), std::string::npos) << found->note;
  EXPECT_EQ(result.looks.rejected[bridge], 0);
  EXPECT_EQ(result.points.status[15], PointStatus::kAdjusted);
}

// Seeded: one look in twelve is wrong by 30 to 90 sigmas. From the robust start none stays in, and
// no more than one look in ten is lost that is good.
TEST(BlunderSearchTest, FindsManyBlundersFromARobustStart) {
  test::KnownBlock known = Noisy(0, 23);
  std::set<std::uint64_t> wrong;
  for (std::uint64_t look = 5; look < known.block.looks.size(); look += 12) {
    ShiftRange(look, 30.0 + 0.5 * static_cast<double>(look), &known.block);
    wrong.insert(look);
  }
  ASSERT_EQ(wrong.size(), 10U);
  const AdjustResult result = Adjust(known.block, Searching(Snooping::kRobust));
  EXPECT_TRUE(result.usable());
  std::size_t good_lost = 0;
  for (std::size_t point = 0; point < known.block.points.size(); ++point) {
    for (std::uint64_t i = known.block.looks.offsets[point];
         i < known.block.looks.offsets[point + 1];
         ++i) {
      const bool out = result.looks.rejected[i] != 0 || !IsSolved(result.points.status[point]);
      EXPECT_TRUE(out || wrong.count(i) == 0) << i;
      good_lost += out && wrong.count(i) == 0 ? 1U : 0U;
    }
  }
  EXPECT_LE(good_lost, known.block.looks.size() / 10);
}

TEST(BlunderSearchTest, RefusesARobustLossBesideIt) {
  const test::KnownBlock known = Noisy(0);
  AdjustOptions options = Searching();
  options.robust = RobustLoss::kHuber;
  EXPECT_THROW(static_cast<void>(Adjust(known.block, options)), InputError);
}

}  // namespace
}  // namespace sarblock
