// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/elimination.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
namespace {

/// Distinct blocks of a point's looks and where their columns start.
void CollectBlocks(const AdjustmentProblem& problem, std::size_t point, PointRows* rows) {
  const Looks& looks = problem.block.looks;
  rows->slot_of_block.resize(problem.layout.blocks.size(), -1);
  rows->blocks.clear();
  LookColumns columns;
  for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    problem.model.ColumnsOf(i, &columns);
    for (int b = 0; b < columns.block_count; ++b) {
      const int block = columns.block[static_cast<std::size_t>(b)];
      int& slot = rows->slot_of_block[static_cast<std::size_t>(block)];
      if (slot < 0) {
        slot = 0;
        rows->blocks.push_back(block);
      }
    }
  }
  std::sort(rows->blocks.begin(), rows->blocks.end());
  rows->block_column.clear();
  rows->column_count = 0;
  for (const int block : rows->blocks) {
    rows->slot_of_block[static_cast<std::size_t>(block)] = rows->column_count;
    rows->block_column.push_back(rows->column_count);
    rows->column_count += problem.layout.blocks[static_cast<std::size_t>(block)].size;
  }
}

void AddLook(const WhitenedLook& look, const ParameterLayout& layout, PointRows* rows) {
  rows->cost_1 += look.cost_1;
  const int r = rows->row_count;
  rows->row_count += 2;
  rows->a.block<2, 3>(r, 0) = look.by_point;
  std::size_t local = 0;
  for (int b = 0; b < look.columns.block_count; ++b) {
    const auto block = static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)]);
    const int first = 3 + rows->slot_of_block[block];
    for (int c = 0; c < layout.blocks[block].size; ++c, ++local) {
      rows->a(r, first + c) = look.range_row[local];
      rows->a(r + 1, first + c) = look.doppler_row[local];
    }
  }
  rows->a.block<2, 1>(r, 3 + rows->column_count) = look.error_1;
}

}  // namespace

bool EvaluateWhitened(const AdjustmentProblem& problem,
                      const BlockState& state,
                      const Weighting& weighting,
                      std::size_t point,
                      std::size_t look,
                      WhitenedLook* out) {
  problem.model.ColumnsOf(look, &out->columns);
  const auto columns = static_cast<std::size_t>(out->columns.column_count);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  GatherColumns(problem.layout, out->columns, state.corrections, local.data());
  LookEvaluation at;
  if (!problem.model.Evaluate(look,
                              out->columns,
                              state.start_m[point],
                              state.displacement_m[point],
                              std::span<const double>(local).first(columns),
                              &at)) {
    return false;
  }
  Whitening w = problem.whitening[look];
  out->error_1 = w.Apply(at.error_m[0], at.error_m[1]);
  const double square = out->error_1.squaredNorm();
  out->cost_1 = 0.5 * square;
  out->radial_1 = 1.0;
  if (weighting.loss != RobustLoss::kNone) {
    const RobustValue robust = EvaluateLoss(weighting.loss, weighting.scale, square);
    const double root = std::sqrt(robust.weight_1);
    w = {root * w.w00, root * w.w10, root * w.w11};
    out->error_1 *= root;
    out->cost_1 = 0.5 * robust.loss_1;
    out->radial_1 = robust.radial_1;
  }
  out->by_point.row(0) = w.w00 * at.by_point.row(0);
  out->by_point.row(1) = w.w10 * at.by_point.row(0) + w.w11 * at.by_point.row(1);
  for (std::size_t c = 0; c < columns; ++c) {
    const double range = at.by_columns(0, static_cast<Eigen::Index>(c));
    const double doppler = at.by_columns(1, static_cast<Eigen::Index>(c));
    out->range_row[c] = w.w00 * range;
    out->doppler_row[c] = w.w10 * range + w.w11 * doppler;
  }
  return true;
}

void LinearisePoint(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const Weighting& weighting,
                    std::size_t point,
                    PointRows* rows) {
  CollectBlocks(problem, point, rows);
  const Looks& looks = problem.block.looks;
  const Eigen::Index columns = 3 + rows->column_count + 1;
  const std::uint64_t begin = looks.offsets[point], end = looks.offsets[point + 1];
  const Eigen::Index most = 2 * static_cast<Eigen::Index>(end - begin) + 3;
  if (rows->a.rows() < most || rows->a.cols() < columns) {
    rows->a.resize(std::max(most, rows->a.rows()), std::max(columns, rows->a.cols()));
  }
  rows->a.topLeftCorner(most, columns).setZero();
  rows->row_count = 0;
  rows->cost_1 = 0.0;
  rows->looks_not_evaluated = 0;
  WhitenedLook look;
  for (std::uint64_t i = begin; i < end; ++i) {
    if (problem.look_used[i] == 0) continue;
    if (EvaluateWhitened(problem, state, weighting, point, i, &look)) {
      AddLook(look, problem.layout, rows);
    } else {
      ++rows->looks_not_evaluated;
    }
  }
  if (problem.control_of[point] >= 0) {
    const ControlEquations& control =
        problem.control[static_cast<std::size_t>(problem.control_of[point])];
    const ControlEvaluation at = EvaluateControl(
        problem.block.frame, control, state.start_m[point], state.displacement_m[point]);
    for (int i = 0; i < control.rows; ++i) {
      rows->a.row(rows->row_count).head<3>() = at.by_point.row(i);
      rows->a(rows->row_count, 3 + rows->column_count) = at.residual[i];
      rows->cost_1 += 0.5 * at.residual[i] * at.residual[i];
      ++rows->row_count;
    }
  }
  for (const int block : rows->blocks) rows->slot_of_block[static_cast<std::size_t>(block)] = -1;
}

EliminatedPoint EliminatePoint(PointRows* rows) {
  const Eigen::Index m = rows->row_count, n = 3 + rows->column_count + 1;
  EliminatedPoint out;
  Eigen::MatrixXd& a = rows->a;
  Eigen::Vector3d scale;
  for (Eigen::Index k = 0; k < 3; ++k) scale[k] = a.col(k).head(m).norm();
  for (Eigen::Index k = 0; k < 3 && k < m; ++k) {
    const double below = a.col(k).segment(k + 1, m - k - 1).squaredNorm();
    const double alpha = a(k, k);
    const double norm = std::sqrt(alpha * alpha + below);
    if (!(norm > 0.0)) continue;
    const double beta = alpha > 0.0 ? -norm : norm;
    const double v0 = alpha - beta;
    const double tau = -v0 / beta;  // H = I - tau v v', v = (1, a_below / v0)
    auto v = a.col(k).segment(k + 1, m - k - 1);
    v /= v0;
    for (Eigen::Index c = k + 1; c < n; ++c) {
      auto x = a.col(c).segment(k + 1, m - k - 1);
      const double dot = tau * (a(k, c) + v.dot(x));
      a(k, c) -= dot;
      x -= dot * v;
    }
    a(k, k) = beta;
    v.setZero();
  }
  out.r = a.topLeftCorner<3, 3>().triangularView<Eigen::Upper>();
  if (m >= 3 && scale.minCoeff() > 0.0) {
    const Eigen::Matrix3d scaled = out.r * scale.cwiseInverse().asDiagonal();
    if (scaled.diagonal().cwiseAbs().minCoeff() > 0.0) {
      const Eigen::Matrix3d inverse =
          scaled.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
      out.reciprocal_condition_1 = 1.0 / (scaled.norm() * inverse.norm());
    }
  }
  return out;
}

}  // namespace sarblock
