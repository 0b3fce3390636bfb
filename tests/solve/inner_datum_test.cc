// SPDX-License-Identifier: Apache-2.0
#include "solve/inner_datum.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <cmath>
#include <optional>

#include "linear/dense.h"
#include "quality/covariance.h"
#include "quality/point_sweep.h"
#include "solve/rank.h"
#include "support/dense_normals.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

std::vector<CorrectionGroup> FreePosition(int degree) {
  PositionCorrection position;
  position.degree = degree;
  return {{"position", position, {}, false}};
}

/// Straight passes, so that constant and linear corrections can express every motion of the block.
test::KnownBlock StraightBlock() {
  test::BlockPlan plan = test::AircraftPlan(7.3);
  for (test::PassPlan& pass : plan.passes) pass.straight = true;
  return test::MakeBlock(plan);
}

/// A block without control and priors at a state near its solution, and its null space.
struct Floating {
  explicit Floating(int degree)
      : known(StraightBlock()), problem(known.block, FreePosition(degree)) {
    state.start_m = known.truth_m;
    state.displacement_m.assign(known.truth_m.size(), {0.37, -0.29, 0.53});
    state.corrections.setConstant(problem.layout.size(), 0.11);
    UpdateWeights(state, &problem);
    ReducedSystem open(problem);
    open.Form(state, {}, nullptr);
    null_space = NullSpace(&open);
    FixDatum(null_space, open.Unit(), state, &problem);
    system.emplace(problem);
    system->Form(state, {}, nullptr);
    FactorRegular(&*system);
  }
  [[nodiscard]] DatumTransform Datum(const std::vector<std::uint8_t>& in_datum) const {
    return DatumTransform(problem, state, *system, null_space, in_datum);
  }
  /// Covariances of points in frame axes under a datum.
  [[nodiscard]] std::vector<SymmetricEnu> Points(const DatumTransform& datum) const {
    const CorrectionCovariance inverse = system->SelectedInverse();
    auto points = SweepPoints(problem, state, &inverse, false, nullptr).covariance_m2;
    datum.Transform(problem, state, &points);
    return points;
  }
  test::KnownBlock known;
  AdjustmentProblem problem;
  BlockState state;
  Eigen::MatrixXd null_space;
  std::optional<ReducedSystem> system;
};

/// The dense normal matrix of the points alone, corrections eliminated, and its null space by a
/// full eigenvalue decomposition.
struct DensePoints {
  explicit DensePoints(const Floating& block, int defects) {
    const auto dense = test::MakeDenseEquations(block.problem, block.state);
    const Eigen::Index p = dense.first_correction;
    const Eigen::MatrixXd j = dense.jacobian;
    const Eigen::MatrixXd jp = j.leftCols(p), jc = j.rightCols(j.cols() - p);
    // Complement of the corrections by an orthogonal factorisation, not by normal equations.
    const Eigen::MatrixXd q = dense::Orthogonal(jc).Q(j.rows());
    const Eigen::MatrixXd below = q.rightCols(j.rows() - jc.cols()).transpose() * jp;
    const auto [values, v] = dense::DecomposeSingular(below);
    const Eigen::Index rank = p - defects;
    gap = values[rank - 1] / values[rank];
    null = v.rightCols(defects);
    const Eigen::VectorXd inverse = values.head(rank).cwiseAbs2().cwiseInverse();
    pseudo_inverse = v.leftCols(rank) * inverse.asDiagonal() * v.leftCols(rank).transpose();
  }
  double gap = 0.0;
  Eigen::MatrixXd null, pseudo_inverse;
};

void ExpectNear(const SymmetricEnu& enu, const Eigen::Matrix3d& expected, double relative) {
  const Eigen::Matrix3d c = MatrixOf(enu);
  EXPECT_LT((c - expected).norm(), relative * expected.norm());
}

class InnerDatumTest : public testing::TestWithParam<int> {};

// Second route: the Moore-Penrose inverse of the dense normal matrix of the points, by a singular
// value decomposition. The local frame's axes are those of east, north and up.
TEST_P(InnerDatumTest, IsThePseudoInverseOfTheDenseNormals) {
  const Floating block(GetParam());
  // Constant corrections of tracks in four directions: a shift in each axis. With a drift each path
  // can also turn with the block.
  const int defects = GetParam() == 0 ? 3 : 6;
  ASSERT_EQ(block.null_space.cols(), defects);
  const DensePoints dense(block, defects);
  ASSERT_GT(dense.gap, 1e6);
  const std::vector<std::uint8_t> all(block.known.truth_m.size(), 1);
  const auto points = block.Points(block.Datum(all));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    ExpectNear(points[i], dense.pseudo_inverse.block<3, 3>(at, at), 1e-9);
  }
}

// Second route: S-transformation of the dense pseudo-inverse to the datum of three points, with the
// dense null space (Baarda 1973).
TEST_P(InnerDatumTest, OfNamedPointsIsTheTransformationOfTheDenseInverse) {
  const Floating block(GetParam());
  const int defects = static_cast<int>(block.null_space.cols());
  const DensePoints dense(block, defects);
  std::vector<std::uint8_t> some(block.known.truth_m.size(), 0);
  for (const std::size_t i : {std::size_t{1}, std::size_t{6}, std::size_t{10}}) some[i] = 1;
  const Eigen::Index n = dense.null.rows();
  Eigen::MatrixXd e = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < some.size(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Index row = 3 * static_cast<Eigen::Index>(i) + k;
      e(row, row) = some[i];
    }
  }
  const Eigen::MatrixXd& g = dense.null;
  const Eigen::MatrixXd s =
      Eigen::MatrixXd::Identity(n, n) -
      g * dense::Cholesky(g.transpose() * e * g).Inverse() * g.transpose() * e;
  const Eigen::MatrixXd expected = s * dense.pseudo_inverse * s.transpose();
  const auto points = block.Points(block.Datum(some));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    ExpectNear(points[i], expected.block<3, 3>(at, at), 1e-9);
  }
}

