// SPDX-License-Identifier: Apache-2.0
#include "quality/covariance.h"

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "linear/dense.h"
#include "quality/point_sweep.h"
#include "solve/ceres_engine.h"
#include "solve/rank.h"
#include "support/dense_normals.h"
#include "support/small_blocks.h"
#include <Eigen/LU>
#include <ceres/covariance.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// A block that its control and priors determine, and its corrections.
struct Scenario {
  test::KnownBlock known;
  std::vector<CorrectionGroup> groups;
};

CorrectionGroup Position(int degree, double sigma_m, bool shared = false) {
  PositionCorrection position;
  position.degree = degree;
  if (sigma_m > 0.0) position.prior_sigma_m.fill({sigma_m});
  return {"position", position, {}, shared};
}

CorrectionGroup SharedRangeBias(double sigma_m) {
  RangeCorrection range;
  range.bias = true;
  range.bias_prior_sigma_m = sigma_m;
  return {"radar", range, {}, true};
}

/// Control of every kind: full and correlated, plan only, height only.
void FixSome(test::KnownBlock* known) {
  test::AddKnownPoint(0, {0.31, 0.47, 0.83}, known, PointRole::kControl, 0.57);
  test::AddKnownPoint(3, {0.53, 0.29, kNotGiven}, known, PointRole::kControl, -0.41);
  test::AddKnownPoint(4, {kNotGiven, kNotGiven, 0.37}, known);
  test::AddKnownPoint(7, {0.43, 0.61, 0.71}, known);
  test::AddKnownPoint(9, {kNotGiven, 0.33, 0.59}, known);
}

Scenario Aircraft(double squint_deg) {
  Scenario s{test::MakeBlock(test::AircraftPlan(squint_deg)), {}};
  FixSome(&s.known);
  s.groups = {Position(1, 3.7)};
  return s;
}

Scenario AircraftWithoutPriors() {
  Scenario s{test::MakeBlock(test::AircraftPlan()), {}};
  FixSome(&s.known);
  s.groups = {Position(0, 0.0)};
  return s;
}

Scenario Orbit(double squint_deg) {
  Scenario s{test::MakeBlock(test::OrbitPlan(squint_deg)), {}};
  FixSome(&s.known);
  s.groups = {Position(0, 1.9), SharedRangeBias(2.3)};
  return s;
}

Scenario Spline() {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 30;
  plan.looks_per_point = 3;
  Scenario s{test::MakeBlock(plan), {}};
  FixSome(&s.known);
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.knot_spacing_s = 12.7;
  spline.prior_sigma_m.fill({4.1});
  s.groups = {{"position", spline, {}, false}, SharedRangeBias(1.3)};
  return s;
}

