// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "linear/dense.h"
#include "normals/point.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class EliminationTest : public testing::Test {
 protected:
  EliminationTest() : known_(test::MakeBlock(test::AircraftPlan(11.3))) {
    test::AddKnownPoint(2, {0.31, 0.47, kNotGiven}, &known_);
    PositionCorrection position;
    position.degree = 1;
    problem_.emplace(known_.block,
                     std::vector<CorrectionGroup>{{"position", position, {}, false},
                                                  {"time", TimeCorrection{}, {}, true}});
    state_.start_m = known_.truth_m;
    state_.displacement_m.assign(known_.truth_m.size(), Eigen::Vector3d(3.7, -2.9, 5.3));
    state_.corrections.setConstant(problem_->layout.size(), 0.017);
    UpdateWeights(state_, &*problem_);
  }
  /// The point's equations as dense matrices: J_p and [J_c | e].
  struct Rows {
    Eigen::MatrixXd d_point, rest;
  };
  Rows RowsOf(const PointFactor& factor, const PointColumns& columns, std::size_t point) const {
    Rows out{Eigen::MatrixXd::Zero(factor.row_count, 3),
             Eigen::MatrixXd::Zero(factor.row_count, columns.width + 1)};
    for (int k = 0; k < factor.look_count; ++k) {
      const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
      out.d_point.middleRows(2 * k, 2) = look.d_point;
      std::size_t local = 0;
      for (int b = 0; b < look.columns.block_count; ++b) {
        const auto block =
            static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)]);
        for (int i = 0; i < problem_->layout.blocks[block].size; ++i, ++local) {
          out.rest(2 * k, columns.column_of_block[block] + i) = look.row[0][local];
          out.rest(2 * k + 1, columns.column_of_block[block] + i) = look.row[1][local];
        }
      }
    }
    if (problem_->control_of[point] >= 0) {
      const ControlEquations& control =
          problem_->control[static_cast<std::size_t>(problem_->control_of[point])];
      out.d_point.bottomRows(control.rows) =
          EvaluateControl(known_.block.frame, control, state_.start_m[point], {0.0, 0.0, 0.0})
              .d_point.topRows(control.rows);
    }
    for (int i = 0; i < factor.row_count; ++i) {
      out.rest(i, columns.width) = factor.e[static_cast<std::size_t>(i)];
    }
    return out;
  }
  test::KnownBlock known_;
  std::optional<AdjustmentProblem> problem_;
  BlockState state_;
};

// Second route: Eigen's Householder QR and the normal equations of the same rows.
TEST_F(EliminationTest, IsTheThinQrFactorisationAndTheSchurComplement) {
  for (const std::size_t point : {std::size_t{0}, std::size_t{2}}) {
    PointFactor factor;
    PointColumns columns;
    FactorPoint(*problem_, state_, {}, 0.0, point, &factor);
    ProjectColumns(*problem_, factor, &columns);
    Complement(*problem_, factor, &columns);
    const Eigen::Index m = factor.row_count, n = columns.width + 1;
    ASSERT_EQ(m, point == 2 ? 10 : 8);
    ASSERT_EQ(n, 4 * 6 + 1 + 1);
    const Rows rows = RowsOf(factor, columns, point);
    const Eigen::MatrixXd& jp = rows.d_point;
    const Eigen::MatrixXd& rest = rows.rest;

    const dense::Orthogonal qr(jp);
    const Eigen::MatrixXd q1 = qr.Q(3);
    const Eigen::Matrix3d r = qr.R();
    const Eigen::MatrixXd t = q1.transpose() * rest;
    const double size = rest.norm();  // the time column: 173 m/s over about a metre
    const Eigen::Vector3d c = Project(factor, factor.e);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double sign =
          std::copysign(1.0, r(k, k));  // Householder's diagonal is free in its sign
      EXPECT_LT((factor.r.row(k) - sign * r.row(k)).norm(), 1e-13);
      for (Eigen::Index i = 0; i + 1 < n; ++i) {
        EXPECT_NEAR(
            columns.t[static_cast<std::size_t>(k * (n - 1) + i)], sign * t(k, i), 1e-14 * size);
      }
      EXPECT_NEAR(c[k], sign * t(k, n - 1), 1e-14 * size);
    }
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
        complement(columns.m.data(), m, n);
    const Eigen::MatrixXd shared = jp.transpose() * rest;
    const Eigen::MatrixXd schur =
        rest.transpose() * rest -
        shared.transpose() * dense::Cholesky(jp.transpose() * jp).Inverse() * shared;
    EXPECT_LT((complement.transpose() * complement - schur).norm(), 1e-12 * size * size);
    // Nothing of J_p is left in it.
    EXPECT_LT((q1.transpose() * complement).norm(), 1e-15 * size);
  }
}

