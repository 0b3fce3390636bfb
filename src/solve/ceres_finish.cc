// SPDX-License-Identifier: Apache-2.0
#include "ceres_finish.h"

#include <cmath>
#include <vector>

#include "step_tolerance.h"
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <ceres/crs_matrix.h>

namespace sarblock {
namespace {

/// The unknowns in one order: displacements of solved points, then corrections.
std::vector<double*> BlocksOf(const AdjustmentProblem& problem, BlockState* state) {
  std::vector<double*> blocks;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) blocks.push_back(state->displacement_m[point].data());
  }
  for (const ParameterBlock& block : problem.layout.blocks) {
    blocks.push_back(state->corrections.data() + block.offset);
  }
  return blocks;
}

struct NewtonStep {
  bool solved = false;
  Eigen::VectorXd step;
  double length_1 = 0.0;  ///< in sigmas
};

NewtonStep StepAt(ceres::Problem* problem, const std::vector<double*>& blocks, int threads) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks;
  options.num_threads = threads;
  std::vector<double> residuals;
  ceres::CRSMatrix rows;
  NewtonStep out;
  if (!problem->Evaluate(options, nullptr, &residuals, nullptr, &rows)) return out;
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(
      rows.num_rows,
      rows.num_cols,
      static_cast<Eigen::Index>(rows.values.size()),
      rows.rows.data(),
      rows.cols.data(),
      rows.values.data());
  const Eigen::Map<const Eigen::VectorXd> e(residuals.data(), rows.num_rows);
  const Eigen::SparseMatrix<double> j = jacobian;
  const Eigen::SparseMatrix<double> normals = j.transpose() * j;
  const Eigen::VectorXd gradient = j.transpose() * e;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(normals);
  if (factor.info() != Eigen::Success) return out;
  out.step = -factor.solve(gradient);
  out.length_1 = std::sqrt(std::max(0.0, -gradient.dot(out.step)));
  out.solved = out.step.allFinite();
  return out;
}

void Move(const ceres::Problem& problem,
          const std::vector<double*>& blocks,
          const Eigen::VectorXd& step,
          double sign) {
  Eigen::Index at = 0;
  for (double* block : blocks) {
    const int size = problem.ParameterBlockSize(block);
    for (int i = 0; i < size; ++i) block[i] += sign * step[at++];
  }
}

}  // namespace

void FinishByNewton(const AdjustmentProblem& problem,
                    int threads,
                    double settled_1,
                    ceres::Problem* ceres_problem,
                    BlockState* state) {
  constexpr int kSteps = 3;
  if (problem.block.points.size() > kMostFinished) return;
  const std::vector<double*> blocks = BlocksOf(problem, state);
  NewtonStep now = StepAt(ceres_problem, blocks, threads);
  if (!now.solved || now.length_1 > kLongestFinish_1) return;
  for (int k = 0; k < kSteps && now.length_1 > ShareOf(settled_1, problem); ++k) {
    Move(*ceres_problem, blocks, now.step, 1.0);
    NewtonStep next = StepAt(ceres_problem, blocks, threads);
    if (!next.solved || !(next.length_1 < now.length_1)) {
      Move(*ceres_problem, blocks, now.step, -1.0);
      return;
    }
    now = std::move(next);
  }
}

}  // namespace sarblock
