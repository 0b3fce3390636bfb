// SPDX-License-Identifier: Apache-2.0
#include "point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "linear/dense.h"
#include "model/problem.h"

namespace sarblock {
namespace {

/// out (`terms` rows over the columns) += B' J, two rows J over the columns of one look, B `terms`
/// columns `stride` apart.
void AddTurnedLook(const ParameterLayout& layout,
                   const LookColumns& look,
                   const std::array<std::array<double, ParameterLayout::kMaxLocalColumns>, 2>& rows,
                   const PointColumns& columns,
                   const double* b,
                   std::size_t stride,
                   int terms,
                   double* out) {
  const double* first = rows[0].data();
  const double* second = rows[1].data();
  for (int q = 0; q < look.block_count; ++q) {
    const auto id = static_cast<std::size_t>(look.block[static_cast<std::size_t>(q)]);
    const int size = layout.blocks[id].size;
    Kernels().AddTurned(out + columns.column_of_block[id],
                        static_cast<std::size_t>(columns.width),
                        terms,
                        b,
                        stride,
                        first,
                        second,
                        size);
    first += size;
    second += size;
  }
}

/// Makes column k of unit length; returns the length it had.
double Normalise(std::size_t m, double* column) {
  const double length = std::sqrt(Dot(m, column, column));
  const double inverse = length > 0.0 ? 1.0 / length : 0.0;
  for (std::size_t i = 0; i < m; ++i) column[i] *= inverse;
  return length;
}

/// Classical Gram-Schmidt, each column twice: orthogonal to rounding, no heap, no pivoting.
void FactorColumns(std::size_t m, double* q, Eigen::Matrix3d* r) {
  double* q0 = q;
  double* q1 = q + m;
  double* q2 = q + 2 * m;
  r->setZero();
  (*r)(0, 0) = Normalise(m, q0);
  for (int pass = 0; pass < 2; ++pass) {
    const double d0 = Dot(m, q0, q1);
    for (std::size_t i = 0; i < m; ++i) q1[i] -= d0 * q0[i];
    (*r)(0, 1) += d0;
  }
  (*r)(1, 1) = Normalise(m, q1);
  for (int pass = 0; pass < 2; ++pass) {
    const double d0 = Dot(m, q0, q2), d1 = Dot(m, q1, q2);
    for (std::size_t i = 0; i < m; ++i) q2[i] -= d0 * q0[i] + d1 * q1[i];
    (*r)(0, 2) += d0;
    (*r)(1, 2) += d1;
  }
  (*r)(2, 2) = Normalise(m, q2);
}

/// Where less than this part of a column's length, squared, is left by the columns before it, J'J
/// has lost digits that J itself still has: two of sixteen, or four for a step on the way, where
/// the next step mends them.
constexpr double kMinPivot = 1e-2;
constexpr double kMinDampedPivot = 1e-4;

/// Two rows of J, side by side, by its columns.
using RowPair = std::array<Eigen::Array2d, 3>;

struct NoScaling {
  void operator()(RowPair*) const {}
};

/// Times R^-1.
struct ByFactor {
  const Eigen::Matrix3d& r;
  const Eigen::Vector3d& inverse;  // of its diagonal
  void operator()(RowPair* rows) const {
    RowPair& q = *rows;
    q[0] *= inverse[0];
    q[1] = (q[1] - r(0, 1) * q[0]) * inverse[1];
    q[2] = (q[2] - r(0, 2) * q[0] - r(1, 2) * q[1]) * inverse[2];
  }
};

/// All rows of J under `turn` into out->q, and out->e: looks, control, damping.
template <typename Turn>
void FillRows(const ControlEvaluation& control,
              int control_rows,
              double damping,
              const Turn& turn,
              PointFactor* out) {
  const std::ptrdiff_t m = out->row_count;
  double* q = out->q.data();
  double* e = out->e.data();
  RowPair rows;
  for (int k = 0; k < out->look_count; ++k, q += 2, e += 2) {
    const WhitenedLook& look = out->looks[static_cast<std::size_t>(k)];
    for (std::size_t c = 0; c < 3; ++c) {
      rows[c] = look.d_point.col(static_cast<Eigen::Index>(c)).array();
    }
    turn(&rows);
    for (std::ptrdiff_t c = 0; c < 3; ++c) {
      Eigen::Map<Eigen::Array2d>(q + c * m) = rows[static_cast<std::size_t>(c)];
    }
    Eigen::Map<Eigen::Vector2d>{e} = look.whitened_error;
  }
  const auto put = [&](const Eigen::Vector3d& row, double whitened_error) {
    for (std::size_t c = 0; c < 3; ++c) rows[c] = row[static_cast<Eigen::Index>(c)];
    turn(&rows);
    for (std::ptrdiff_t c = 0; c < 3; ++c) q[c * m] = rows[static_cast<std::size_t>(c)][0];
    *e++ = whitened_error;
    ++q;
  };
  for (int k = 0; k < control_rows; ++k) put(control.d_point.row(k), control.residual[k]);
  for (Eigen::Index c = 0; damping > 0.0 && c < 3; ++c) {
    put(std::sqrt(damping * out->square[c]) * Eigen::Vector3d::Unit(c), 0.0);
  }
}

double ReciprocalCondition(const Eigen::Matrix3d& r, const Eigen::Vector3d& square) {
  if (!(square.minCoeff() > 0.0) || !(r.diagonal().cwiseAbs().minCoeff() > 0.0)) return 0.0;
  // Norms of R D^-1 and D R^-1, D the lengths of the columns.
  const Eigen::Matrix3d inverse = InverseOfUpper(r);
  double backward = 0.0;
  for (Eigen::Index c = 0; c < 3; ++c) {
    for (Eigen::Index k = 0; k <= c; ++k) backward += inverse(k, c) * inverse(k, c) * square[k];
  }
  return 1.0 / std::sqrt(3.0 * backward);  // columns of R D^-1 have unit length
}

}  // namespace

void EvaluateLooks(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Weighting& weighting,
                   std::size_t point,
                   PointFactor* out) {
  const Looks& looks = problem.block.looks;
  const std::size_t begin = looks.offsets[point], end = looks.offsets[point + 1];
  if (point + 2 < looks.offsets.size()) {  // the point that most likely comes next
    for (std::size_t i = end; i < looks.offsets[point + 2]; ++i) problem.model.Prefetch(i);
  }
  if (out->looks.size() < end - begin) out->looks.resize(end - begin);
  if (weighting.curved && out->curved.size() < CurvedRows::kMaxPerLook * out->looks.size()) {
    out->curved.resize(CurvedRows::kMaxPerLook * out->looks.size());
  }
  out->look_count = out->curved_count = 0;
  out->looks_not_evaluated = out->looks_beyond_path = 0;
  out->cost = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    if (problem.look_used[i] == 0) continue;
    WhitenedLook& look = out->looks[static_cast<std::size_t>(out->look_count)];
    CurvedRows* const curved =
        weighting.curved ? &out->curved[static_cast<std::size_t>(out->curved_count)] : nullptr;
    if (!EvaluateWhitened(problem, state, weighting, point, i, &look, curved)) {
      ++out->looks_not_evaluated;
      continue;
    }
    if (curved != nullptr) out->curved_count += look.curved_count;
    if (look.beyond_path) ++out->looks_beyond_path;
    out->cost += look.cost;
    out->weight_change = std::max(out->weight_change, look.weight_change);
    if (weighting.second_order) BendAlongResidual(&look);
    ++out->look_count;
  }
}