struct Case {
  std::string name;
  std::function<Scenario()> make;
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

class CovarianceTest : public testing::TestWithParam<Case> {
 protected:
  CovarianceTest()
      : scenario_(GetParam().make()), problem_(scenario_.known.block, scenario_.groups) {
    // A linearisation point off the truth: the covariance is a property of the Jacobian there.
    state_.start_m = scenario_.known.truth_m;
    state_.displacement_m.assign(scenario_.known.truth_m.size(), {1.7, -2.3, 0.9});
    state_.corrections.setConstant(problem_.layout.size(), 0.13);
    UpdateWeights(state_, &problem_);
    system_.emplace(problem_);
    system_->Form(state_, {}, nullptr);
    FactorRegular(&*system_);
    inverse_ = system_->SelectedInverse();
  }
  Eigen::Matrix3d PointCovariance(const std::vector<SymmetricEnu>& all, std::size_t point) const {
    return test::FrameFromEnu(problem_.block.frame, state_.Position(point), all[point]);
  }
  Scenario scenario_;
  AdjustmentProblem problem_;
  BlockState state_;
  std::optional<ReducedSystem> system_;
  std::optional<CorrectionCovariance> inverse_;
};

// Invariance: factors kept from the sum of S are those computed anew, to the bit.
TEST_P(CovarianceTest, KeptFactorsGiveTheSameBytes) {
  EXPECT_EQ(system_->kept(), nullptr);
  ReducedSystem keeping(problem_, KeptFactors::kMaxBytes);
  keeping.Form(state_, {}, nullptr);
  ASSERT_NE(keeping.kept(), nullptr);
  for (const bool quality : {false, true}) {
    const PointSweep anew = SweepPoints(problem_, state_, &*inverse_, quality, nullptr);
    const PointSweep kept =
        SweepPoints(problem_, state_, &*inverse_, quality, nullptr, keeping.kept());
    EXPECT_EQ(anew.covariance_m2, kept.covariance_m2);
    EXPECT_EQ(anew.redundancy, kept.redundancy);
    for (std::size_t component = 0; component < 2; ++component) {
      EXPECT_EQ(anew.quality.redundancy[component], kept.quality.redundancy[component]);
      EXPECT_EQ(anew.quality.shift_m[component], kept.quality.shift_m[component]);
    }
  }
  keeping.Form(state_, {}, nullptr, 1e-3);
  EXPECT_EQ(keeping.kept(), nullptr);  // damped
}

TEST_P(CovarianceTest, KeptFactorsAreNotThoseOfAnotherNumberOfLooks) {
  ReducedSystem keeping(problem_, KeptFactors::kMaxBytes);
  keeping.Form(state_, {}, nullptr);
  const KeptFactors& kept = *keeping.kept();
  PointFactor factor;
  PointColumns columns;
  EXPECT_NE(kept.Restore(problem_, 2, &factor.r, &columns), nullptr);
  std::uint8_t& used = problem_.look_used[problem_.block.looks.offsets[2]];
  used = 0;
  EXPECT_EQ(kept.Restore(problem_, 2, &factor.r, &columns), nullptr);
  used = 1;
}

// Second route inside: QR of all equations at once in extended precision.
TEST_P(CovarianceTest, AgreesWithTheDenseInverse) {
  const test::DenseEquations dense = test::MakeDenseEquations(problem_, state_);
  const Eigen::MatrixXd q = test::DenseCovariance(dense.jacobian);
  const auto points = SweepPoints(problem_, state_, &*inverse_, false, nullptr).covariance_m2;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const Eigen::Matrix3d expected =
        q.block<3, 3>(dense.column_of_point[j], dense.column_of_point[j]);
    EXPECT_LT((PointCovariance(points, j) - expected).norm(), 1e-9 * expected.norm()) << j;
  }
  const int n = problem_.layout.size(), first = dense.first_correction;
  const auto parameters = ParameterCovariances(*system_, *inverse_);
  ASSERT_EQ(parameters.size(), static_cast<std::size_t>(n * (n + 1) / 2));
  for (const ParameterCovariance& c : parameters) {
    const int a = first + static_cast<int>(c.a), b = first + static_cast<int>(c.b);
    EXPECT_NEAR(c.covariance, q(a, b), 1e-9 * std::sqrt(q(a, a) * q(b, b)));
  }
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted = {{0, 5}, {6, 2}, {8, 11}};
  const auto pairs = PairCovariances(problem_, state_, &*system_, wanted, nullptr);
  ASSERT_EQ(pairs.size(), wanted.size());
  for (const PairResult& pair : pairs) {
    const int a = dense.column_of_point[pair.a], b = dense.column_of_point[pair.b];
    const Eigen::Matrix3d expected =
        q.block<3, 3>(a, a) + q.block<3, 3>(b, b) - q.block<3, 3>(a, b) - q.block<3, 3>(b, a);
    const Eigen::Matrix3d computed =
        test::FrameFromEnu(problem_.block.frame, state_.Position(pair.a), pair.covariance_m2);
    EXPECT_LT((computed - expected).norm(), 1e-9 * expected.norm());
    const Eigen::Vector3d difference_m =
        problem_.block.frame.EnuFromFrame(state_.Position(pair.a)) *
        (state_.Position(pair.b) - state_.Position(pair.a));
    EXPECT_LT((pair.difference_enu_m - difference_m).norm(), 1e-9);
  }
}

// An independent code: Ceres' own covariance of the same equations.
TEST_P(CovarianceTest, AgreesWithCeres) {
  const std::unique_ptr<ceres::Problem> all = MakeCeresProblem(problem_, {}, &state_);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  ceres::Covariance covariance(options);
  std::vector<std::pair<const double*, const double*>> wanted;
  for (const Eigen::Vector3d& displacement_m : state_.displacement_m) {
    wanted.emplace_back(displacement_m.data(), displacement_m.data());
  }
  const double* a = state_.displacement_m[1].data();
  const double* b = state_.displacement_m[10].data();
  wanted.emplace_back(a, b);
  ASSERT_TRUE(covariance.Compute(wanted, all.get()));
  const auto block = [&covariance](const double* i, const double* j) {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> out;
    EXPECT_TRUE(covariance.GetCovarianceBlock(i, j, out.data()));
    return Eigen::Matrix3d(out);
  };
  const auto points = SweepPoints(problem_, state_, &*inverse_, false, nullptr).covariance_m2;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const double* p = state_.displacement_m[j].data();
    const Eigen::Matrix3d expected = block(p, p);
    EXPECT_LT((PointCovariance(points, j) - expected).norm(), 1e-9 * expected.norm()) << j;
  }
  const auto pairs = PairCovariances(problem_, state_, &*system_, {{1, 10}}, nullptr);
  const Eigen::Matrix3d cross = block(a, b);
  const Eigen::Matrix3d expected = block(a, a) + block(b, b) - cross - cross.transpose();
  const Eigen::Matrix3d computed =
      test::FrameFromEnu(problem_.block.frame, state_.Position(1), pairs.at(0).covariance_m2);
  EXPECT_LT((computed - expected).norm(), 1e-9 * expected.norm());
}

