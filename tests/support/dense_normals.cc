// SPDX-License-Identifier: Apache-2.0
#include "support/dense_normals.h"

#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <variant>
#include <vector>

#include "linear/dense.h"
#include "solve/start.h"
#include <gtest/gtest.h>

namespace sarblock::test {
namespace {

/// Covariance of the coefficients of a process by its definition, all with all.
Eigen::MatrixXd CovarianceOfProcess(const PositionCorrection& position,
                                    std::size_t axis,
                                    double span_s,
                                    Eigen::Index count) {
  const double sigma_m = position.prior_sigma_m[axis].front();
  const auto steps = static_cast<double>(count - 1);
  const double spacing_s = span_s / static_cast<double>(count - 3);
  Eigen::MatrixXd q(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const auto apart = static_cast<double>(std::abs(i - j));
      const auto gained = static_cast<double>(std::min(i, j)) / steps;
      q(i, j) = position.process == PositionCorrection::Process::kGaussMarkov
                    ? sigma_m * sigma_m * std::exp(-apart * spacing_s / position.correlation_time_s)
                    : std::pow(position.start_sigma_m[axis], 2) + sigma_m * sigma_m * gained;
    }
  }
  return q;
}

/// Parameters of each process: from a first coefficient as far as others lead on from it.
std::vector<std::vector<int>> ProcessesOf(const ParameterLayout& layout) {
  std::map<int, std::vector<int>> by_last;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& parameter = layout.parameters[static_cast<std::size_t>(i)];
    if (parameter.before < 0) {
      by_last[i] = {i};
      continue;
    }
    auto chain = by_last.extract(parameter.before);
    chain.mapped().push_back(i);
    by_last[i] = chain.mapped();
  }
  std::vector<std::vector<int>> out;
  for (const auto& [last, chain] : by_last) {
    if (chain.size() > 1) out.push_back(chain);
  }
  return out;
}

/// Rows U' (c - c0), U U' = Q^-1 by the inverse of Q: not the program's factor.
void AppendRows(const AdjustmentProblem& problem,
                const BlockState& state,
                const std::vector<int>& parameters,
                const Eigen::MatrixXd& q,
                Eigen::Index* row,
                DenseEquations* out) {
  const Eigen::MatrixXd upper = dense::Cholesky(dense::Cholesky(q).Inverse()).L().transpose();
  for (Eigen::Index i = 0; i < q.rows(); ++i, ++*row) {
    for (Eigen::Index j = 0; j < q.cols(); ++j) {
      const int parameter = parameters[static_cast<std::size_t>(j)];
      const double value =
          problem.layout.parameters[static_cast<std::size_t>(parameter)].prior_value;
      out->jacobian(*row, out->first_correction + parameter) = upper(i, j);
      out->residual[*row] += upper(i, j) * (state.corrections[parameter] - value);
    }
  }
}

}  // namespace

BlockState StateOf(const AdjustResult& result, AdjustmentProblem* problem) {
  BlockState state = ComputeStartValues(problem, nullptr).state;
  for (std::size_t point = 0; point < state.start_m.size(); ++point) {
    state.displacement_m[point] = result.points.position_m[point] - state.start_m[point];
  }
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    state.corrections[static_cast<Eigen::Index>(i)] = result.parameters[i].value;
  }
  UpdateWeights(state, problem);
  return state;
}

