// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "linear/dense.h"
#include "normals/reduced_system.h"
#include "solve/rank.h"
#include "solve/weak_directions.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::HasSubstr;

CorrectionGroup Position(int degree, double sigma_m) {
  PositionCorrection position;
  position.degree = degree;
  position.axes = PositionCorrection::Axes::kFrame;
  if (sigma_m > 0.0) position.prior_sigma_m.fill({sigma_m});
  return {"position", position, {}, false};
}

CorrectionGroup Spline() {
  PositionCorrection position;
  position.basis = PositionCorrection::Basis::kSpline;
  position.knot_spacing_s = 21.3;
  position.axes = PositionCorrection::Axes::kFrame;
  return {"position", position, {}, false};
}

class RankTest : public testing::Test {
 protected:
  // Straight paths, so that linear corrections turn them exactly.
  RankTest() : known_(test::MakeBlock(Plan())) {
    for (Pass& pass : known_.block.passes) {
      std::vector<StateVector> states = pass.path.states();
      const StateVector first = states.front(), last = states.back();
      const Eigen::Vector3d v_mps =
          (last.position_m - first.position_m) / (last.time_s - first.time_s);
      for (StateVector& state : states) {
        state.position_m = first.position_m + v_mps * (state.time_s - first.time_s);
        state.velocity_mps = v_mps;
      }
      pass.path = FlightPath(std::move(states));
    }
    Looks& looks = known_.block.looks;
    looks.time_s.assign(looks.size(), kNotGiven);
    looks.range_m.assign(looks.size(), kNotGiven);
    known_.block = FillMeasurements(known_.block, known_.truth_m);
  }

  static test::BlockPlan Plan() {
    test::BlockPlan plan = test::AircraftPlan();
    plan.points = 60;
    return plan;
  }

  RankReport Analysed(const std::vector<CorrectionGroup>& groups) {
    problem_.emplace(known_.block, groups);
    state_.start_m = known_.truth_m;
    state_.displacement_m.assign(known_.truth_m.size(), Eigen::Vector3d::Zero());
    state_.corrections.setZero(problem_->layout.size());
    UpdateWeights(state_, &*problem_);
    system_.emplace(*problem_);
    system_->Form(state_, {}, nullptr);
    return FactorAndAnalyse(&*system_, &state_);
  }

  static std::vector<std::string> Motions(const RankReport& report) {
    std::vector<std::string> out;
    for (const WeakDirection& direction : report.undetermined) out.push_back(direction.motion);
    return out;
  }

  test::KnownBlock known_;
  BlockState state_;
  std::optional<AdjustmentProblem> problem_;
  std::optional<ReducedSystem> system_;
};

// Known null space: linear corrections of the paths represent all six rigid motions.
TEST_F(RankTest, NamesTheSixMotionsOfABlockThatFloats) {
  const RankReport& report = Analysed({Position(1, 0.0)});
  EXPECT_THAT(Motions(report),
              testing::UnorderedElementsAre("translation of the whole block in x",
                                            "translation of the whole block in y",
                                            "translation of the whole block in z",
                                            "tilt of the whole block about x",
                                            "tilt of the whole block about y",
                                            "rotation of the whole block about z"));
  for (const WeakDirection& direction : report.undetermined) {
    EXPECT_LT(direction.eigenvalue, kMinEigenvalue);
    EXPECT_TRUE(direction.moved_point.has_value());
    EXPECT_THAT(direction.text, HasSubstr("; removed by "));
    EXPECT_TRUE(std::isinf(direction.parameters.front().sigma));
    EXPECT_EQ(direction.correlation, 0.0);
  }
  // How large a standard deviation is there is a matter of rounding.
  WeakDirection direction = report.undetermined.front();
  direction.parameters.front().sigma = 7e15;
  EXPECT_THAT(DescribeDirection(*problem_, PassOfParameters(problem_->layout), direction),
              testing::Not(HasSubstr("standard deviation")));
}

// Eigenvectors of equal eigenvalues are any basis: rounding decides, another processor otherwise.
TEST_F(RankTest, WordsBelongToTheSubspaceAndNotToTheVectorsThatSpanIt) {
  static_cast<void>(
      Analysed({Position(1, 0.0), {"range", RangeCorrection{.bias = true}, {}, false}}));
  const std::vector<int> pass_of = PassOfParameters(problem_->layout);
  const Eigen::Index n = problem_->layout.size();
  std::vector<std::uint32_t> passes(known_.block.passes.size());
  std::iota(passes.begin(), passes.end(), 0U);
  // Six motions and two pairs of parameters of different passes that compensate each other.
  Eigen::MatrixXd weak = Eigen::MatrixXd::Zero(n, 8);
  weak.leftCols<6>() = RigidMotions(*problem_, pass_of, passes).leftCols<6>();
  const Eigen::Index second =
      static_cast<Eigen::Index>(std::find(pass_of.begin(), pass_of.end(), 1) - pass_of.begin());
  weak.col(6) = Eigen::VectorXd::Unit(n, 0) - Eigen::VectorXd::Unit(n, 1);
  weak.col(7) = Eigen::VectorXd::Unit(n, second) - Eigen::VectorXd::Unit(n, second + 1);
  weak = dense::Orthogonal(weak).Q(8);
  const Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
  const std::vector<NamedDirection> expected = NameableBasis(*problem_, pass_of, scale, weak);
  ASSERT_EQ(expected.size(), 8U);
  RandomStream random(7, 1);
  for (int draw = 0; draw < 20; ++draw) {
    Eigen::MatrixXd turn(8, 8);
    for (double& value : turn.reshaped()) value = random.Normal();
    const std::vector<NamedDirection> found =
        NameableBasis(*problem_, pass_of, scale, weak * dense::Orthogonal(turn).Q(turn.rows()));
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].motion, expected[k].motion) << draw << " " << k;
      EXPECT_LT((found[k].vector - expected[k].vector).norm(), 1e-9) << draw << " " << k;
    }
  }
}