// Closed form: with paths held every point is alone, (J_p' J_p)^-1 of its own rows.
TEST_P(CovarianceTest, WithoutCorrectionsIsThatOfEachPointAlone) {
  const test::DenseEquations dense = test::MakeDenseEquations(problem_, state_);
  const auto points = SweepPoints(problem_, state_, nullptr, false, nullptr).covariance_m2;
  const auto pairs = PairCovariances(problem_, state_, nullptr, {{2, 9}}, nullptr);
  std::vector<Eigen::Matrix3d> own;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const Eigen::MatrixXd jp = dense.jacobian.middleCols(dense.column_of_point[j], 3);
    own.push_back(test::DenseCovariance(jp));
    EXPECT_LT((PointCovariance(points, j) - own[j]).norm(), 1e-11 * own[j].norm()) << j;
  }
  const Eigen::Matrix3d pair =
      test::FrameFromEnu(problem_.block.frame, state_.Position(2), pairs.at(0).covariance_m2);
  EXPECT_LT((pair - own[2] - own[9]).norm(), 1e-11 * pair.norm());
}

TEST_P(CovarianceTest, LeavesOutPointsThatAreNotSolved) {
  problem_.LeaveOut(6, PointStatus::kUndetermined, "left out by the test");
  system_.emplace(problem_);
  system_->Form(state_, {}, nullptr);
  FactorRegular(&*system_);
  const CorrectionCovariance inverse = system_->SelectedInverse();
  const auto points = SweepPoints(problem_, state_, &inverse, false, nullptr).covariance_m2;
  for (const double value : points[6]) EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(std::isfinite(points[5][0]));
  EXPECT_EQ(PairCovariances(problem_, state_, &*system_, {{6, 1}, {1, 2}}, nullptr).size(), 1U);
  EXPECT_EQ(AllPairs(problem_).size(), (points.size() - 1) * (points.size() - 2) / 2);
}

INSTANTIATE_TEST_SUITE_P(Blocks,
                         CovarianceTest,
                         testing::Values(Case{"aircraft", [] { return Aircraft(0.0); }},
                                         Case{"aircraft_squint_20", [] { return Aircraft(20.0); }},
                                         Case{"aircraft_squint_60", [] { return Aircraft(60.0); }},
                                         Case{"aircraft_without_priors", AircraftWithoutPriors},
                                         Case{"orbit", [] { return Orbit(0.0); }},
                                         Case{"orbit_squint_20", [] { return Orbit(20.0); }},
                                         Case{"orbit_squint_60", [] { return Orbit(60.0); }},
                                         Case{"spline_and_shared_range_bias", Spline}),
                         [](const testing::TestParamInfo<Case>& tested) {
                           return tested.param.name;
                         });

