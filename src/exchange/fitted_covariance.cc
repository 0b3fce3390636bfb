// SPDX-License-Identifier: Apache-2.0
#include "fitted_covariance.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>

#include "linear/dense.h"
#include <Eigen/Dense>

namespace sarblock {

Eigen::MatrixXd FitParameters(std::span<const FitTime> times) {
  if (times.empty()) throw InputError("times", "none to fit at");
  const Eigen::Index unknowns = times.front().by_format.cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(unknowns, times.front().by_result.cols());
  for (const FitTime& time : times) {
    normal += time.by_format.transpose() * time.by_format;
    right += time.by_format.transpose() * time.by_result;
  }
  // Columns are metres and metres per second: scaled to unit diagonal.
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) throw InputError("times", "do not determine the parameters");
  const Eigen::MatrixXd scaled =
      scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
  const dense::PivotedCholesky factor(scaled);
  constexpr double kLeastPivot = 1e-10;
  if (!factor.PivotsAbove(kLeastPivot)) {
    throw InputError("times", "do not determine the parameters");
  }
  const Eigen::MatrixXd solution =
      factor.Solve(Eigen::MatrixXd(scale.cwiseInverse().asDiagonal() * right));
  return scale.cwiseInverse().asDiagonal() * solution;
}

double UnfittedSigma_m(std::span<const FitTime> times,
                       Eigen::Index rows,
                       const Eigen::MatrixXd& fit,
                       const Eigen::MatrixXd& covariance) {
  double largest_m2 = 0.0;
  for (const FitTime& time : times) {
    const Eigen::MatrixXd rest = time.by_result.topRows(rows) - time.by_format.topRows(rows) * fit;
    largest_m2 = std::max(largest_m2, (rest * covariance * rest.transpose()).trace());
  }
  return std::sqrt(largest_m2);
}

}  // namespace sarblock
