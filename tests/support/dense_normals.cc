// SPDX-License-Identifier: Apache-2.0
#include "support/dense_normals.h"

#include "sarblock/model/result.h"

#include <span>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sarblock::test {

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
  for (int i = 0; i < problem.layout.size(); ++i) {
    const Parameter& parameter = problem.layout.parameters[static_cast<std::size_t>(i)];
    if (!parameter.has_own_prior()) continue;
    out.jacobian(row, columns + i) = 1.0 / parameter.prior_sigma;
    out.residual[row] = (state.corrections[i] - parameter.prior_value) / parameter.prior_sigma;
    ++row;
  }
  // Rows U' (c - c0) of joint priors, U U' = Q^-1 by the inverse of Q: not the program's factor.
  for (const JointPriorTerm& prior : problem.layout.joint_priors) {
    const Eigen::MatrixXd inverse = prior.covariance.fullPivLu().inverse();
    const Eigen::MatrixXd upper = inverse.llt().matrixU();
    const auto size = static_cast<Eigen::Index>(prior.parameters.size());
    for (Eigen::Index i = 0; i < size; ++i, ++row) {
      for (Eigen::Index j = 0; j < size; ++j) {
        const int parameter = prior.parameters[static_cast<std::size_t>(j)];
        out.jacobian(row, columns + parameter) = upper(i, j);
        out.residual[row] +=
            upper(i, j) *
            (state.corrections[parameter] -
             problem.layout.parameters[static_cast<std::size_t>(parameter)].prior_value);
      }
    }
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

Eigen::Matrix3d FrameFromEnu(const Frame& frame,
                             const Eigen::Vector3d& p_m,
                             const SymmetricEnu& enu_m2) {
  const Eigen::Matrix3d c = MatrixOf(enu_m2);
  const Eigen::Matrix3d e = frame.EnuFromFrame(p_m);
  return e.transpose() * c * e;
}

}  // namespace sarblock::test