// Closed form: J_p of control alone is L^-1 E, here a diagonal: its
// columns scaled are orthonormal, and the reciprocal condition is 1/3 in the norm used (Frobenius:
// |I| |I| = 3). A point without enough rows has none.
TEST_F(EliminationTest, MeasuresTheConditionOfTheScaledColumns) {
  PointFactor factor;
  test::AddKnownPoint(3, {1e-3, 17.3, 4.1e5}, &known_);
  AdjustmentProblem fixed(known_.block, {});
  std::fill(fixed.look_used.begin(), fixed.look_used.end(), std::uint8_t{0});
  FactorPoint(fixed, state_, {}, 0.0, 3, &factor);
  EXPECT_NEAR(factor.reciprocal_condition, 1.0 / 3.0, 1e-15);
  FactorPoint(fixed, state_, {}, 0.0, 2, &factor);  // plan only: the height is open
  EXPECT_EQ(factor.reciprocal_condition, 0.0);
  FactorPoint(fixed, state_, {}, 0.0, 0, &factor);  // nothing at all
  EXPECT_EQ(factor.reciprocal_condition, 0.0);
}

// Two looks from one place constrain a circle: rounding is all that is left of the third column.
TEST_F(EliminationTest, FindsTheDirectionThatTwoEqualLooksLeaveOpen) {
  Block& block = known_.block;
  const std::size_t first = block.looks.offsets[0];
  for (std::size_t i = first; i < block.looks.offsets[1]; ++i) {
    block.looks.pass[i] = block.looks.pass[first];
    block.looks.time_s[i] = block.looks.time_s[first];
  }
  PointFactor factor;
  FactorPoint(*problem_, state_, {}, 0.0, 0, &factor);
  EXPECT_LT(factor.reciprocal_condition, 1e-14);
}

TEST_F(EliminationTest, RowsOfALookCarryTheRootOfItsRobustWeight) {
  const Weighting weighting{RobustLoss::kCauchy, 2.385};
  state_.displacement_m[0] = {31.3, -17.9, 23.7};  // residuals of tens of sigmas
  PointFactor plain, robust;
  PointColumns columns;
  FactorPoint(*problem_, state_, {}, 0.0, 0, &plain);
  FactorPoint(*problem_, state_, weighting, 0.0, 0, &robust);
  ProjectColumns(*problem_, plain, &columns);
  const Rows plain_rows = RowsOf(plain, columns, 0), robust_rows = RowsOf(robust, columns, 0);
  double cost = 0.0;
  for (Eigen::Index look = 0; look < 4; ++look) {
    const double square = plain_rows.rest.rightCols(1).middleRows(2 * look, 2).squaredNorm();
    ASSERT_GT(square, 9.0);
    const RobustValue value = EvaluateLoss(weighting.loss, weighting.scale, square);
    const double root = std::sqrt(value.weight);
    const Eigen::MatrixXd expected = root * plain_rows.rest.middleRows(2 * look, 2);
    EXPECT_LT((robust_rows.rest.middleRows(2 * look, 2) - expected).norm(),
              1e-12 * expected.norm());
    const Eigen::MatrixXd d_point = root * plain_rows.d_point.middleRows(2 * look, 2);
    EXPECT_LT((robust_rows.d_point.middleRows(2 * look, 2) - d_point).norm(), 1e-12);
    cost += 0.5 * value.loss;
  }
  EXPECT_NEAR(robust.cost, cost, 1e-12 * cost);
}

TEST_F(EliminationTest, ALookWithoutAValueIsCountedAndLeftOut) {
  const FlightPath& path = known_.block.passes[1].path;
  known_.block.looks.time_s[1] = path.end_s() + 1.01 * (path.end_s() - path.start_s());
  PointFactor factor;
  FactorPoint(*problem_, state_, {}, 0.0, 0, &factor);
  EXPECT_EQ(factor.looks_not_evaluated, 1);
  EXPECT_EQ(factor.row_count, 6);
}

}  // namespace
}  // namespace sarblock