// Second route: the definition with the dense covariance of all points, its blocks along the known
// directions (docs/theory/quality.md, eq. (17)).
TEST_P(CovarianceTest, FreedomOfKnownPointsIsThatOfTheDenseCovariance) {
  const test::DenseEquations dense = test::MakeDenseEquations(problem_, state_);
  const Eigen::MatrixXd q = test::DenseCovariance(dense.jacobian);
  std::vector<CheckResult> checks;
  std::vector<Eigen::MatrixXd> direction, own;
  for (const KnownPosition& known : problem_.block.points.known) {
    CheckResult check;
    check.point = known.point;
    const Eigen::Matrix3d enu = problem_.block.frame.EnuFromFrame(state_.Position(known.point));
    std::vector<int> fixed;
    for (int k = 0; k < 3; ++k) {
      if (known.fixed[static_cast<std::size_t>(k)]) fixed.push_back(k);
    }
    if (fixed.empty()) continue;
    check.components = static_cast<int>(fixed.size());
    direction.emplace_back(enu(fixed, Eigen::all));
    own.emplace_back(known.covariance_enu_m2(fixed, fixed));
    checks.push_back(check);
  }
  ASSERT_GE(checks.size(), 2U);
  double factor = 1.0;
  const auto block = [&](std::size_t i, std::size_t j) {
    const auto row = dense.column_of_point[checks[i].point];
    const auto column = dense.column_of_point[checks[j].point];
    Eigen::MatrixXd out =
        factor * direction[i] * q.block<3, 3>(row, column) * direction[j].transpose();
    if (i == j) out += own[i];
    return out;
  };
  for (factor = 1.0; factor < 10.0; factor += 4.0) {  // and s0^2 where it scales covariances
    double components = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < checks.size(); ++i) {
      components += checks[i].components;
      for (std::size_t j = 0; j < checks.size(); ++j) {
        const Eigen::MatrixXd a = dense::Cholesky(block(i, i)).Solve(block(i, j));
        const Eigen::MatrixXd b = dense::Cholesky(block(j, j)).Solve(block(j, i));
        sum += (a * b).trace();
      }
    }
    const double freedom = CheckFreedom(problem_, state_, *system_, checks, factor);
    EXPECT_NEAR(freedom, components * components / sum, 1e-7 * components);
    EXPECT_LT(freedom, components);
  }
}

// Hand count: the nearest of four points on a line, each pair once.
TEST(NeighbourPairsTest, NamesEachNearestPairOnce) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 4;
  const test::KnownBlock known = test::MakeBlock(plan);
  const AdjustmentProblem problem(known.block, {});
  BlockState state;
  state.displacement_m.assign(4, Eigen::Vector3d::Zero());
  state.start_m = {{0.0, 0.0, 0.0}, {10.3, 0.0, 0.0}, {17.1, 0.0, 0.0}, {61.7, 0.0, 0.0}};
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> expected = {{0, 1}, {1, 2}, {2, 3}};
  EXPECT_EQ(NeighbourPairs(problem, state), expected);
}

/// A line of points eastwards and one northwards through the same corner, 100 m apart.
struct Corner {
  Corner() {
    for (int i = 0; i < 33; ++i) state.start_m.emplace_back(100.0 * i, 0.0, 0.0);
    for (int i = 1; i < 33; ++i) state.start_m.emplace_back(0.0, 100.0 * i, 0.0);
    state.displacement_m.assign(state.start_m.size(), Eigen::Vector3d::Zero());
  }
  BlockState state;
};

// By hand: 0.7 of 3200 m and halves of it, along the axes that the flight defines.
TEST(DistancePairsTest, AreAlongAndAcrossTheTrackAtHalvedDistances) {
  const Corner corner;
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = corner.state.start_m.size();
  for (test::PassPlan& pass : plan.passes) pass.straight = true;
  plan.passes.front().heading_deg = 0.0;  // of these blocks: along x
  const test::KnownBlock known = test::MakeBlock(plan);
  const AdjustmentProblem problem(known.block, {});
  const PointPairs pairs = DistancePairs(problem, corner.state);
  ASSERT_GT(pairs.size(), 100U);
  AdjustResult result;
  for (const Eigen::Vector3d& p_m : corner.state.start_m) result.points.position_m.push_back(p_m);
  for (const auto& [a, b] : pairs) {
    PairResult pair;
    pair.a = a;
    pair.b = b;
    pair.difference_enu_m = corner.state.start_m[b] - corner.state.start_m[a];
    const double part = pair.difference_enu_m.norm() / 2240.0;
    const double halvings = -std::log2(part);
    EXPECT_NEAR(halvings, std::round(halvings), 0.42) << "within a quarter of a distance";
    pair.covariance_m2 = {4.0, 9.0, part * part, 0.0, 0.0, 0.0};
    result.pairs.push_back(pair);
  }
  const std::vector<DifferenceClass> classes = SummariseDifferences(known.block, result);
  ASSERT_GE(classes.size(), 8U);
  std::size_t counted = 0;
  for (const DifferenceClass& of : classes) {
    counted += of.pairs;
    EXPECT_DOUBLE_EQ(of.sigma_along_m, 2.0);
    EXPECT_DOUBLE_EQ(of.sigma_across_m, 3.0);
    EXPECT_NEAR(of.sigma_up_m, of.distance_m / 2240.0, 1e-12);
  }
  EXPECT_EQ(counted, pairs.size());
}

}  // namespace
}  // namespace sarblock
