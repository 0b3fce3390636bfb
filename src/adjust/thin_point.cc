// SPDX-License-Identifier: Apache-2.0
#include "thin_point.h"

#include <cmath>

namespace sarblock {
namespace {

/// Classical Gram-Schmidt, each column twice: orthogonal to rounding, no heap, no pivoting.
void FactorColumns(int m, double* q, Eigen::Matrix3d* r) {
  r->setZero();
  for (int k = 0; k < 3; ++k) {
    double* qk = q + k * m;
    for (int pass = 0; pass < 2; ++pass) {
      for (int j = 0; j < k; ++j) {
        const double* qj = q + j * m;
        double dot = 0.0;
        for (int i = 0; i < m; ++i) dot += qj[i] * qk[i];
        for (int i = 0; i < m; ++i) qk[i] -= dot * qj[i];
        (*r)(j, k) += dot;
      }
    }
    double square = 0.0;
    for (int i = 0; i < m; ++i) square += qk[i] * qk[i];
    const double length = std::sqrt(square);
    (*r)(k, k) = length;
    const double inverse = length > 0.0 ? 1.0 / length : 0.0;
    for (int i = 0; i < m; ++i) qk[i] *= inverse;
  }
}

/// Second-order weighting of a look under a robust loss (after Triggs et al. 2000, with a floor):
/// rows keep their weight across the residual and get the loss's own curvature along it; the errors
/// are rescaled so that the gradient stays what it is.
void BendAlongResidual(WhitenedLook* look) {
  const double square = look->error_1.squaredNorm();
  if (look->radial_1 == 1.0 || !(square > 0.0)) return;
  const double root = std::sqrt(look->radial_1);
  const double take = (1.0 - root) / square;
  const double e0 = look->error_1[0], e1 = look->error_1[1];
  const auto bend = [&](double& range, double& doppler) {
    const double along = take * (e0 * range + e1 * doppler);
    range -= along * e0;
    doppler -= along * e1;
  };
  for (Eigen::Index c = 0; c < 3; ++c) bend(look->by_point(0, c), look->by_point(1, c));
  for (std::size_t c = 0; c < static_cast<std::size_t>(look->columns.column_count); ++c) {
    bend(look->range_row[c], look->doppler_row[c]);
  }
  look->error_1 /= root;
}

}  // namespace

void FactorThin(const AdjustmentProblem& problem,
                const BlockState& state,
                const Weighting& weighting,
                double damping_1,
                std::size_t point,
                ThinPoint* out) {
  const Looks& looks = problem.block.looks;
  const std::size_t begin = looks.offsets[point], end = looks.offsets[point + 1];
  if (out->looks.size() < end - begin) out->looks.resize(end - begin);
  out->look_count = 0;
  out->looks_not_evaluated = 0;
  out->cost_1 = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    if (problem.look_used[i] == 0) continue;
    WhitenedLook& look = out->looks[static_cast<std::size_t>(out->look_count)];
    if (!EvaluateWhitened(problem, state, weighting, point, i, &look)) {
      ++out->looks_not_evaluated;
      continue;
    }
    out->cost_1 += look.cost_1;
    if (weighting.second_order) BendAlongResidual(&look);
    ++out->look_count;
  }
  ControlEvaluation control;
  int control_rows = 0;
  if (problem.control_of[point] >= 0) {
    const ControlEquations& equations =
        problem.control[static_cast<std::size_t>(problem.control_of[point])];
    control_rows = equations.rows;
    control = EvaluateControl(
        problem.block.frame, equations, state.start_m[point], state.displacement_m[point]);
  }
  const int m = 2 * out->look_count + control_rows + 3;
  out->row_count = m;
  out->q.assign(static_cast<std::size_t>(3 * m), 0.0);
  out->e.assign(static_cast<std::size_t>(m), 0.0);
  double* q = out->q.data();
  double* e = out->e.data();
  int row = 0;
  for (int k = 0; k < out->look_count; ++k, row += 2) {
    const WhitenedLook& look = out->looks[static_cast<std::size_t>(k)];
    for (int c = 0; c < 3; ++c) {
      q[c * m + row] = look.by_point(0, c);
      q[c * m + row + 1] = look.by_point(1, c);
    }
    e[row] = look.error_1[0];
    e[row + 1] = look.error_1[1];
  }
  for (int k = 0; k < control_rows; ++k, ++row) {
    for (int c = 0; c < 3; ++c) q[c * m + row] = control.by_point(k, c);
    e[row] = control.residual[k];
    out->cost_1 += 0.5 * control.residual[k] * control.residual[k];
  }
  for (int c = 0; c < 3; ++c) {
    double square = 0.0, gradient = 0.0;
    for (int i = 0; i < row; ++i) {
      square += q[c * m + i] * q[c * m + i];
      gradient += q[c * m + i] * e[i];
    }
    out->square[c] = square;
    out->gradient[c] = gradient;
  }
  const double least = kLeastColumnPart_1 * out->square.maxCoeff();
  for (int c = 0; c < 3; ++c) {
    out->square[c] = std::max(out->square[c], least);
    q[c * m + row + c] = std::sqrt(damping_1 * out->square[c]);
  }
  FactorColumns(m, q, &out->r);
}

Eigen::Vector3d Project(const ThinPoint& thin, const std::vector<double>& rows) {
  Eigen::Vector3d out;
  const int m = thin.row_count;
  for (int c = 0; c < 3; ++c) {
    double dot = 0.0;
    for (int i = 0; i < m; ++i) {
      dot += thin.q[static_cast<std::size_t>(c * m + i)] * rows[static_cast<std::size_t>(i)];
    }
    out[c] = dot;
  }
  return out;
}

}  // namespace sarblock