// Invariance: the variance of a distance does not depend on the datum.
TEST_P(InnerDatumTest, LeavesVariancesOfDistancesAlone) {
  const Floating block(GetParam());
  const std::vector<std::uint8_t> all(block.known.truth_m.size(), 1);
  std::vector<std::uint8_t> some(block.known.truth_m.size(), 0);
  for (const std::size_t i : {std::size_t{0}, std::size_t{4}, std::size_t{9}}) some[i] = 1;
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted{{0, 7}, {3, 5}, {11, 2}};
  auto free = PairCovariances(block.problem, block.state, &*block.system, wanted, nullptr);
  auto fixed = free;
  block.Datum(all).Transform(block.problem, block.state, &free);
  block.Datum(some).Transform(block.problem, block.state, &fixed);
  const auto variance = [](const PairResult& pair) {
    const SymmetricEnu& c = pair.covariance_m2;
    const Eigen::Matrix3d m = MatrixOf(c);
    const Eigen::Vector3d u = pair.difference_enu_m.normalized();
    return u.dot(m * u);
  };
  for (std::size_t i = 0; i < free.size(); ++i) {
    EXPECT_NEAR(variance(free[i]) / variance(fixed[i]), 1.0, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Degrees, InnerDatumTest, testing::Values(0, 1));

// A rotation about the line through two points moves neither: they cannot fix it.
TEST(InnerDatumTest, RefusesDatumPointsThatDoNotFixTheDatum) {
  const Floating block(1);
  std::vector<std::uint8_t> two(block.known.truth_m.size(), 0);
  two[2] = two[5] = 1;
  EXPECT_THROW((void)block.Datum(two), UndeterminedError);
}

// The whole adjustment: two datums of one noisy block have the same residuals and test, and the
// displacements at the datum points are orthogonal to every motion that is free (hand check with
// the three shifts: their mean vanishes).
TEST(InnerDatumTest, AdjustsAFloatingBlock) {
  test::KnownBlock known = StraightBlock();
  test::AddNoise(4711, 1.0, &known);
  Block& block = known.block;
  for (std::size_t i = 0; i < known.truth_m.size(); ++i) {
    block.points.given_m[i] = known.truth_m[i] + Eigen::Vector3d(0.3, -0.7, 0.2);
  }
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = FreePosition(1);
  options.datum = Datum::kInner;
  const AdjustResult all = Adjust(block, options);
  options.datum_points = {std::string(block.points.ids[1]),
                          std::string(block.points.ids[6]),
                          std::string(block.points.ids[10])};
  const AdjustResult some = Adjust(block, options);
  ASSERT_TRUE(all.usable());
  ASSERT_TRUE(some.usable());
  EXPECT_EQ(all.datum_defects, 6);
  EXPECT_NEAR(all.sigma0_squared / some.sigma0_squared, 1.0, 1e-9);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < known.truth_m.size(); ++i) {
    mean += all.points.position_m[i] - block.points.given_m[i];
  }
  EXPECT_LT(mean.norm(), 1e-6);
  // Both end within 1e-6 sigma of their solution, of some metre each.
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    EXPECT_NEAR(all.looks.range_residual_m[i], some.looks.range_residual_m[i], 1e-6);
    EXPECT_NEAR(all.looks.azimuth_residual_m[i], some.looks.azimuth_residual_m[i], 1e-6);
    for (const std::size_t component : {std::size_t{0}, std::size_t{1}}) {
      EXPECT_NEAR(all.quality.redundancy[component][i],
                  some.quality.redundancy[component][i],
                  1e-6);  // held as float
    }
  }
  double sum_all = 0.0, sum_some = 0.0;
  for (std::size_t i = 0; i < known.truth_m.size(); ++i) {
    const SymmetricEnu& a = all.points.covariance_m2[i];
    const SymmetricEnu& b = some.points.covariance_m2[i];
    sum_all += a[0] + a[1] + a[2];
    sum_some += b[0] + b[1] + b[2];
  }
  EXPECT_LT(sum_all, sum_some);  // the inner datum has the least trace
}

// On an orbit, shifts along the track turn with it: what looks like a free shift of all passes is a
// direction that the observations determine, if only weakly. Moved along it the block is another
// one.
TEST(InnerDatumTest, RefusesAMoveThatChangesTheResiduals) {
  const test::SceneBlock scene = test::SimulatedSceneBlock(
      "scenes", "earth-asc-desc", {"control.layout=none", "points.count=150"});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = FreePosition(0);
  options.datum = Datum::kInner;
  const AdjustResult result = Adjust(scene.block, options);
  EXPECT_EQ(result.assessment.verdict, Verdict::kNotAccepted);
  EXPECT_THAT(result.assessment.reasons,
              testing::Contains(testing::StartsWith("the datum is not free: moved")));
}

}  // namespace
}  // namespace sarblock
