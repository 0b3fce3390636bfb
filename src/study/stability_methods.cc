// SPDX-License-Identifier: Apache-2.0
#include "stability_methods.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "normals/point.h"
#include "quality/point_sweep.h"

namespace sarblock {
namespace {

/// The whole whitened Jacobian, row by row: three columns a solved point, then the corrections.
struct Jacobian {
  std::size_t columns = 0;
  std::vector<double> values;

  double* AddRow() {
    values.resize(values.size() + columns, 0.0);
    return values.data() + values.size() - columns;
  }
};

void AddLooks(const AdjustmentProblem& problem,
              const BlockState& state,
              std::size_t point,
              std::size_t first_of_point,
              std::size_t first_of_corrections,
              Jacobian* j) {
  WhitenedLook look;
  const auto& offsets = problem.block.looks.offsets;
  for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    if (!EvaluateWhitened(problem, state, {}, point, i, &look)) continue;
    for (std::size_t r = 0; r < 2; ++r) {
      double* row = j->AddRow();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        row[first_of_point + axis] =
            look.by_point(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(axis));
      }
      std::size_t local = 0;
      for (int b = 0; b < look.columns.block_count; ++b) {
        const ParameterBlock& block =
            problem.layout
                .blocks[static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)])];
        for (int c = 0; c < block.size; ++c) {
          row[first_of_corrections + static_cast<std::size_t>(block.offset + c)] +=
              look.row[r][local++];
        }
      }
    }
  }
}

Jacobian JacobianOf(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const std::vector<std::size_t>& solved) {
  Jacobian j;
  const std::size_t first = 3 * solved.size();
  j.columns = first + problem.layout.parameters.size();
  for (std::size_t k = 0; k < solved.size(); ++k) {
    const std::size_t point = solved[k];
    AddLooks(problem, state, point, 3 * k, first, &j);
    if (problem.control_of[point] < 0) continue;
    const ControlEquations& equations =
        problem.control[static_cast<std::size_t>(problem.control_of[point])];
    const ControlEvaluation control = EvaluateControl(
        problem.block.frame, equations, state.start_m[point], state.displacement_m[point]);
    for (int r = 0; r < equations.rows; ++r) {
      double* row = j.AddRow();
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        row[3 * k + static_cast<std::size_t>(axis)] = control.by_point(r, axis);
      }
    }
  }
  for (std::size_t b = 0; b < problem.layout.blocks.size(); ++b) {
    for (const PriorRow& prior : PriorRowsOf(problem.layout, static_cast<int>(b))) {
      double* row = j.AddRow();
      for (const PriorRow::Term& term : prior.terms) {
        row[first + static_cast<std::size_t>(term.parameter)] = term.weight;
      }
    }
  }
  return j;
}

/// Inverse of the normal matrix of columns of unit length, by L with L L' = N and X = L^-1;
/// empty without a factor. Lower triangle, row by row of `size`.
template <typename T>
std::vector<T> InverseNormals(const Jacobian& j, const std::vector<double>& length) {
  const std::size_t n = j.columns;
  std::vector<T> l(n * n, T(0)), row(n);
  for (std::size_t at = 0; at < j.values.size(); at += n) {
    for (std::size_t c = 0; c < n; ++c) row[c] = static_cast<T>(j.values[at + c] / length[c]);
    for (std::size_t a = 0; a < n; ++a) {
      if (row[a] == T(0)) continue;
      for (std::size_t b = 0; b <= a; ++b) l[a * n + b] += row[a] * row[b];
    }
  }
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      T sum = l[a * n + b];
      for (std::size_t k = 0; k < b; ++k) sum -= l[a * n + k] * l[b * n + k];
      if (a == b && !(sum > T(0))) return {};
      l[a * n + b] = a == b ? std::sqrt(sum) : sum / l[b * n + b];
    }
  }
  std::vector<T> x(n * n, T(0)), inverse(n * n, T(0));
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      T sum = a == b ? T(1) : T(0);
      for (std::size_t k = b; k < a; ++k) sum -= l[a * n + k] * x[k * n + b];
      x[a * n + b] = sum / l[a * n + a];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t a = 0; a <= k; ++a) {
      for (std::size_t b = 0; b <= a; ++b) inverse[a * n + b] += x[k * n + a] * x[k * n + b];
    }
  }
  return inverse;
}

template <typename T>
std::vector<SymmetricEnu> Covariances(const AdjustmentProblem& problem,
                                      const BlockState& state,
                                      const std::vector<std::size_t>& solved) {
  const Jacobian j = JacobianOf(problem, state, solved);
  // Columns of unit length first: no digit goes to units, in single precision nothing overflows.
  std::vector<double> length(j.columns, 0.0);
  for (std::size_t i = 0; i < j.values.size(); ++i) {
    length[i % j.columns] += j.values[i] * j.values[i];
  }
  for (double& value : length) value = std::sqrt(value);
  const std::vector<T> inverse = InverseNormals<T>(j, length);
  if (inverse.empty()) return {};
  SymmetricEnu none;
  none.fill(std::numeric_limits<double>::quiet_NaN());
  std::vector<SymmetricEnu> out(problem.block.points.size(), none);
  for (std::size_t k = 0; k < solved.size(); ++k) {
    Eigen::Matrix3d c;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        const std::size_t row = 3 * k + a, column = 3 * k + b;
        const double value =
            static_cast<double>(inverse[row * j.columns + column]) / (length[row] * length[column]);
        c(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = value;
        c(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) = value;
      }
    }
    out[solved[k]] = ToEnu(problem.block.frame, state.Position(solved[k]), c);
  }
  return out;
}

}  // namespace

std::vector<SymmetricEnu> CovariancesByNormals(const AdjustmentProblem& problem,
                                               const BlockState& state,
                                               Precision precision) {
  std::vector<std::size_t> solved;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) solved.push_back(point);
  }
  return precision == Precision::kSingle ? Covariances<float>(problem, state, solved)
                                         : Covariances<double>(problem, state, solved);
}

double CovarianceError(const std::vector<SymmetricEnu>& computed,
                       const std::vector<SymmetricEnu>& exact) {
  double worst = 0.0;
  for (std::size_t point = 0; point < exact.size(); ++point) {
    if (std::isnan(exact[point][0])) continue;
    if (computed.size() != exact.size()) return std::numeric_limits<double>::infinity();
    double square = 0.0, off = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      const double count = k < 3 ? 1.0 : 2.0;
      const double difference = computed[point][k] - exact[point][k];
      square += count * exact[point][k] * exact[point][k];
      off += count * difference * difference;
    }
    const double error = std::sqrt(off / square);
    if (std::isnan(error)) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, error);
  }
  return worst;
}

}  // namespace sarblock