void BendAlongResidual(WhitenedLook* look) {
  const double square = look->whitened_error.squaredNorm();
  if (look->radial == 1.0 || !(square > 0.0)) return;
  const double root = std::sqrt(look->radial);
  const double take = (1.0 - root) / square;
  const double e0 = look->whitened_error[0], e1 = look->whitened_error[1];
  const auto bend = [&](double& range, double& doppler) {
    const double along = take * (e0 * range + e1 * doppler);
    range -= along * e0;
    doppler -= along * e1;
  };
  for (Eigen::Index c = 0; c < 3; ++c) bend(look->d_point(0, c), look->d_point(1, c));
  for (std::size_t c = 0; c < static_cast<std::size_t>(look->columns.column_count); ++c) {
    bend(look->row[0][c], look->row[1][c]);
  }
  look->whitened_error /= root;
}

bool FactorNormal(const Eigen::Vector3d& diagonal,
                  const Eigen::Vector3d& above,
                  bool damped,
                  Eigen::Matrix3d* r,
                  Eigen::Vector3d* inverse) {
  const double least_pivot = damped ? kMinDampedPivot : kMinPivot;
  if (!(diagonal.minCoeff() > 0.0)) return false;
  // First L D L', then the three roots side by side, so that none waits for the one before.
  const double inverse_0 = 1.0 / diagonal[0];
  const double l01 = above[0] * inverse_0, l02 = above[1] * inverse_0;
  const double left_11 = diagonal[1] - above[0] * l01;
  if (!(left_11 > least_pivot * diagonal[1])) return false;
  const double left_12 = above[2] - above[0] * l02;
  const double l12 = left_12 / left_11;
  const double left_2 = diagonal[2] - above[1] * l02 - left_12 * l12;
  if (!(left_2 > least_pivot * diagonal[2])) return false;
  const double r00 = std::sqrt(diagonal[0]), r11 = std::sqrt(left_11), r22 = std::sqrt(left_2);
  *r << r00, l01 * r00, l02 * r00, 0.0, r11, l12 * r11, 0.0, 0.0, r22;
  *inverse = {1.0 / r00, 1.0 / r11, 1.0 / r22};
  return true;
}

