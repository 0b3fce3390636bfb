// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Covariances of points by the textbook's way: all normal equations J'J of points and corrections,
/// scaled to unit diagonal, a Cholesky factor and its inverse, in double or in single precision.
/// Empty where the matrix has no factor.
enum class Precision { kSingle, kDouble };
[[nodiscard]] std::vector<SymmetricEnu> CovariancesByNormals(const AdjustmentProblem& problem,
                                                             const BlockState& state,
                                                             Precision precision);

/// Largest relative error of a 3 x 3 block in Frobenius' norm; infinite where one is missing.
[[nodiscard]] double CovarianceError(const std::vector<SymmetricEnu>& computed,
                                     const std::vector<SymmetricEnu>& exact);

}  // namespace sarblock
