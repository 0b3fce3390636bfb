// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <limits>
#include <string>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// An adjustment beside the same one with 50 decimal digits: the equations of exact_model.h,
/// Gauss-Newton from the result to a step of 1e-14 sigmas, weights formed anew in each iteration,
/// all normal equations at once, a Cholesky factor and its inverse. What the files say (times,
/// ranges, states, standard deviations) counts as exact; points and looks that the result left out
/// are left out here too.
struct ExactComparison {
  std::string failure;  ///< empty, or why there is nothing to compare with
  int iterations = 0;
  double condition_1 = std::numeric_limits<double>::quiet_NaN();  ///< of J with unit columns
  /// Largest sqrt(e' Q^-1 e) of a point, e its error and Q its exact 3 x 3 covariance, or
  /// |error| / sigma of a correction.
  double error_sigma_1 = 0.0;
  double position_error_1 = 0.0;    ///< largest |e| of a point over its shortest range
  double covariance_error_1 = 0.0;  ///< largest relative error of a 3 x 3 block, Frobenius
  double sigma_error_1 = 0.0;       ///< largest relative error of a sigma, points and corrections
  std::vector<SymmetricEnu> covariance_m2;  ///< exact, by point; NaN where not solved
};

/// `problem` is the result's own: points and looks in use as it left them.
[[nodiscard]] ExactComparison CompareWithExact(const AdjustmentProblem& problem,
                                               const AdjustResult& result);

}  // namespace sarblock