bool FactorSquare(const Eigen::Vector3d& diagonal,
                  const Eigen::Vector3d& above,
                  bool damped,
                  PointFactor* factor,
                  Eigen::Matrix3d* r,
                  Eigen::Vector3d* inverse) {
  if (factor->curved_count > 0) {
    PointSums curved;
    for (int k = 0; k < factor->curved_count; ++k) {
      curved.Add(factor->curved[static_cast<std::size_t>(k)]);
    }
    if (FactorNormal(diagonal + curved.Diagonal(), above + curved.Above(), damped, r, inverse)) {
      return true;
    }
    factor->curved_count = 0;
  }
  return FactorNormal(diagonal, above, damped, r, inverse);
}

namespace {

/// Cost of a look that is evaluated and weighted, and its weight under a loss; returns the root of
/// that weight.
double ApplyLoss(const Weighting& weighting, WhitenedLook* out) {
  const double square = out->whitened_error.squaredNorm();
  out->cost = 0.5 * square;
  out->radial = 1.0;
  if (weighting.loss == RobustLoss::kNone) return 1.0;
  const RobustValue robust = EvaluateLoss(weighting.loss, weighting.scale, square);
  const double root = std::sqrt(robust.weight);
  out->whitened_error *= root;
  out->d_point *= root;
  for (auto& row : out->row) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(out->columns.column_count); ++c) {
      row[c] *= root;
    }
  }
  out->cost = 0.5 * robust.loss;
  out->radial = robust.radial;
  return root;
}

/// The rows of a look from its curvature, its errors and the weights of both; how many pairs.
int SetCurvedRows(const LookCurvature& curvature,
                  const Eigen::Vector2d& weighted_error,
                  const LookColumns& columns,
                  CurvedRows* out) {
  constexpr int kSize = LookCurvature::kSize;
  static_assert(2 * CurvedRows::kMaxPerLook == kSize + 1);
  LookCurvature::Matrix m =
      weighted_error[0] * curvature.range + weighted_error[1] * curvature.azimuth;
  Eigen::Matrix<double, kSize, kSize + 1> axes;
  std::array<double, kSize + 1> sign{};
  const int count = dense::SignedSquares(kSize, m.data(), axes.data(), sign.data());
  // A last row of zeros makes them pairs.
  axes.col(count).setZero();
  sign[static_cast<std::size_t>(count)] = 1.0;
  const int pairs = (count + 1) / 2;
  for (int k = 0; k < 2 * pairs; ++k) {
    CurvedRows& rows = out[k / 2];
    rows.columns = &columns;
    rows.sign[k % 2] = sign[static_cast<std::size_t>(k)];
    rows.d_point.row(k % 2) = axes.col(k).head<3>().transpose();
    auto& row = rows.row[static_cast<std::size_t>(k % 2)];
    for (std::size_t c = 0; c < static_cast<std::size_t>(columns.column_count); ++c) {
      double sum = 0.0;
      for (Eigen::Index i = 0; i < kSize; ++i) {
        sum += axes(i, k) * curvature.row[static_cast<std::size_t>(i)][c];
      }
      row[c] = sum;
    }
  }
  return pairs;
}

}  // namespace

