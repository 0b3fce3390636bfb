// SPDX-License-Identifier: Apache-2.0
#include "residual_covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "covariance/point_sweep.h"
#include "linear/dense.h"
#include "normals/point.h"
#include "reliability.h"

namespace sarblock {
namespace {

/// The equations of one point, [J_p | J_c | e] with the columns of J_c those of `blocks`.
struct PointEquations {
  std::vector<std::uint64_t> looks;
  std::vector<int> blocks;  // parameter blocks, ascending
  std::vector<int> column;  // of each within J_c
  int columns = 0;          // of J_c
  Eigen::MatrixXd a;
};

std::vector<WhitenedLook> EvaluateLooks(const AdjustmentProblem& problem,
                                        const BlockState& state,
                                        std::size_t point,
                                        std::vector<std::uint64_t>* indices) {
  std::vector<WhitenedLook> looks;
  const auto& offsets = problem.block.looks.offsets;
  for (std::uint64_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    looks.emplace_back();
    if (EvaluateWhitened(problem, state, {}, point, i, &looks.back())) {
      indices->push_back(i);
    } else {
      looks.pop_back();
    }
  }
  return looks;
}

void CollectBlocks(const ParameterLayout& layout,
                   const std::vector<WhitenedLook>& looks,
                   PointEquations* out) {
  for (const WhitenedLook& look : looks) {
    out->blocks.insert(out->blocks.end(),
                       look.columns.block.begin(),
                       look.columns.block.begin() + look.columns.block_count);
  }
  std::sort(out->blocks.begin(), out->blocks.end());
  out->blocks.erase(std::unique(out->blocks.begin(), out->blocks.end()), out->blocks.end());
  for (const int block : out->blocks) {
    out->column.push_back(out->columns);
    out->columns += layout.blocks[static_cast<std::size_t>(block)].size;
  }
}

void AddLook(const WhitenedLook& look,
             const ParameterLayout& layout,
             Eigen::Index row,
             PointEquations* out) {
  out->a.block<2, 3>(row, 0) = look.by_point;
  out->a.block<2, 1>(row, 3 + out->columns) = look.error_1;
  std::size_t local = 0;
  for (int b = 0; b < look.columns.block_count; ++b) {
    const int block = look.columns.block[static_cast<std::size_t>(b)];
    const auto at = std::lower_bound(out->blocks.begin(), out->blocks.end(), block);
    const auto first = 3 + out->column[static_cast<std::size_t>(at - out->blocks.begin())];
    for (int c = 0; c < layout.blocks[static_cast<std::size_t>(block)].size; ++c, ++local) {
      out->a(row, first + c) = look.row[0][local];
      out->a(row + 1, first + c) = look.row[1][local];
    }
  }
}

PointEquations EquationsOf(const AdjustmentProblem& problem,
                           const BlockState& state,
                           std::size_t point) {
  PointEquations out;
  const std::vector<WhitenedLook> looks = EvaluateLooks(problem, state, point, &out.looks);
  CollectBlocks(problem.layout, looks, &out);
  const ControlEquations* control =
      problem.control_of[point] < 0
          ? nullptr
          : &problem.control[static_cast<std::size_t>(problem.control_of[point])];
  const auto look_rows = static_cast<Eigen::Index>(2 * looks.size());
  out.a.setZero(look_rows + (control == nullptr ? 0 : control->rows), 3 + out.columns + 1);
  for (std::size_t k = 0; k < looks.size(); ++k) {
    AddLook(looks[k], problem.layout, static_cast<Eigen::Index>(2 * k), &out);
  }
  if (control != nullptr) {
    const ControlEvaluation at = EvaluateControl(
        problem.block.frame, *control, state.start_m[point], state.displacement_m[point]);
    out.a.bottomLeftCorner(control->rows, 3) = at.by_point.topRows(control->rows);
    out.a.bottomRightCorner(control->rows, 1) = at.residual.head(control->rows);
  }
  return out;
}

/// C over the blocks of a point.
Eigen::MatrixXd Gather(const BlockSymmetricMatrix& inverse, const PointEquations& equations) {
  Eigen::MatrixXd c(equations.columns, equations.columns);
  for (std::size_t i = 0; i < equations.blocks.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto block = inverse.Block(equations.blocks[i], equations.blocks[j]);
      const int ri = equations.column[i], rj = equations.column[j];
      c.block(ri, rj, block.rows(), block.cols()) = block;
      c.block(rj, ri, block.cols(), block.rows()) = block.transpose();
    }
  }
  return c;
}

}  // namespace

