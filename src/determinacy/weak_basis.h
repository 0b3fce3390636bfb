// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// A direction of the scaled parameters, unit length, with its name where it is a rigid motion.
struct NamedDirection {
  Eigen::VectorXd vector;
  std::string motion;
};

/// A basis of a weak subspace (`weak`: orthonormal or nearly so, columns in scaled parameters) that
/// can be put in words. First the rigid motions of the block, or of each island of it, that lie in
/// the subspace; then the rest, each with a parameter of its own that the others leave alone, so
/// that local ones stay local. Both depend on the subspace and not on the vectors that span it,
/// which rounding turns. docs/theory/rank.md, section 4.
[[nodiscard]] std::vector<NamedDirection> NameableBasis(const AdjustmentProblem& problem,
                                                        const std::vector<int>& pass_of_parameter,
                                                        const Eigen::VectorXd& scale,
                                                        const Eigen::MatrixXd& weak);

}  // namespace sarblock