bool EvaluateWhitened(const AdjustmentProblem& problem,
                      const BlockState& state,
                      const Weighting& weighting,
                      std::size_t point,
                      std::size_t look,
                      WhitenedLook* out,
                      CurvedRows* curved) {
  out->look = look;
  out->weight_change = 0.0;
  const bool renew = weighting.renewed != nullptr;
  LookWeights weights = renew ? LookWeights{} : problem.weights[look];
  LookCurvature curvature;
  if (!EvaluateLook(problem.model,
                    state,
                    point,
                    look,
                    weights,
                    &out->columns,
                    out,
                    curved != nullptr ? &curvature : nullptr)) {
    return false;
  }
  if (renew) {
    weights = WeightsAt(problem.model.SigmaOf(look), out->azimuth_unit_m);
    LookWeights& kept = (*weighting.renewed)[look];
    out->weight_change = std::abs(weights.azimuth_per_unit / kept.azimuth_per_unit - 1.0);
    kept = weights;
    out->Scale(weights, out->columns.column_count);
  }
  const double root = ApplyLoss(weighting, out);
  if (curved != nullptr) {
    const Eigen::Vector2d weighted_error(root * weights.range_per_m * out->whitened_error[0],
                                         root * weights.azimuth_per_unit * out->whitened_error[1]);
    out->curved_count = SetCurvedRows(curvature, weighted_error, out->columns, curved);
  }
  return true;
}

void FactorPoint(const AdjustmentProblem& problem,
                 const BlockState& state,
                 const Weighting& weighting,
                 double damping,
                 std::size_t point,
                 PointFactor* out) {
  EvaluateLooks(problem, state, weighting, point, out);
  ControlEvaluation control;
  int control_rows = 0;
  if (problem.control_of[point] >= 0) {
    const ControlEquations& equations =
        problem.control[static_cast<std::size_t>(problem.control_of[point])];
    control_rows = equations.rows;
    control = EvaluateControl(
        problem.block.frame, equations, state.start_m[point], state.displacement_m[point]);
  }
  const int m = 2 * out->look_count + control_rows + (damping > 0.0 ? 3 : 0);
  out->row_count = m;
  out->q.resize(static_cast<std::size_t>(3 * m));
  out->e.resize(static_cast<std::size_t>(m));
  PointSums sums;
  for (int k = 0; k < out->look_count; ++k) {
    const WhitenedLook& look = out->looks[static_cast<std::size_t>(k)];
    sums.Add(look.d_point, look.whitened_error);
  }
  if (control_rows > 0) {
    sums.Add(control);
    out->cost += 0.5 * control.residual.squaredNorm();
  }
  out->square = sums.Diagonal();
  out->gradient = sums.Gradient();
  if (damping > 0.0) {
    out->square = out->square.cwiseMax(kMinColumnPart * out->square.maxCoeff());
  }
  // By the Cholesky factor of J'J, where that holds the digits, a third of the work of
  // FactorColumns: Q = J R^-1.
  Eigen::Vector3d inverse;
  if (FactorSquare(
          (1.0 + damping) * out->square, sums.Above(), damping > 0.0, out, &out->r, &inverse)) {
    FillRows(control, control_rows, damping, ByFactor{out->r, inverse}, out);
  } else {
    FillRows(control, control_rows, damping, NoScaling{}, out);
    FactorColumns(static_cast<std::size_t>(m), out->q.data(), &out->r);
  }
  for (int k = 0; k < out->curved_count; ++k) {
    CurvedRows& rows = out->curved[static_cast<std::size_t>(k)];
    rows.turned = out->r.triangularView<Eigen::Upper>().transpose().solve(rows.d_point.transpose() *
                                                                          rows.sign.asDiagonal());
  }
  out->reciprocal_condition =
      m < 3 || damping > 0.0 ? 0.0 : ReciprocalCondition(out->r, out->square);
}

