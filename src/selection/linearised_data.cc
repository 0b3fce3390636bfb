// SPDX-License-Identifier: Apache-2.0
#include "linearised_data.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
namespace {

/// Logarithm of the number of equations of looks that touch each column.
Eigen::VectorXd LogCounts(const AdjustmentProblem& problem) {
  std::vector<double> equations(problem.layout.blocks.size(), 0.0);
  LookColumns columns;
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] == 0) continue;
    problem.model.ColumnsOf(i, &columns);
    for (int b = 0; b < columns.block_count; ++b) {
      equations[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])] += 2.0;
    }
  }
  Eigen::VectorXd out(problem.layout.size());
  for (std::size_t b = 0; b < equations.size(); ++b) {
    const ParameterBlock& block = problem.layout.blocks[b];
    out.segment(block.offset, block.size).setConstant(std::log(std::max(2.0, equations[b])));
  }
  return out;
}

}  // namespace

QuadraticModel::Data DataAt(const ReducedSystem& system,
                            const Eigen::VectorXd& corrections,
                            const std::vector<Parameter>& parameters) {
  QuadraticModel::Data data;
  data.s = system.matrix().ToDense();
  const Eigen::VectorXd sx = data.s * corrections;
  data.b = sx - system.right_side();
  data.constant_1 = 2.0 * system.cost() - system.point_step_square() -
                    2.0 * system.right_side().dot(corrections) + sx.dot(corrections);
  data.full_diagonal = system.full_diagonal();
  data.prior_weight.setZero(corrections.size());
  data.log_count = LogCounts(system.problem());
  for (Eigen::Index i = 0; i < corrections.size(); ++i) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
    if (parameter.has_prior()) {
      data.prior_weight[i] = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
    }
  }
  return data;
}

}  // namespace sarblock
