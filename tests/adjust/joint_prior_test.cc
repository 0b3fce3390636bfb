// SPDX-License-Identifier: Apache-2.0
// Joint priors against dense algebra, the other engine, other axes and repeated noise.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "linear/dense.h"
#include "model/problem.h"
#include "quality/assess.h"
#include "quality/montecarlo.h"
#include "solve/ceres_engine.h"
#include "support/dense_normals.h"
#include "support/joint_priors.h"
#include "support/share_sums.h"
#include "support/small_blocks.h"
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Axes = PositionCorrection::Axes;

class JointPriorBlockTest : public testing::TestWithParam<bool> {
 protected:
  JointPriorBlockTest()
      : known_(
            test::NoisyBlockWithControl(GetParam() ? test::OrbitPlan() : test::AircraftPlan(3.0))),
        options_(test::WithJointPrior(GetParam() ? Axes::kFrame : Axes::kTrack, 23)) {
    options_.tolerance = 1e-10;
    options_.quality.consensus = false;
  }
  test::KnownBlock known_;
  AdjustOptions options_;
};

// Second route, written without elimination and with the inverse of Q in place of its factor.
// Residuals of times of 1e3 s and paths of 7e6 m have a rounding of 1e-9 m.
TEST_P(JointPriorBlockTest, IsTheDenseLeastSquaresSolution) {
  const AdjustResult result = Adjust(known_.block, options_);
  ASSERT_EQ(result.status, AdjustStatus::kConverged);
  AdjustmentProblem problem(known_.block, options_.groups, {}, options_.priors);
  const BlockState state = test::StateOf(result, &problem);
  test::ExpectDenseLeastSquares(problem, state, result, 1e-7);
}

// Two engines of one problem.
TEST_P(JointPriorBlockTest, BothEnginesAgree) {
  AdjustOptions options = options_;
  options.engine = Engine::kReduced;
  const AdjustResult reduced = Adjust(known_.block, options);
  options.engine = Engine::kCeres;
  options.covariance_method = CovarianceMethod::kCeres;
  const AdjustResult ceres = Adjust(known_.block, options);
  ASSERT_EQ(ceres.status, AdjustStatus::kConverged);
  test::ExpectSameCorrections(ceres, reduced);
  for (std::size_t point = 0; point < known_.truth_m.size(); ++point) {
    EXPECT_LT((ceres.points.position_m[point] - reduced.points.position_m[point]).norm(), 1e-6);
  }
}

// Definition by dense matrices: w = e' P v / sqrt(e' P Qvv P e), r = (Qvv P)_ii, and the parts of
// v'Pv, Qvv = Q - C of each prior.
TEST_P(JointPriorBlockTest, TestsOfPriorsAreThoseOfTheirFullMatrix) {
  const AdjustResult result = Adjust(known_.block, options_);
  AdjustmentProblem problem(known_.block, options_.groups, {}, options_.priors);
  const BlockState state = test::StateOf(result, &problem);
  const test::DenseEquations dense = test::MakeDenseEquations(problem, state);
  const Eigen::MatrixXd c = test::DenseCovariance(dense.jacobian);
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  ASSERT_EQ(result.joint_priors.size(), known_.block.passes.size());
  double strongest = 0.0;
  for (const JointPriorResult& prior : result.joint_priors) {
    const Eigen::MatrixXd p = dense::Cholesky(prior.covariance.matrix()).Inverse();
    std::vector<Eigen::Index> columns;
    Eigen::VectorXd v(p.rows());
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const std::uint32_t parameter = prior.parameters[static_cast<std::size_t>(i)];
      columns.push_back(dense.first_correction + static_cast<Eigen::Index>(parameter));
      v[i] = result.parameters[parameter].value;
    }
    const Eigen::MatrixXd q_vv = prior.covariance.matrix() - c(columns, columns);
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const PriorTest& test = tests[prior.parameters[static_cast<std::size_t>(i)]];
      EXPECT_NEAR(test.redundancy, (q_vv * p)(i, i), 1e-8);
      EXPECT_NEAR(test.w, (p * v)[i] / std::sqrt((p * q_vv * p)(i, i)), 1e-6);
      EXPECT_NEAR(test.square, v[i] * (p * v)[i], 1e-8);
      const Eigen::Index own = columns[static_cast<std::size_t>(i)];
      const double alone = 1.0 - c(own, own) / prior.covariance.matrix()(i, i);
      strongest = std::max(strongest, std::abs(alone - test.redundancy));
    }
  }
  EXPECT_GT(strongest, 0.05) << "the formula of independent priors would pass too";
}