bool SettlePoint(const AdjustmentProblem& problem,
                 const Weighting& weighting,
                 double damping,
                 double settle_below,
                 std::size_t point,
                 BlockState* state,
                 PointFactor* out) {
  constexpr int kMaxSteps = 8, kMaxShortened = 3;
  Eigen::Vector3d& at_m = state->displacement_m[point];
  bool moved = false;
  for (int step = 0; step < kMaxSteps && out->looks_not_evaluated == 0; ++step) {
    if (damping == 0.0 && !(out->reciprocal_condition >= kMinPointCondition)) break;
    const Eigen::Vector3d c = Project(*out, out->e);
    if (!(c.squaredNorm() > settle_below * settle_below)) break;
    const Eigen::Vector3d before_m = at_m;
    const double cost = out->cost;
    Eigen::Vector3d step_m = -out->r.triangularView<Eigen::Upper>().solve(c);
    bool lower = false;
    for (int k = 0; k < kMaxShortened && !lower && step_m.allFinite(); ++k, step_m *= 0.25) {
      at_m = before_m + step_m;
      FactorPoint(problem, *state, weighting, damping, point, out);
      lower = out->looks_not_evaluated == 0 && out->cost < cost;
    }
    if (!lower) {
      at_m = before_m;
      FactorPoint(problem, *state, weighting, damping, point, out);
      break;
    }
    moved = true;
  }
  return moved;
}

Eigen::Vector3d Project(const PointFactor& factor, const std::vector<double>& rows) {
  const auto m = static_cast<std::size_t>(factor.row_count);
  const double* q = factor.q.data();
  return {Dot(m, q, rows.data()), Dot(m, q + m, rows.data()), Dot(m, q + 2 * m, rows.data())};
}

void ProjectColumns(const AdjustmentProblem& problem,
                    const PointFactor& factor,
                    PointColumns* columns) {
  FindColumns(problem.layout, factor, columns);
  columns->t.assign(3 * static_cast<std::size_t>(columns->width), 0.0);
  AddTurnedColumns(problem.layout, factor, *columns, factor.q.data(), 3, columns->t.data());
  for (int k = 0; k < factor.curved_count; ++k) {
    const CurvedRows& rows = factor.curved[static_cast<std::size_t>(k)];
    const Eigen::Matrix<double, 2, 3> basis = rows.turned.transpose();
    AddTurnedLook(
        problem.layout, *rows.columns, rows.row, *columns, basis.data(), 2, 3, columns->t.data());
  }
}

void Complement(const AdjustmentProblem& problem,
                const PointFactor& factor,
                PointColumns* columns) {
  const auto rows = static_cast<std::size_t>(factor.row_count);
  const auto stride = static_cast<std::size_t>(columns->width) + 1;
  columns->m.assign(rows * stride, 0.0);
  double* m = columns->m.data();
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    const double* range = look.row[0].data();
    const double* doppler = look.row[1].data();
    double* row = m + 2 * static_cast<std::size_t>(k) * stride;
    for (int b = 0; b < look.columns.block_count; ++b) {
      const auto id = static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)]);
      const auto size = static_cast<std::size_t>(problem.layout.blocks[id].size);
      double* at = row + columns->column_of_block[id];
      std::copy_n(range, size, at);
      std::copy_n(doppler, size, at + stride);
      range += size;
      doppler += size;
    }
  }
  for (std::size_t i = 0; i < rows; ++i) m[i * stride + stride - 1] = factor.e[i];
  std::vector<double>& t = columns->scratch;
  for (int pass = 0; pass < 2; ++pass) {
    t.assign(3 * stride, 0.0);
    for (std::size_t i = 0; i < rows; ++i) {
      const double* row = m + i * stride;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double q = factor.q[axis * rows + i];
        double* sum = t.data() + axis * stride;
        for (std::size_t c = 0; c < stride; ++c) sum[c] += q * row[c];
      }
    }
    for (std::size_t i = 0; i < rows; ++i) {
      double* row = m + i * stride;
      const Eigen::Vector3d q = factor.RowOfQ(static_cast<int>(i));
      for (std::size_t c = 0; c < stride; ++c) {
        row[c] -= q[0] * t[c] + q[1] * t[stride + c] + q[2] * t[2 * stride + c];
      }
    }
  }
}