double PointResiduals::w_1(Eigen::Index i) const {
  const double r = q_vv_1(i, i);
  return r > kLeastRedundancy_1 ? v_1[i] / std::sqrt(r) : std::numeric_limits<double>::quiet_NaN();
}

double PointResiduals::Correlation(Eigen::Index i, Eigen::Index k) const {
  return q_vv_1(i, k) / std::sqrt(q_vv_1(i, i) * q_vv_1(k, k));
}

PointResiduals ResidualsOfPoint(const AdjustmentProblem& problem,
                                const BlockState& state,
                                const CorrectionCovariance* inverse,
                                std::size_t point) {
  PointResiduals out;
  PointEquations equations = EquationsOf(problem, state, point);
  out.looks = equations.looks;
  out.looks_of_point = out.looks.size();
  Eigen::MatrixXd& a = equations.a;
  const Eigen::Index m = a.rows(), columns = equations.columns;
  out.control_rows = static_cast<int>(m) - 2 * static_cast<int>(out.looks.size());
  out.v_1 = a.col(3 + columns);
  const dense::Orthogonal qr(a.leftCols(3));
  const Eigen::MatrixXd q = qr.Q(m);
  const Eigen::MatrixXd q2 = q.rightCols(m - 3);
  const Eigen::Matrix3d r = qr.R();
  out.q_vv_1 = q2 * q2.transpose();
  Eigen::MatrixXd gain = q.leftCols(3).transpose();
  out.information_1 = q.leftCols(3);
  out.shared_1.setZero(m);
  if (inverse != nullptr && columns > 0) {
    const Eigen::MatrixXd turned = q.transpose() * a.middleCols(3, columns);
    const Eigen::MatrixXd c_b =
        Gather(inverse->blocks, equations) * turned.bottomRows(m - 3).transpose();
    const Eigen::MatrixXd shared = q2 * (turned.bottomRows(m - 3) * c_b) * q2.transpose();
    out.q_vv_1 -= shared;
    out.shared_1 = shared.diagonal();
    gain -= turned.topRows(3) * c_b * q2.transpose();
  }
  out.shift_m = r.triangularView<Eigen::Upper>().solve(gain);
  return out;
}

PointResiduals ResidualsOfLook(const AdjustmentProblem& problem,
                               const BlockState& state,
                               const CorrectionCovariance* inverse,
                               std::size_t point,
                               std::uint64_t look) {
  const std::vector<LookCovariance> looks = CovariancesOfLooks(problem, state, inverse, point);
  const LookCovariance& at = *std::find_if(
      looks.begin(), looks.end(), [look](const LookCovariance& of) { return of.look == look; });
  PointResiduals out;
  out.looks = {look};
  out.looks_of_point = static_cast<std::size_t>(problem.CountLooks(point));
  out.v_1 = at.error_1;
  out.q_vv_1 = Eigen::Matrix2d::Identity() - at.adjusted_1;
  out.information_1 = at.information_1;
  const Eigen::Matrix2d own_1 = at.information_1 * at.information_1.transpose();
  out.shared_1 = (at.adjusted_1 - own_1).diagonal();
  out.shift_m = at.shift_m;
  return out;
}

PointResiduals InformationOfPoint(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  std::size_t point) {
  PointFactor factor;
  FactorPoint(problem, state, {}, 0.0, point, &factor);
  PointResiduals out;
  for (int k = 0; k < factor.look_count; ++k) {
    out.looks.push_back(factor.looks[static_cast<std::size_t>(k)].look);
  }
  out.looks_of_point = out.looks.size();
  out.control_rows = factor.row_count - 2 * factor.look_count;
  out.v_1 = Eigen::Map<const Eigen::VectorXd>(factor.e.data(), factor.row_count);
  out.information_1 = Eigen::Map<const Eigen::MatrixX3d>(factor.q.data(), factor.row_count, 3);
  return out;
}

}  // namespace sarblock