// Invariance: redundancy and v'Pv add up over looks, control and priors.
TEST_P(JointPriorBlockTest, SharesAddToTheWholeBlock) {
  const AdjustResult result = Adjust(known_.block, options_);
  const test::ShareSums sums = test::SumShares(known_.block, result);
  EXPECT_NEAR(sums.redundancy, result.redundancy(), 1e-4);
  EXPECT_NEAR(sums.square_sum, 2.0 * result.final_cost, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Blocks, JointPriorBlockTest, testing::Bool(), [](const auto& of) {
  return of.param ? "Orbit" : "Aircraft";
});

/// Position of degree 1 in the axes of the frame with a standard deviation by axis and degree.
AdjustOptions InFrameAxes(const std::array<std::vector<double>, 3>& sigma_m) {
  PositionCorrection position;
  position.degree = 1;
  position.axes = Axes::kFrame;
  position.prior_sigma_m = sigma_m;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

constexpr std::array<std::array<double, 3>, 2> kSigmas_m = {
    std::array{2.3, 0.7, 1.9}, std::array{1.1, 1.7, 0.3}};  // by degree and axis

/// The prior of kSigmas_m in axes whose unit vectors are the columns of `axes`, by pass.
JointPrior Turned(const std::string& pass,
                  JointPrior::Axes axes,
                  const std::array<const char*, 3>& names,
                  const Eigen::Matrix3d& frame_from_axes) {
  JointPrior prior;
  prior.name = "of-" + pass;
  prior.passes = {pass};
  prior.axes = axes;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(6, 6);
  for (std::size_t degree = 0; degree < 2; ++degree) {
    const Eigen::Vector3d sigma_m(kSigmas_m[degree].data());
    const auto at = static_cast<Eigen::Index>(3 * degree);
    covariance.block<3, 3>(at, at) =
        frame_from_axes.transpose() * sigma_m.cwiseAbs2().asDiagonal() * frame_from_axes;
    for (const char* name : names) {
      prior.parameters.push_back("position." + std::string(name) + "." + std::to_string(degree));
    }
  }
  prior.covariance = covariance;
  return prior;
}

void ExpectSame(const AdjustResult& a, const AdjustResult& b) {
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    const ParameterResult &one = a.parameters[i], &two = b.parameters[i];
    EXPECT_NEAR(one.value, two.value, 1e-8) << one.name;
    EXPECT_NEAR(one.sigma, two.sigma, 1e-9) << one.name;
    EXPECT_NEAR(one.prior_sigma, two.prior_sigma, 1e-9) << one.name;
  }
  for (std::size_t k = 0; k < a.points.covariance_m2.size(); ++k) {
    for (std::size_t e = 0; e < 6; ++e) {
      EXPECT_NEAR(a.points.covariance_m2[k][e], b.points.covariance_m2[k][e], 1e-9);
    }
  }
  EXPECT_NEAR(a.sigma0_squared, b.sigma0_squared, 1e-8);
}

/// What the radial, in-track and cross-track axes are, from the path.
Eigen::Matrix3d RicOf(const Pass& pass, double rotation_rad_per_s) {
  const Motion motion = *pass.path.At(0.5 * (pass.start_s + pass.end_s));
  const Eigen::Vector3d turning = rotation_rad_per_s * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d velocity_mps = motion.velocity_mps + turning.cross(motion.position_m);
  const Eigen::Vector3d r = motion.position_m / motion.position_m.norm();
  const Eigen::Vector3d n = motion.position_m.cross(velocity_mps);
  Eigen::Matrix3d out;
  out << r, (n / n.norm()).cross(r), n / n.norm();
  return out;
}

// Change of parameters: independent priors along x, y, z are full ones in other axes, which the
// program turns back. Rows of the turn by hand from heading (aircraft) or path (orbit).
TEST(JointPriorAxesTest, AFullPriorInTurnedAxesIsADiagonalOneInTheOthers) {
  const std::array<std::vector<double>, 3> sigma_m = {
      std::vector{kSigmas_m[0][0], kSigmas_m[1][0]},
      std::vector{kSigmas_m[0][1], kSigmas_m[1][1]},
      std::vector{kSigmas_m[0][2], kSigmas_m[1][2]}};
  test::BlockPlan straight = test::AircraftPlan();
  for (test::PassPlan& pass : straight.passes) pass.straight = true;
  const test::KnownBlock flat = test::NoisyBlockWithControl(straight);
  const AdjustResult expected = Adjust(flat.block, InFrameAxes(sigma_m));
  AdjustOptions turned = InFrameAxes({});
  for (std::size_t i = 0; i < flat.block.passes.size(); ++i) {
    const double heading_rad = straight.passes[i].heading_deg * std::acos(-1.0) / 180.0;
    const double c = std::cos(heading_rad), s = std::sin(heading_rad);
    Eigen::Matrix3d axes;  // along, across = up x along, up
    axes << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
    turned.priors.push_back(
        Turned(flat.block.passes[i].id, JointPrior::Axes::kTrack, {"along", "across", "up"}, axes));
  }
  ExpectSame(Adjust(flat.block, turned), expected);
  const test::KnownBlock round = test::NoisyBlockWithControl(test::OrbitPlan());
  const AdjustResult orbit = Adjust(round.block, InFrameAxes(sigma_m));
  for (const auto& [axes, rotation_rad_per_s] :
       {std::pair{JointPrior::Axes::kRic, 0.0}, {JointPrior::Axes::kRicInertial, 7.292115e-5}}) {
    turned.priors.clear();
    for (const Pass& pass : round.block.passes) {
      turned.priors.push_back(Turned(
          pass.id, axes, {"radial", "in-track", "cross-track"}, RicOf(pass, rotation_rad_per_s)));
    }
    ExpectSame(Adjust(round.block, turned), orbit);
  }
}

TEST(JointPriorAxesTest, InertialAxesNeedABodyOfWhichTheRotationIsKnown) {
  const test::KnownBlock flat = test::NoisyBlockWithControl(test::AircraftPlan());
  AdjustOptions options = InFrameAxes({});
  options.priors = {Turned(flat.block.passes[0].id,
                           JointPrior::Axes::kRicInertial,
                           {"radial", "in-track", "cross-track"},
                           Eigen::Matrix3d::Identity())};
  try {
    (void)Adjust(flat.block, options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("prior.of-" + flat.block.passes[0].id + ".axes"));
    EXPECT_THAT(error.what(), testing::HasSubstr("needs the rotation of a body"));
  }
}

// Seeded statistics: priors drawn for Monte Carlo have the covariance that they were given. Sums of
// squares of whitened draws are chi-square, 99.9 percent of each: all of them, and each alone.
TEST(JointPriorDrawsTest, RedrawnPriorsHaveTheirCovariance) {
  const test::KnownBlock known = test::NoisyBlockWithControl(test::AircraftPlan());
  const AdjustOptions options = test::WithJointPrior(Axes::kTrack, 29);
  const AdjustResult result = Adjust(known.block, options);
  AdjustmentProblem problem(known.block, options.groups, {}, options.priors);
  const BlockState state = test::StateOf(result, &problem);
  const ExactReadings exact = ReadExactly(problem, state);
  constexpr int kRuns = 400;
  const Eigen::MatrixXd u =
      dense::Cholesky(dense::Cholesky(options.priors[0].covariance.matrix()).Inverse())
          .L()
          .transpose();
  std::map<Eigen::Index, double> each;
  double all = 0.0;
  Block block = known.block;
  std::vector<double> values;
  for (int run = 0; run < kRuns; ++run) {
    ResampleObservations(
        problem, state, exact, 9, static_cast<std::uint64_t>(run), &block, &values);
    for (const JointPriorTerm& prior : problem.layout.joint_priors) {
      Eigen::VectorXd drawn(7);
      for (Eigen::Index i = 0; i < 7; ++i) {
        const int parameter = prior.parameters[static_cast<std::size_t>(i)];
        drawn[i] = values[static_cast<std::size_t>(parameter)] - state.corrections[parameter];
      }
      const Eigen::VectorXd white = u * drawn;
      for (Eigen::Index i = 0; i < 7; ++i) each[i] += white[i] * white[i];
      all += white.squaredNorm();
    }
  }
  const double n = kRuns * static_cast<double>(known.block.passes.size());
  EXPECT_TRUE(ChiSquareInterval(0.999, 7.0 * n).Contains(all)) << all / n;
  for (const auto& [i, sum] : each) {
    EXPECT_TRUE(ChiSquareInterval(0.9998, n).Contains(sum)) << i << ' ' << sum / n;
  }
}

// Seeded statistics of the whole: runs with looks, control and joint priors drawn anew fill the
// covariance of the adjustment.
TEST(JointPriorDrawsTest, RepeatedNoiseFillsTheCovariance) {
  const test::KnownBlock known = test::NoisyBlockWithControl(test::AircraftPlan());
  AdjustOptions options = test::WithJointPrior(Axes::kTrack, 31);
  options.covariance = CovarianceLevel::kMonteCarlo;
  options.montecarlo_runs = 200;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.montecarlo.has_value());
  EXPECT_EQ(result.montecarlo->failed, 0U);
  EXPECT_TRUE(result.montecarlo->square_ratio.Agrees()) << result.montecarlo->sentence;
}

