// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>

#include "linear/dense.h"
#include "study/tradeoff.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

double TakeMedian(std::vector<double>* values) {
  if (values->empty()) return kNotGiven;
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

double Largest(const std::vector<double>& values) {
  return values.empty() ? kNotGiven : *std::max_element(values.begin(), values.end());
}

/// Rows across and up of an answer in closed form, in east-north-up.
Eigen::Matrix<double, 2, 3> AcrossUp(double azimuth_rad) {
  Eigen::Matrix<double, 2, 3> rows;
  rows << std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0, 0.0, 0.0, 1.0;
  return rows;
}

/// What an answer says of one point: rows that it speaks of, and their covariance.
struct Claim {
  Eigen::MatrixXd rows;
  Eigen::MatrixXd covariance_m2;
  [[nodiscard]] bool holds() const { return covariance_m2.size() > 0; }
};

Claim ClaimOf(const TradeoffAnswer& answer, std::size_t point) {
  Claim claim;
  if (!answer.covariance_m2.empty()) {
    if (!std::isfinite(answer.covariance_m2[point][0])) return claim;
    claim.rows = Eigen::Matrix3d::Identity();
    claim.covariance_m2 = MatrixOf(answer.covariance_m2[point]);
  } else if (!answer.sigma_across_m.empty()) {
    const Eigen::Vector2d sigma_m(answer.sigma_across_m[point], answer.sigma_up_m[point]);
    if (!sigma_m.allFinite() || !std::isfinite(answer.across_azimuth_rad[point])) return claim;
    claim.rows = AcrossUp(answer.across_azimuth_rad[point]);
    claim.covariance_m2 = sigma_m.cwiseAbs2().asDiagonal();
  }
  return claim;
}

}  // namespace

AnswerErrors CompareAnswers(const Block& block,
                            const TradeoffAnswer& answer,
                            const TradeoffAnswer& best,
                            const std::vector<Eigen::Vector3d>& truth_m) {
  AnswerErrors out;
  std::vector<double> shift_1, covariance_1;
  double square_m2 = 0.0, normalised_1 = 0.0, dimension = 0.0;
  std::size_t solved = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (block.points.role[point] != PointRole::kTie) continue;
    if (!best.position_m[point].allFinite()) continue;
    if (!answer.position_m[point].allFinite()) {
      ++out.points_missing;
      continue;
    }
    const Eigen::Matrix3d enu = block.frame.EnuFromFrame(best.position_m[point]);
    const Eigen::Matrix3d q = MatrixOf(best.covariance_m2[point]);
    const Eigen::Vector3d shift_m = enu * (answer.position_m[point] - best.position_m[point]);
    shift_1.push_back(std::sqrt(shift_m.dot(q.llt().solve(shift_m))));
    const Eigen::Vector3d error_m = enu * (answer.position_m[point] - truth_m[point]);
    square_m2 += error_m.squaredNorm();
    ++solved;
    const Claim claim = ClaimOf(answer, point);
    if (!claim.holds()) {
      ++out.points_unjudged;
      continue;
    }
    const Eigen::MatrixXd same = claim.rows * q * claim.rows.transpose();
    covariance_1.push_back((claim.covariance_m2 - same).norm() / same.norm());
    const Eigen::VectorXd e = claim.rows * error_m;
    normalised_1 += e.dot(dense::Cholesky(claim.covariance_m2).Solve(e));
    dimension += static_cast<double>(e.size());
  }
  out.position_error_1 = Largest(shift_1);
  out.position_median_1 = TakeMedian(&shift_1);
  out.covariance_error_1 = Largest(covariance_1);
  out.covariance_median_1 = TakeMedian(&covariance_1);
  if (solved > 0) out.rms_error_m = std::sqrt(square_m2 / static_cast<double>(solved));
  if (dimension > 0.0) out.nees_1 = normalised_1 / dimension;
  return out;
}

}  // namespace sarblock
