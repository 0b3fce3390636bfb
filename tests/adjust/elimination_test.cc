// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/elimination.h"

#include <cmath>

#include "support/small_blocks.h"
#include <Eigen/LU>
#include <Eigen/QR>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class EliminationTest : public testing::Test {
 protected:
  EliminationTest() : known_(test::MakeBlock(test::AircraftPlan(11.3))) {
    test::Hold(2, {0.31, 0.47, kNotGiven}, &known_);
    PositionCorrection position;
    position.degree = 1;
    problem_.emplace(known_.block,
                     std::vector<CorrectionGroup>{{"position", position, {}, false},
                                                  {"time", TimeCorrection{}, {}, true}});
    state_.start_m = known_.truth_m;
    state_.displacement_m.assign(known_.truth_m.size(), Eigen::Vector3d(3.7, -2.9, 5.3));
    state_.corrections.setConstant(problem_->layout.size(), 0.017);
    UpdateWhitening(state_, &*problem_);
  }
  test::KnownBlock known_;
  std::optional<AdjustmentProblem> problem_;
  BlockState state_;
};

// Second route: Eigen's Householder QR and the normal equations of the same rows.
TEST_F(EliminationTest, IsTheThinQrFactorisationAndTheSchurComplement) {
  for (const std::size_t point : {std::size_t{0}, std::size_t{2}}) {
    PointRows rows;
    LinearisePoint(*problem_, state_, {}, point, &rows);
    const Eigen::Index m = rows.row_count, n = rows.column_count + 1;
    ASSERT_EQ(m, point == 2 ? 10 : 8);
    ASSERT_EQ(n, 4 * 6 + 1 + 1);
    const Eigen::MatrixXd a = rows.a.topLeftCorner(m, 3 + n);
    const Eigen::MatrixXd jp = a.leftCols(3), rest = a.rightCols(n);
    const EliminatedPoint eliminated = EliminatePoint(&rows);

    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(jp);
    const Eigen::MatrixXd q1 = qr.householderQ() * Eigen::MatrixXd::Identity(m, 3);
    const Eigen::Matrix3d r = qr.matrixQR().topRows(3).triangularView<Eigen::Upper>();
    const Eigen::MatrixXd t = q1.transpose() * rest;
    const double size = rest.norm();  // the time column: 173 m/s over about a metre
    for (Eigen::Index k = 0; k < 3; ++k) {
      // A row of R is free in its sign.
      const double sign = std::copysign(1.0, r(k, k)) * std::copysign(1.0, eliminated.r(k, k));
      EXPECT_LT((eliminated.r.row(k) - sign * r.row(k)).norm(), 1e-13);
      EXPECT_LT((rows.a.block(k, 3, 1, n) - sign * t.row(k)).norm(), 1e-14 * size);
    }
    const Eigen::MatrixXd below = rows.a.block(3, 3, m - 3, n);
    const Eigen::MatrixXd schur =
        rest.transpose() * rest -
        rest.transpose() * jp * (jp.transpose() * jp).partialPivLu().solve(jp.transpose() * rest);
    EXPECT_LT((below.transpose() * below - schur).norm(), 1e-12 * size * size);
    // Nothing of J_p is left below R.
    EXPECT_LT(rows.a.block(3, 0, m - 3, 3).norm(), 1e-15);
  }
}

// Closed form: J_p with orthonormal columns times known scales has reciprocal condition 1/3 in the
// norm used (Frobenius: |I| |I| = 3); a column that is a copy of another leaves rounding only.
TEST_F(EliminationTest, MeasuresTheConditionOfTheScaledColumns) {
  PointRows rows;
  rows.row_count = 5;
  rows.column_count = 0;
  rows.a.setZero(5, 4);
  rows.a(0, 0) = 1e-3;
  rows.a(2, 1) = 17.3;
  rows.a(4, 2) = -4.1e5;
  EXPECT_NEAR(EliminatePoint(&rows).reciprocal_condition_1, 1.0 / 3.0, 1e-15);
  rows.a.setRandom(5, 4);
  rows.a.col(2) = 3.7 * rows.a.col(0);
  EXPECT_LT(EliminatePoint(&rows).reciprocal_condition_1, 1e-14);
  rows.a.setRandom(5, 4);
  rows.a.col(1).setZero();
  EXPECT_EQ(EliminatePoint(&rows).reciprocal_condition_1, 0.0);
  rows.a.setRandom(5, 4);
  rows.row_count = 2;  // one look: never enough
  EXPECT_EQ(EliminatePoint(&rows).reciprocal_condition_1, 0.0);
}

TEST_F(EliminationTest, RowsOfALookCarryTheRootOfItsRobustWeight) {
  const Weighting weighting{RobustLoss::kCauchy, 2.385};
  state_.displacement_m[0] = {31.3, -17.9, 23.7};  // residuals of tens of sigmas
  PointRows plain, robust;
  LinearisePoint(*problem_, state_, {}, 0, &plain);
  LinearisePoint(*problem_, state_, weighting, 0, &robust);
  const Eigen::Index last = 3 + plain.column_count;
  double cost = 0.0;
  for (Eigen::Index look = 0; look < 4; ++look) {
    const double square = plain.a.col(last).segment(2 * look, 2).squaredNorm();
    ASSERT_GT(square, 9.0);
    const RobustValue value = EvaluateLoss(weighting.loss, weighting.scale, square);
    const Eigen::MatrixXd expected =
        std::sqrt(value.weight_1) * plain.a.block(2 * look, 0, 2, last + 1);
    EXPECT_LT((robust.a.block(2 * look, 0, 2, last + 1) - expected).norm(),
              1e-12 * expected.norm());
    cost += 0.5 * value.loss_1;
  }
  EXPECT_NEAR(robust.cost_1, cost, 1e-12 * cost);
}

TEST_F(EliminationTest, ALookWithoutAValueIsCountedAndLeftOut) {
  known_.block.looks.time_s[1] = known_.block.passes[1].path.end_s() + 1.0;
  PointRows rows;
  LinearisePoint(*problem_, state_, {}, 0, &rows);
  EXPECT_EQ(rows.looks_not_evaluated, 1);
  EXPECT_EQ(rows.row_count, 6);
}

}  // namespace
}  // namespace sarblock