// Two routes: a prediction at the truth has the covariance of an adjustment of exact looks.
TEST(JointPriorTest, PredictionHasTheCovarianceOfTheAdjustment) {
  const test::KnownBlock known = [] {
    test::KnownBlock made = test::MakeBlock(test::AircraftPlan());
    test::AddKnownPoint(0, {0.31, 0.47, 0.83}, &made);
    return made;
  }();
  const AdjustOptions options = test::WithJointPrior(Axes::kTrack, 37);
  const AdjustResult adjusted = Adjust(known.block, options);
  const AdjustResult predicted = Predict(known.block, options, known.truth_m);
  for (std::size_t i = 0; i < adjusted.parameters.size(); ++i) {
    const double sigma = adjusted.parameters[i].sigma;
    EXPECT_NEAR(predicted.parameters[i].sigma, sigma, 1e-6 * sigma);
    EXPECT_NEAR(adjusted.parameters[i].value, 0.0, 1e-6 * sigma);
  }
  for (const PriorTest& test : TestsOfPriors(predicted)) {
    EXPECT_FALSE(std::isnan(test.redundancy));
    EXPECT_TRUE(std::isnan(test.w));
  }
}

// A path far from what its prior says contradicts it, also where only the correlations show it: the
// errors are within two standard deviations of each parameter.
TEST(JointPriorTest, AnErrorThatOnlyCorrelationsForbidContradictsThePrior) {
  test::KnownBlock known = test::NoisyBlockWithControl(test::AircraftPlan());
  for (std::size_t point = 0; point < 12; ++point) {
    if (known.block.points.role[point] == PointRole::kTie) {
      test::AddKnownPoint(point, {0.1, 0.1, 0.1}, &known);
    }
  }
  PositionCorrection position;
  position.axes = Axes::kFrame;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  JointPrior prior;
  prior.name = "p";
  prior.parameters = {"position.x.0", "position.y.0", "position.z.0"};
  prior.sigma = {10.0, 10.0, 10.0};
  options.priors = {prior};
  test::ShiftPath(0, {0.0, 13.0, -13.0}, &known.block);
  EXPECT_THAT(Adjust(known.block, options).assessment.reasons, testing::IsEmpty());
  prior.correlation = Eigen::Matrix3d::Identity();
  prior.correlation(1, 2) = prior.correlation(2, 1) = 0.995;
  options.priors = {prior};
  const AdjustResult result = Adjust(known.block, options);
  EXPECT_THAT(result.assessment.reasons,
              testing::Contains(testing::HasSubstr("the observations contradict those")));
}

TEST(JointPriorTest, AChoiceOfCorrectionsRefusesIt) {
  const test::KnownBlock known = test::NoisyBlockWithControl(test::AircraftPlan());
  AdjustOptions options = test::WithJointPrior(Axes::kTrack, 41);
  options.corrections = CorrectionChoice::kAuto;
  EXPECT_THROW((void)Adjust(known.block, options), InputError);
}

}  // namespace
}  // namespace sarblock
