// SPDX-License-Identifier: Apache-2.0
// What an adjustment says of itself that no figure shows.
#include "sarblock/adjust/adjust.h"

#include <utility>
#include <vector>

#include "solve/weak_directions.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ContainsRegex;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

test::KnownBlock WithTimesFrom(double origin_s) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (const std::size_t point : {0U, 3U, 7U})
    test::AddKnownPoint(point, {0.31, 0.47, 0.83}, &known);
  for (double& time_s : known.block.looks.time_s) time_s += origin_s;
  for (Pass& pass : known.block.passes) {
    std::vector<StateVector> states(pass.path.states());
    for (StateVector& state : states) state.time_s += origin_s;
    pass.path = FlightPath(std::move(states));
    pass.start_s += origin_s;
    pass.end_s += origin_s;
  }
  return known;
}

// Hand value: one rounding of 1.7e11 s is 3e-5 s, at 173 m/s 5 mm of an azimuth known to 1.2 m.
TEST(WarningsTest, TimesSoLargeThatTheirRoundingCountsAreWarnedOf) {
  EXPECT_THAT(Adjust(WithTimesFrom(0.0).block, {}).warnings,
              Not(Contains(HasSubstr("rounding of double precision"))));
  EXPECT_THAT(Adjust(WithTimesFrom(1.7e11).block, {}).warnings,
              Contains(HasSubstr("rounding of double precision")));
}

// A good block whose spline may bend the flights as it likes: with 100 m on each coefficient and
// knots 5 s apart its acceleration has the standard deviation sqrt(6) 100 m / (5 s)^2 = 9.8 m/s^2,
// where 1.6 m/s^2 turn the cone of an aircraft of 180 m/s with a point at 20 km. Steps end where a
// look has no value; with knots 20 s apart the same block is determined.
TEST(WarningsTest, TheLookWhoseConeTurnsWithItsPointIsNamed) {
  const test::SceneBlock made = test::SimulatedSceneBlock(
      "scenes", "cross-wise", {"seed=2", "points.count=15", "check.count=5"});
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.prior_sigma_m.fill({100.0});
  const auto with_knots = [&](double spacing_s) {
    spline.knot_spacing_s = spacing_s;
    AdjustOptions options = made.options;
    options.groups = {{"position", spline, {}, false}};
    return Adjust(made.block, options);
  };
  const AdjustResult bent = with_knots(5.0);
  EXPECT_EQ(bent.status, AdjustStatus::kNotConverged);
  EXPECT_THAT(
      bent.assessment.reasons,
      AllOf(Contains(AllOf(HasSubstr("not converged: "),
                           ContainsRegex("the look of pass [EN] at point [A-Z][0-9]+ has no "
                                         "value: on the corrected flight its cone turns"),
                           HasSubstr("wider knots"))),
            Each(Not(HasSubstr("contradicted itself")))));
  EXPECT_EQ(with_knots(20.0).assessment.verdict, Verdict::kAccepted);
}

// Ranges of one pass a kilometre too long: the solution converges and means nothing.
TEST(WarningsTest, GrossContradictionsAreNotAccepted) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (const std::size_t point : {0U, 3U, 7U})
    test::AddKnownPoint(point, {0.31, 0.47, 0.83}, &known);
  test::AddNoise(9, 1.0, &known);
  EXPECT_TRUE(Adjust(known.block, {}).usable());
  for (std::size_t i = 0; i < known.block.looks.size(); ++i) {
    if (known.block.looks.pass[i] == 1) known.block.looks.range_m[i] += 1000.0;
  }
  const AdjustResult wrong = Adjust(known.block, {});
  EXPECT_EQ(wrong.status, AdjustStatus::kConverged);
  EXPECT_GT(wrong.sigma0_squared, 10.0);
  EXPECT_FALSE(wrong.usable());
  EXPECT_EQ(wrong.assessment.verdict, Verdict::kNotAccepted);
  EXPECT_THAT(wrong.assessment.reasons, Contains(HasSubstr("s0^2 is")));
  // Scaled by it, standard deviations mean something again: that is what was asked for.
  AdjustOptions scaled;
  scaled.scale_by_posterior = true;
  EXPECT_TRUE(Adjust(known.block, scaled).usable());
}

// A point under two ids with the same looks, by hand.
TEST(WarningsTest, CheckNamesAPointUnderTwoIds) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  Looks& looks = known.block.looks;
  const auto findings = [&] {
    std::string text;
    for (const std::string& finding : CheckBlock(known.block, {}).findings) text += finding + "\n";
    return text;
  };
  EXPECT_THAT(findings(), Not(HasSubstr("under two ids")));
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t from = looks.offsets[2] + k, to = looks.offsets[6] + k;
    ASSERT_EQ(looks.pass[from], looks.pass[to]);
    looks.time_s[to] = looks.time_s[from];
    looks.range_m[to] = looks.range_m[from];
  }
  EXPECT_THAT(findings(), HasSubstr("the same point under two ids, with equal looks"));
}

// Hand cases: the words say what chose between a point and its mirror image.
TEST(WarningsTest, StartCoordinatesAreNamedOnlyWhereThereAreSome) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  PointDefects defects;
  defects.ambiguous = {0, 1};
  const auto text = [&] {
    const AdjustmentProblem problem(known.block, {});
    return DescribePoints(problem, defects).back().text;
  };
  EXPECT_THAT(text(), AllOf(HasSubstr("nothing in the block"), Not(HasSubstr("coordinates"))));
  known.block.points.given_m[0] = known.truth_m[0];
  EXPECT_THAT(text(), Not(HasSubstr("coordinates")));
  known.block.points.given_m[1] = known.truth_m[1];
  EXPECT_THAT(text(), HasSubstr("only the given start coordinates chose between the two"));
}

}  // namespace
}  // namespace sarblock