DenseEquations MakeDenseEquations(const AdjustmentProblem& problem, const BlockState& state) {
  DenseEquations out;
  const Block& block = problem.block;
  int columns = 0;
  Eigen::Index rows = 0;
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    out.column_of_point.push_back(problem.Solves(j) ? columns : -1);
    if (!problem.Solves(j)) continue;
    columns += 3;
    rows += 2 * problem.CountLooks(j) + 3;
  }
  out.first_correction = columns;
  const int all = columns + problem.layout.size();
  out.jacobian.setZero(rows + problem.layout.size(), all);
  out.residual.setZero(out.jacobian.rows());
  Eigen::Index row = 0;
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    if (!problem.Solves(j)) continue;
    const int at_point = out.column_of_point[j];
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      LookColumns local;
      LookEvaluation at;
      if (!EvaluateLook(problem.model, state, j, i, problem.weights[i], &local, &at)) {
        throw std::logic_error("a look of a test block has no value");
      }
      out.jacobian.block<2, 3>(row, at_point) = at.d_point;
      out.residual.segment<2>(row) = at.whitened_error;
      std::size_t from = 0;
      for (int b = 0; b < local.block_count; ++b) {
        const ParameterBlock& to =
            problem.layout
                .blocks[static_cast<std::size_t>(local.block[static_cast<std::size_t>(b)])];
        for (int c = 0; c < to.size; ++c, ++from) {
          out.jacobian(row, columns + to.offset + c) = at.row[0][from];
          out.jacobian(row + 1, columns + to.offset + c) = at.row[1][from];
        }
      }
      row += 2;
    }
    if (problem.control_of[j] < 0) continue;
    const ControlEquations& control =
        problem.control[static_cast<std::size_t>(problem.control_of[j])];
    const ControlEvaluation at =
        EvaluateControl(block.frame, control, state.start_m[j], state.displacement_m[j]);
    out.jacobian.block(row, at_point, control.rows, 3) = at.d_point.topRows(control.rows);
    out.residual.segment(row, control.rows) = at.residual.head(control.rows);
    row += control.rows;
  }
  std::set<int> in_process;
  for (const std::vector<int>& chain : ProcessesOf(problem.layout)) {
    in_process.insert(chain.begin(), chain.end());
    const Parameter& first = problem.layout.parameters[static_cast<std::size_t>(chain.front())];
    for (const CorrectionGroup& group : problem.groups) {
      const auto* position = std::get_if<PositionCorrection>(&group.model);
      if (position == nullptr || position->process == PositionCorrection::Process::kWhite) continue;
      const Pass& pass = *std::find_if(block.passes.begin(),
                                       block.passes.end(),
                                       [&](const Pass& p) { return p.id == first.owner; });
      AppendRows(problem,
                 state,
                 chain,
                 CovarianceOfProcess(*position,
                                     static_cast<std::size_t>(first.axis),
                                     pass.end_s - pass.start_s,
                                     static_cast<Eigen::Index>(chain.size())),
                 &row,
                 &out);
    }
  }
  for (int i = 0; i < problem.layout.size(); ++i) {
    const Parameter& parameter = problem.layout.parameters[static_cast<std::size_t>(i)];
    if (!parameter.has_own_prior() || in_process.contains(i)) continue;
    out.jacobian(row, columns + i) = 1.0 / parameter.prior_sigma;
    out.residual[row] = (state.corrections[i] - parameter.prior_value) / parameter.prior_sigma;
    ++row;
  }
  for (const JointPriorTerm& prior : problem.layout.joint_priors) {
    AppendRows(problem, state, prior.parameters, prior.covariance, &row, &out);
  }
  out.jacobian.conservativeResize(row, all);
  out.residual.conservativeResize(row);
  return out;
}

Eigen::MatrixXd DenseCovariance(const Eigen::MatrixXd& jacobian) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix a = jacobian.cast<long double>();
  const Eigen::Matrix<long double, 1, Eigen::Dynamic> length = a.colwise().norm();
  for (Eigen::Index c = 0; c < a.cols(); ++c) a.col(c) /= length[c];
  const Eigen::HouseholderQR<Matrix> qr(a);
  const Matrix r = qr.matrixQR().topRows(a.cols());
  Matrix inverse = Matrix::Identity(a.cols(), a.cols());
  r.template triangularView<Eigen::Upper>().solveInPlace(inverse);
  Matrix covariance = inverse * inverse.transpose();
  for (Eigen::Index c = 0; c < a.cols(); ++c) {
    covariance.col(c) /= length[c];
    covariance.row(c) /= length[c];
  }
  return covariance.cast<double>();
}

void ExpectDenseLeastSquares(const AdjustmentProblem& problem,
                             const BlockState& state,
                             const AdjustResult& result,
                             double max_step) {
  const DenseEquations dense = MakeDenseEquations(problem, state);
  const Eigen::MatrixXd covariance = DenseCovariance(dense.jacobian);
  const Eigen::VectorXd step = covariance * (dense.jacobian.transpose() * dense.residual);
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  EXPECT_LT(step.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), max_step);
  const double square_sum = dense.residual.squaredNorm();
  EXPECT_NEAR(2.0 * result.final_cost, square_sum, 1e-9 * square_sum);
  for (std::size_t point = 0; point < dense.column_of_point.size(); ++point) {
    const int at = dense.column_of_point[point];
    if (at < 0) continue;
    const Eigen::Matrix3d expected = covariance.block<3, 3>(at, at);
    const Eigen::Matrix3d given = FrameFromEnu(
        problem.block.frame, state.Position(point), result.points.covariance_m2[point]);
    EXPECT_LT((given - expected).norm(), 1e-9 * expected.norm()) << point;
  }
  for (const ParameterCovariance& entry : result.parameter_covariance) {
    const auto a = static_cast<Eigen::Index>(entry.a) + dense.first_correction;
    const auto b = static_cast<Eigen::Index>(entry.b) + dense.first_correction;
    EXPECT_NEAR(entry.covariance, covariance(a, b), 1e-9 * sigma[a] * sigma[b]);
  }
}

Eigen::Matrix3d FrameFromEnu(const Frame& frame,
                             const Eigen::Vector3d& p_m,
                             const SymmetricEnu& enu_m2) {
  const Eigen::Matrix3d c = MatrixOf(enu_m2);
  const Eigen::Matrix3d e = frame.EnuFromFrame(p_m);
  return e.transpose() * c * e;
}

}  // namespace sarblock::test