namespace {

/// Orthonormal columns that complete Q (m x 3, orthonormal) to a basis: the last m - 3 columns of
/// the product of the three Householder reflections that take Q to the axes. m x (m - 3).
void CompleteBasis(std::size_t m, const std::vector<double>& q, std::vector<double>* out) {
  const std::size_t count = m - 3;
  // The reflections' vectors; row k - 1 and those above are zero in vector k.
  std::array<double, 3> half_square;
  out->assign(m * count + 3 * m, 0.0);
  double* v = out->data() + m * count;
  std::copy_n(q.data(), 3 * m, v);
  for (std::size_t k = 0; k < 3; ++k) {
    double* vk = v + k * m;
    for (std::size_t j = 0; j < k; ++j) {
      const double* vj = v + j * m;
      const double part = Dot(m - j, vj + j, vk + j) / half_square[j];
      for (std::size_t i = j; i < m; ++i) vk[i] -= part * vj[i];
    }
    // What is left of the column below row k has length 1; its reflection goes to -sign(v_kk).
    std::fill_n(vk, k, 0.0);
    const double sign = vk[k] < 0.0 ? -1.0 : 1.0;
    half_square[k] = 1.0 + std::abs(vk[k]);
    vk[k] += sign;
  }
  for (std::size_t c = 0; c < count; ++c) {
    double* column = out->data() + c * m;
    column[3 + c] = 1.0;
    for (std::size_t k = 3; k-- > 0;) {
      const double* vk = v + k * m;
      const double part = Dot(m - k, vk + k, column + k) / half_square[k];
      for (std::size_t i = k; i < m; ++i) column[i] -= part * vk[i];
    }
  }
}

}  // namespace

void FindColumns(const ParameterLayout& layout, const PointFactor& factor, PointColumns* columns) {
  columns->blocks.clear();
  for (int k = 0; k < factor.look_count; ++k) {
    InsertBlocks(factor.looks[static_cast<std::size_t>(k)].columns, &columns->blocks);
  }
  PlaceColumns(layout, columns);
}

void PlaceColumns(const ParameterLayout& layout, PointColumns* columns) {
  if (columns->column_of_block.size() < layout.blocks.size()) {
    columns->column_of_block.resize(layout.blocks.size());
  }
  const std::vector<int>& blocks = columns->blocks;
  columns->begin.resize(blocks.size());
  columns->width = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto id = static_cast<std::size_t>(blocks[i]);
    columns->begin[i] = columns->width;
    columns->column_of_block[id] = columns->width;
    columns->width += layout.blocks[id].size;
  }
}

void AddTurnedColumns(const ParameterLayout& layout,
                      const PointFactor& factor,
                      const PointColumns& columns,
                      const double* b,
                      int terms,
                      double* out) {
  const auto m = static_cast<std::size_t>(factor.row_count);
  for (int k = 0; k < factor.look_count; ++k, b += 2) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    AddTurnedLook(layout, look.columns, look.row, columns, b, m, terms, out);
  }
}

PointBlocks FindSlots(const ParameterLayout& layout,
                      const BlockPattern& pattern,
                      PointTerms* terms) {
  const std::vector<int>& blocks = terms->columns.blocks;
  terms->size.resize(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    terms->size[i] = layout.blocks[static_cast<std::size_t>(blocks[i])].size;
  }
  terms->value.resize(blocks.size() * (blocks.size() + 1) / 2);
  pattern.SlotsOfPairs(blocks, terms->value.data());
  return {static_cast<int>(blocks.size()),
          terms->columns.begin.data(),
          terms->size.data(),
          terms->value.data()};
}

PointBlocks FindBlocks(const ParameterLayout& layout,
                       const BlockPattern& pattern,
                       PointTerms* terms) {
  const PointBlocks blocks = FindSlots(layout, pattern, terms);
  for (std::size_t& at : terms->value) at = pattern.ValueBegin(at);
  return blocks;
}

void ProjectToLeftNullSpace(const ParameterLayout& layout,
                            const PointFactor& factor,
                            PointTerms* terms) {
  const auto m = static_cast<std::size_t>(factor.row_count);
  const std::size_t rest = m - 3;
  CompleteBasis(m, factor.q, &terms->basis);
  const double* basis = terms->basis.data();
  terms->rest.assign(rest * static_cast<std::size_t>(terms->columns.width), 0.0);
  AddTurnedColumns(
      layout, factor, terms->columns, basis, static_cast<int>(rest), terms->rest.data());
  terms->rest_e.resize(rest);
  for (std::size_t k = 0; k < rest; ++k) {
    terms->rest_e[k] = Dot(m, basis + k * m, factor.e.data());
  }
}

}  // namespace sarblock
