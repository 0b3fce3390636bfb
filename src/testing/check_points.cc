// SPDX-License-Identifier: Apache-2.0
#include "check_points.h"

#include "sarblock/model/result.h"

#include <cmath>

#include "linear/dense.h"

namespace sarblock {

void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  const double factor_1 = CovarianceFactor(options, *result);
  for (const KnownPosition& known : block.points.known) {
    const std::size_t point = known.point;
    if (block.points.role[point] != PointRole::kCheck) continue;
    if (!result->points.position_m[point].allFinite()) continue;
    CheckResult check;
    check.point = known.point;
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(block.points.given_m[point]) *
        (result->points.position_m[point] - block.points.given_m[point]);
    check.error_enu_m.setConstant(kNotGiven);
    std::array<int, 3> held{};
    for (int i = 0; i < 3; ++i) {
      if (!known.held[static_cast<std::size_t>(i)]) continue;
      check.error_enu_m[i] = error_m[i];
      if (!result->points.covariance_m2.empty()) {
        check.sigma_enu_m[i] =
            std::sqrt(factor_1 * result->points.covariance_m2[point][static_cast<std::size_t>(i)] +
                      known.covariance_enu_m2(i, i));
      }
      held[static_cast<std::size_t>(check.components++)] = i;
    }
    check.chi_square = kNotGiven;
    if (!result->points.covariance_m2.empty() && IsSolved(result->points.status[point]) &&
        check.components > 0) {
      const Eigen::Matrix3d full =
          factor_1 * MatrixOf(result->points.covariance_m2[point]) + known.covariance_enu_m2;
      Eigen::MatrixXd part(check.components, check.components);
      Eigen::VectorXd e(check.components);
      for (int i = 0; i < check.components; ++i) {
        e[i] = error_m[held[static_cast<std::size_t>(i)]];
        for (int j = 0; j < check.components; ++j) {
          part(i, j) = full(held[static_cast<std::size_t>(i)], held[static_cast<std::size_t>(j)]);
        }
      }
      const dense::Cholesky factor(part);
      if (factor.positive_definite()) {
        check.chi_square = factor.SolveLower(e).squaredNorm();
      }
    }
    result->checks.push_back(check);
  }
}

}  // namespace sarblock