// The same through coefficients of splines, which reproduce linear functions.
TEST_F(RankTest, NamesTheSixMotionsThroughSplines) {
  EXPECT_THAT(Motions(Analysed({Spline()})),
              testing::IsSupersetOf({"translation of the whole block in x",
                                     "translation of the whole block in y",
                                     "translation of the whole block in z",
                                     "tilt of the whole block about x",
                                     "tilt of the whole block about y",
                                     "rotation of the whole block about z"}));
}

// Known null space: with a free range scale the size is open as well.
TEST_F(RankTest, NamesTheSizeWhereRangesDoNotHoldIt) {
  RangeCorrection range;
  range.scale = true;
  const RankReport& report = Analysed({Position(1, 0.0), {"radar", range, {}, true}});
  EXPECT_EQ(report.undetermined.size(), 7u);
  EXPECT_THAT(Motions(report), Contains("scale of the whole block"));
}

// Legitimate: priors alone hold the block; the covariance says what it is worth, no word is lost.
TEST_F(RankTest, IsSilentWherePriorsHoldTheDatum) {
  const RankReport& report = Analysed({Position(1, 10.0)});
  EXPECT_TRUE(report.regular());
  EXPECT_TRUE(report.nearly.empty());
  const Eigen::Index n = problem_->layout.size();
  const Eigen::MatrixXd covariance = system_->SolveFor(Eigen::MatrixXd::Identity(n, n));
  // Four passes share a translation: 10 m / sqrt(4) at least.
  EXPECT_GT(std::sqrt(covariance(0, 0)), 4.9);
}

// Second route: sigma and correlation of a weak direction against the whole inverse.
TEST_F(RankTest, TellsSigmaAndCorrelationOfAWeakDirection) {
  test::AddKnownPoint(3, {500.0, 300.0, 700.0}, &known_);
  const RankReport& report = Analysed({Position(0, 0.0)});
  ASSERT_TRUE(report.regular());
  ASSERT_EQ(report.nearly.size(), 3u);
  const Eigen::Index n = problem_->layout.size();
  const Eigen::MatrixXd covariance = system_->SolveFor(Eigen::MatrixXd::Identity(n, n));
  for (const WeakDirection& direction : report.nearly) {
    EXPECT_FALSE(direction.undetermined);
    EXPECT_EQ(direction.prior_part, 0.0);
    const WeakParameter& a = direction.parameters[0];
    const WeakParameter& b = direction.parameters[1];
    const double sigma = std::sqrt(covariance(a.index, a.index));
    EXPECT_NEAR(a.sigma, sigma, 1e-6 * sigma);
    EXPECT_NEAR(direction.correlation,
                covariance(a.index, b.index) /
                    std::sqrt(covariance(a.index, a.index) * covariance(b.index, b.index)),
                1e-6);
    // The translation of 300 to 700 m, and every point with it.
    EXPECT_GT(direction.moved_m, 250.0);
    EXPECT_LT(direction.moved_m, 800.0);
    EXPECT_THAT(direction.text, HasSubstr("translation of the whole block in "));
    EXPECT_THAT(direction.text, HasSubstr("without a prior"));
  }
}

TEST_F(RankTest, NearlyUndeterminedIsAWarningOfTheResult) {
  test::AddKnownPoint(3, {500.0, 300.0, 700.0}, &known_);
  test::AddNoise(5, 1.0, &known_);
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {Position(0, 0.0)};
  const AdjustResult result = Adjust(known_.block, options);
  EXPECT_THAT(result.warnings, Contains(HasSubstr("nearly undetermined: ")));
  EXPECT_THAT(result.warnings, Contains(HasSubstr("a single control point (P4) holds the block")));
}

// Limit by definition: a free shift known to 0.7 of the range is nothing linear any more.
TEST_F(RankTest, RefusesAnEnormousSigmaWithoutAPrior) {
  test::AddKnownPoint(3, {9000.0, 0.7, 0.4}, &known_);
  const RankReport& report = Analysed({Position(0, 0.0)});
  ASSERT_EQ(report.undetermined.size(), 1u);
  EXPECT_EQ(report.undetermined[0].motion, "translation of the whole block in x");
  try {
    RequireRegular(*problem_, report, {"words of the structure"});
    FAIL() << "not refused";
  } catch (const UndeterminedError& error) {
    EXPECT_THAT(error.what(), HasSubstr("; words of the structure; these parameters take part: "));
    EXPECT_THAT(error.names(),
                testing::UnorderedElementsAre(
                    "A1 position.x.0", "A2 position.x.0", "A3 position.x.0", "A4 position.x.0"));
  }
}

}  // namespace
}  // namespace sarblock
