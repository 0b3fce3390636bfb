// SPDX-License-Identifier: Apache-2.0
#include "point_sweep.h"

#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "core/threads.h"
#include "linear/dense.h"
#include "model/problem.h"
#include "normals/point.h"
#include "reliability.h"
#include <Eigen/LU>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 128;
/// Variance that corrections give to an equation of unit variance, above which the short form of
/// the look's leverage loses more digits than a float holds: then the complement is used (not for a
/// point of the border, where it would need all pairs of its passes).
constexpr double kLargeLeverage = 1e6;

/// Everything about one point at the solution; storage reused from point to point.
struct PointState {
  PointFactor factor;
  PointTerms terms;
  const double* t = nullptr;  // T, 3 x width, row by row
  std::vector<double> y;      // Y = T C, 3 x width, row by row
  int border_row = -1;        // CorrectionCovariance::t_c
  Eigen::Matrix3d r_inverse = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d core = Eigen::Matrix3d::Identity();  // I + T C T'
  bool complement_formed = false;
};

/// Y = T C of a point of the border.
void GatherBorder(const ParameterLayout& layout,
                  const CorrectionCovariance& inverse,
                  PointState* p) {
  const PointColumns& columns = p->terms.columns;
  for (std::size_t b = 0; b < columns.blocks.size(); ++b) {
    const ParameterBlock& block = layout.blocks[static_cast<std::size_t>(columns.blocks[b])];
    for (int i = 0; i < block.size; ++i) {
      const double* const of_column = inverse.t_c.At(p->border_row, block.offset + i);
      double* const y = p->y.data() + columns.begin[b] + i;
      for (int axis = 0; axis < 3; ++axis) y[axis * columns.width] = of_column[axis];
    }
  }
}

/// Y = T C and I + T C T' if `quality` asks for Y, else the second alone.
void MultiplyByInverse(const ParameterLayout& layout,
                       const CorrectionCovariance& inverse,
                       bool quality,
                       PointState* p) {
  const auto width = static_cast<std::size_t>(p->terms.columns.width);
  const double* values = inverse.blocks.values().data();
  const bool bordered = p->border_row >= 0;
  if (!quality && !bordered) {
    const PointBlocks blocks = FindBlocks(layout, *inverse.blocks.pattern(), &p->terms);
    Kernels().AddQuadraticForm(blocks, p->t, width, values, p->core.data());
    return;
  }
  p->y.assign(3 * width, 0.0);
  if (bordered) {
    GatherBorder(layout, inverse, p);
  } else {
    const PointBlocks blocks = FindBlocks(layout, *inverse.blocks.pattern(), &p->terms);
    Kernels().AddProductWithMatrix(blocks, p->t, width, values, p->y.data());
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = 0.0;
      for (std::size_t c = 0; c < width; ++c) {
        sum += p->t[a * width + c] * p->y[b * width + c];
      }
      p->core(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) += sum;
      if (a != b) p->core(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) += sum;
    }
  }
}

void FactorAt(const AdjustmentProblem& problem,
              const BlockState& state,
              const CorrectionCovariance* inverse,
              bool quality,
              const KeptFactors* kept,
              std::size_t point,
              PointState* p) {
  PointColumns& columns = p->terms.columns;
  p->t = kept != nullptr ? kept->Restore(problem, point, &p->factor.r, &columns) : nullptr;
  const bool restored = p->t != nullptr;
  if (restored && quality) kept->RestoreLooks(problem, point, &p->factor);
  if (!restored) FactorPoint(problem, state, {}, 0.0, point, &p->factor);
  p->r_inverse = InverseOfUpper(p->factor.r);
  p->core.setIdentity();
  p->complement_formed = false;
  if (inverse == nullptr) return;
  p->border_row = inverse->bordered.RowOf(point);
  if (!restored) {
    ProjectColumns(problem, p->factor, &columns);
    p->t = columns.t.data();
  }
  MultiplyByInverse(problem.layout, *inverse, quality, p);
}

/// J_c Y' and J_c C J_c' of one look over its own columns.
struct LookProducts {
  Eigen::Matrix<double, 2, 3> with_point = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Matrix2d own = Eigen::Matrix2d::Zero();
};

LookProducts ProductsOf(const AdjustmentProblem& problem,
                        const BlockSymmetricMatrix& inverse,
                        const PointState& p,
                        const WhitenedLook& look) {
  LookProducts out;
  const auto width = static_cast<std::size_t>(p.terms.columns.width);
  const double* j0 = look.row[0].data();
  const double* j1 = look.row[1].data();
  int first = 0;
  for (int b = 0; b < look.columns.block_count; ++b) {
    const int id = look.columns.block[static_cast<std::size_t>(b)];
    const int size = problem.layout.blocks[static_cast<std::size_t>(id)].size;
    const double* y = p.y.data() + p.terms.columns.column_of_block[static_cast<std::size_t>(id)];
    for (Eigen::Index axis = 0; axis < 3; ++axis, y += width) {
      for (int i = 0; i < size; ++i) {
        out.with_point(0, axis) += j0[first + i] * y[i];
        out.with_point(1, axis) += j1[first + i] * y[i];
      }
    }
    int other = 0;
    for (int b2 = 0; b2 < look.columns.block_count; ++b2) {
      const int id2 = look.columns.block[static_cast<std::size_t>(b2)];
      const int size2 = problem.layout.blocks[static_cast<std::size_t>(id2)].size;
      if (id2 <= id) {
        const auto block = inverse.Block(id, id2);
        const double* c = block.data();
        Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
        for (int col = 0; col < size2; ++col, c += size) {
          double dot0 = 0.0, dot1 = 0.0;
          for (int i = 0; i < size; ++i) {
            dot0 += j0[first + i] * c[i];
            dot1 += j1[first + i] * c[i];
          }
          sum(0, 0) += dot0 * j0[other + col];
          sum(0, 1) += dot0 * j1[other + col];
          sum(1, 0) += dot1 * j0[other + col];
          sum(1, 1) += dot1 * j1[other + col];
        }
        out.own += sum;
        if (id2 != id) out.own += sum.transpose();
      }
      other += size2;
    }
    first += size;
  }
  return out;
}

/// The same two products of the complement M, for paths so weakly determined that the short form
/// would subtract large numbers: M C M' and M Y'.
LookProducts ComplementProducts(const AdjustmentProblem& problem,
                                const BlockSymmetricMatrix& inverse,
                                int row,
                                PointState* p) {
  if (!p->complement_formed) {
    Complement(problem, p->factor, &p->terms.columns);
    p->complement_formed = true;
  }
  const PointColumns& columns = p->terms.columns;
  const auto width = static_cast<std::size_t>(columns.width);
  const Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>,
                   Eigen::Unaligned,
                   Eigen::OuterStride<>>
      m(columns.m.data() + static_cast<std::size_t>(row) * (width + 1),
        2,
        columns.width,
        Eigen::OuterStride<>(static_cast<Eigen::Index>(width) + 1));
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> y(
      p->y.data(), 3, columns.width);
  LookProducts out;
  out.with_point = m * y.transpose();
  for (std::size_t j = 0; j < columns.blocks.size(); ++j) {
    for (std::size_t i = j; i < columns.blocks.size(); ++i) {
      const auto block = inverse.Block(columns.blocks[i], columns.blocks[j]);
      const Eigen::Matrix2d sum = m.middleCols(columns.begin[i], block.rows()) * block *
                                  m.middleCols(columns.begin[j], block.cols()).transpose();
      out.own += sum;
      if (i != j) out.own += sum.transpose();
    }
  }
  return out;
}

/// The figures of the look k of a point.
LookCovariance CovarianceAt(const AdjustmentProblem& problem,
                            const CorrectionCovariance* inverse,
                            int k,
                            PointState* p) {
  const WhitenedLook& look = p->factor.looks[static_cast<std::size_t>(k)];
  Eigen::Matrix<double, 2, 3> q;
  q.row(0) = p->factor.RowOfQ(2 * k);
  q.row(1) = p->factor.RowOfQ(2 * k + 1);
  Eigen::Matrix2d adjusted = q * q.transpose();  // covariance of the adjusted look
  Eigen::Matrix<double, 2, 3> shift = q;         // by unit errors, times R'
  if (inverse != nullptr) {
    LookProducts products = ProductsOf(problem, inverse->blocks, *p, look);
    if (p->border_row >= 0 || products.own.diagonal().maxCoeff() <= kLargeLeverage) {
      const Eigen::Matrix<double, 2, 3> qc = q * p->core;
      const Eigen::Matrix2d mixed = products.with_point * q.transpose();
      adjusted = qc * q.transpose() - mixed - mixed.transpose() + products.own;
      shift = qc - products.with_point;
    } else {
      products = ComplementProducts(problem, inverse->blocks, 2 * k, p);
      adjusted += products.own;
      shift = q - products.with_point;
    }
  }
  return {look.look, look.whitened_error, q, adjusted, p->r_inverse * shift.transpose()};
}

/// Reliability of both components of one look; returns its redundancy.
double FillLook(const LookCovariance& look, LookQuality* out) {
  double total = 0.0;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto component = static_cast<std::size_t>(i);
    const double redundancy = 1.0 - look.adjusted_covariance(i, i);
    total += redundancy;
    out->redundancy[component][look.look] = static_cast<float>(redundancy);
    out->w[component][look.look] =
        redundancy > kMinRedundancy
            ? static_cast<float>(look.whitened_error[i] / std::sqrt(redundancy))
            : std::numeric_limits<float>::quiet_NaN();
    out->shift_m[component][look.look] = static_cast<float>(look.shift_m.col(i).norm());
  }
  return total;
}

void Prepare(std::size_t points, std::size_t looks, bool quality, PointSweep* out) {
  out->covariance_m2.resize(points);
  if (!quality) return;
  out->redundancy.assign(points, kNaN);
  for (std::size_t component = 0; component < 2; ++component) {
    for (auto* values : {&out->quality.redundancy, &out->quality.w, &out->quality.shift_m}) {
      (*values)[component].assign(looks, std::numeric_limits<float>::quiet_NaN());
    }
  }
}

}  // namespace

SymmetricEnu ToEnu(const Frame& frame, const Eigen::Vector3d& p_m, const Eigen::Matrix3d& m) {
  if (frame.kind() == FrameKind::kLocal) return SymmetricOf(m);
  const Eigen::Matrix3d e = frame.EnuFromFrame(p_m);
  const Eigen::Matrix3d c = e * m * e.transpose();
  return SymmetricOf(c);
}

PointSweep SweepPoints(const AdjustmentProblem& problem,
                       const BlockState& state,
                       const CorrectionCovariance* inverse,
                       bool quality,
                       ProgressSink* progress,
                       const KeptFactors* kept) {
  const std::size_t points = problem.block.points.size();
  PointSweep out;
  Prepare(points, problem.block.looks.size(), quality, &out);
  if (inverse != nullptr && inverse->rows() == 0) inverse = nullptr;
  Step(progress, "covariance", 0, points);
  const auto sweep = [&](std::size_t, std::size_t begin, std::size_t end) {
    PointState p;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) {
        out.covariance_m2[point].fill(kNaN);
        continue;
      }
      FactorAt(problem, state, inverse, quality, kept, point, &p);
      out.covariance_m2[point] = ToEnu(problem.block.frame,
                                       state.Position(point),
                                       p.r_inverse * p.core * p.r_inverse.transpose());
      if (!quality) continue;
      double sum = 0.0;
      for (int k = 0; k < p.factor.look_count; ++k) {
        sum += FillLook(CovarianceAt(problem, inverse, k, &p), &out.quality);
      }
      out.redundancy[point] = sum;
    }
  };
  const auto by_look = [&](std::vector<float>* values) {
    return SharedArray::ByRange(problem.block.looks.offsets, values);
  };
  LookQuality& q = out.quality;
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByItem(&out.covariance_m2),
                    SharedArray::ByItem(&out.redundancy),
                    by_look(&q.redundancy[0]),
                    by_look(&q.redundancy[1]),
                    by_look(&q.w[0]),
                    by_look(&q.w[1]),
                    by_look(&q.shift_m[0]),
                    by_look(&q.shift_m[1])},
                   sweep);
  Step(progress, "covariance", points, points);
  return out;
}

std::vector<LookCovariance> CovariancesOfLooks(const AdjustmentProblem& problem,
                                               const BlockState& state,
                                               const CorrectionCovariance* inverse,
                                               std::size_t point) {
  PointState p;
  FactorAt(problem, state, inverse, true, nullptr, point, &p);
  std::vector<LookCovariance> out;
  for (int k = 0; k < p.factor.look_count; ++k) {
    out.push_back(CovarianceAt(problem, inverse, k, &p));
  }
  return out;
}

std::vector<ControlQuality> ControlQualities(const AdjustmentProblem& problem,
                                             const BlockState& state,
                                             const std::vector<SymmetricEnu>& covariance_m2) {
  std::vector<ControlQuality> out;
  const Block& block = problem.block;
  for (const KnownPosition& known : block.points.known) {
    const std::int32_t index = problem.control_of[known.point];
    if (index < 0 || !problem.Solves(known.point)) continue;
    const ControlEquations& control = problem.control[static_cast<std::size_t>(index)];
    std::vector<int> fixed;
    for (int i = 0; i < 3; ++i) {
      if (known.fixed[static_cast<std::size_t>(i)]) fixed.push_back(i);
    }
    const SymmetricEnu& c = covariance_m2[known.point];
    const Eigen::Matrix3d adjusted = MatrixOf(c);
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(control.known_m) * (state.Position(known.point) - control.known_m);
    const auto n = static_cast<Eigen::Index>(fixed.size());
    Eigen::MatrixXd given(n, n), of_held(3, n);
    Eigen::VectorXd residual(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int hi = fixed[static_cast<std::size_t>(i)];
      residual[i] = error_m[hi];
      of_held.col(i) = adjusted.col(hi);
      for (Eigen::Index j = 0; j < n; ++j) {
        given(i, j) = known.covariance_enu_m2(hi, fixed[static_cast<std::size_t>(j)]);
      }
    }
    if (control.height_only) {
      residual[0] =
          EvaluateControl(
              block.frame, control, state.start_m[known.point], state.displacement_m[known.point])
              .residual[0] *
          std::sqrt(given(0, 0));
    }
    const Eigen::MatrixXd weight = given.inverse();
    Eigen::MatrixXd of_residual = given;
    for (Eigen::Index i = 0; i < n; ++i) {
      of_residual.row(i) -= of_held.row(fixed[static_cast<std::size_t>(i)]);
    }
    const Eigen::VectorXd weighted = weight * residual;
    const Eigen::MatrixXd of_weighted = weight * of_residual * weight;
    const Eigen::MatrixXd gain = of_held * weight;
    for (Eigen::Index i = 0; i < n; ++i) {
      ControlQuality q;
      q.point = known.point;
      q.component = fixed[static_cast<std::size_t>(i)];
      q.residual_m = residual[i];
      q.redundancy = (of_residual * weight)(i, i);
      q.w = q.redundancy > kMinRedundancy ? weighted[i] / std::sqrt(of_weighted(i, i)) : kNaN;
      q.shift_m = gain.col(i).norm() * std::sqrt(given(i, i));
      out.push_back(q);
    }
  }
  return out;
}

namespace {

/// The equations of one point, [J_p | J_c | e] with the columns of J_c those of `blocks`.
struct ResidualEquations {
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
                   ResidualEquations* out) {
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
             ResidualEquations* out) {
  out->a.block<2, 3>(row, 0) = look.d_point;
  out->a.block<2, 1>(row, 3 + out->columns) = look.whitened_error;
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

ResidualEquations EquationsOf(const AdjustmentProblem& problem,
                              const BlockState& state,
                              std::size_t point) {
  ResidualEquations out;
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
    out.a.bottomLeftCorner(control->rows, 3) = at.d_point.topRows(control->rows);
    out.a.bottomRightCorner(control->rows, 1) = at.residual.head(control->rows);
  }
  return out;
}

/// C over the blocks of a point.
Eigen::MatrixXd Gather(const BlockSymmetricMatrix& inverse, const ResidualEquations& equations) {
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

double PointResiduals::w(Eigen::Index i) const {
  const double r = q_vv(i, i);
  return r > kMinRedundancy ? v[i] / std::sqrt(r) : std::numeric_limits<double>::quiet_NaN();
}

double PointResiduals::Correlation(Eigen::Index i, Eigen::Index k) const {
  return q_vv(i, k) / std::sqrt(q_vv(i, i) * q_vv(k, k));
}

PointResiduals ResidualsOfPoint(const AdjustmentProblem& problem,
                                const BlockState& state,
                                const CorrectionCovariance* inverse,
                                std::size_t point) {
  PointResiduals out;
  ResidualEquations equations = EquationsOf(problem, state, point);
  out.looks = equations.looks;
  out.looks_of_point = out.looks.size();
  Eigen::MatrixXd& a = equations.a;
  const Eigen::Index m = a.rows(), columns = equations.columns;
  out.control_rows = static_cast<int>(m) - 2 * static_cast<int>(out.looks.size());
  out.v = a.col(3 + columns);
  const dense::Orthogonal qr(a.leftCols(3));
  const Eigen::MatrixXd q = qr.Q(m);
  const Eigen::MatrixXd q2 = q.rightCols(m - 3);
  const Eigen::Matrix3d r = qr.R();
  out.q_vv = q2 * q2.transpose();
  Eigen::MatrixXd gain = q.leftCols(3).transpose();
  out.information = q.leftCols(3);
  out.corrections_share.setZero(m);
  if (inverse != nullptr && columns > 0) {
    const Eigen::MatrixXd turned = q.transpose() * a.middleCols(3, columns);
    const Eigen::MatrixXd c_b =
        Gather(inverse->blocks, equations) * turned.bottomRows(m - 3).transpose();
    const Eigen::MatrixXd shared = q2 * (turned.bottomRows(m - 3) * c_b) * q2.transpose();
    out.q_vv -= shared;
    out.corrections_share = shared.diagonal();
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
  out.v = at.whitened_error;
  out.q_vv = Eigen::Matrix2d::Identity() - at.adjusted_covariance;
  out.information = at.information;
  const Eigen::Matrix2d point_share = at.information * at.information.transpose();
  out.corrections_share = (at.adjusted_covariance - point_share).diagonal();
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
  out.v = Eigen::Map<const Eigen::VectorXd>(factor.e.data(), factor.row_count);
  out.information = Eigen::Map<const Eigen::MatrixX3d>(factor.q.data(), factor.row_count, 3);
  return out;
}

namespace {

constexpr std::size_t kRoundedPerChunk = 4096;
constexpr double kRounding = std::numeric_limits<double>::epsilon();
/// Part of a standard deviation above which rounding is reported.
constexpr double kReported = 1e-4;

/// The worst equation met so far.
struct Worst {
  double part = 0.0;
  double rounding_m = 0.0;
  std::size_t point = 0, points = 0;

  void Add(const Worst& other) {
    points += other.points;
    if (other.part <= part) return;
    part = other.part;
    rounding_m = other.rounding_m;
    point = other.point;
  }
};

Worst WorstOfPoint(const AdjustmentProblem& problem, const BlockState& state, std::size_t point) {
  const Looks& looks = problem.block.looks;
  const double point_m = state.Position(point).lpNorm<Eigen::Infinity>();
  Worst worst;
  worst.point = point;
  const auto meet = [&](double rounding_m, double per_m) {
    if (!(rounding_m * per_m > worst.part)) return;
    worst.part = rounding_m * per_m;
    worst.rounding_m = rounding_m;
  };
  for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    const std::size_t pass = looks.pass[i];
    Motion motion;
    if (!problem.block.passes[pass].path.Evaluate(looks.time_s[i], &motion)) continue;
    double rounding_m =
        kRounding *
        std::max({point_m, motion.position_m.lpNorm<Eigen::Infinity>(), looks.range_m[i]});
    // A time is no finer in its file than it is here.
    rounding_m += kRounding * std::abs(looks.time_s[i]) * motion.velocity_mps.norm();
    const LookWeights& w = problem.weights[i];
    const double unit_m = problem.block.ApproximateAzimuthUnit_m(i, motion.velocity_mps.norm());
    meet(rounding_m, std::max(w.range_per_m, w.azimuth_per_unit / unit_m));
  }
  worst.points = worst.part > kReported ? 1 : 0;
  return worst;
}

}  // namespace

void WarnOfRounding(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result) {
  const std::size_t points = problem.block.points.size();
  std::vector<Worst> parts((points + kRoundedPerChunk - 1) / kRoundedPerChunk);
  ForChunksOfRanks(points,
                   kRoundedPerChunk,
                   {SharedArray::ByChunk(&parts)},
                   [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                     for (std::size_t point = begin; point < end; ++point) {
                       if (problem.Solves(point))
                         parts[chunk].Add(WorstOfPoint(problem, state, point));
                     }
                   });
  Worst worst;
  for (const Worst& part : parts) worst.Add(part);
  if (worst.points == 0) return;
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.1e m, %.1e", worst.rounding_m, worst.part);
  Warn(result,
       std::to_string(worst.points) +
           " points have looks weighted finer than the rounding of double precision "
           "carries their coordinates or times, the worst is " +
           std::string(problem.block.points.ids[worst.point]) + ": one rounding is " + text.data() +
           " of the standard deviation; sigmas describe the weights, not the digits of the "
           "positions. Move the origin of coordinates or times nearer");
}

namespace {

bool HasMeaning(const AdjustResult& result) {
  return !result.parameters.empty() && !result.parameter_covariance.empty() &&
         !result.points.covariance_m2.empty() && !result.variance_components;
}

}  // namespace

std::vector<SymmetricEnu> FixedPathCovariances(const Block& block,
                                               const std::vector<CorrectionGroup>& groups,
                                               const AdjustResult& result) {
  if (!HasMeaning(result)) return {};
  AdjustmentProblem problem(block, groups, result.selection.simplified);
  const auto parameters = static_cast<Eigen::Index>(result.parameters.size());
  if (problem.layout.size() != parameters) return {};
  BlockState state;
  state.start_m = result.points.position_m;
  state.displacement_m.assign(state.start_m.size(), Eigen::Vector3d::Zero());
  state.corrections.resize(parameters);
  for (Eigen::Index i = 0; i < parameters; ++i) {
    state.corrections[i] = result.parameters[static_cast<std::size_t>(i)].value;
  }
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    problem.point_status[point] = result.points.status[point];
    if (!IsSolved(result.points.status[point])) {
      problem.LeaveOut(point, result.points.status[point], "");
    }
  }
  const std::vector<std::uint8_t>& rejected = result.looks.rejected;
  for (std::size_t look = 0; look < rejected.size() && look < block.looks.size(); ++look) {
    if (rejected[look] != 0) problem.look_used[look] = 0;
  }
  if (result.snooping) {
    for (const BlunderFinding& finding : result.snooping->findings) {
      if (finding.action == BlunderFinding::Action::kControlReleased) {
        problem.control_of[finding.point] = -1;
      }
    }
  }
  UpdateWeights(state, &problem);
  return SweepPoints(problem, state, nullptr, false, nullptr).covariance_m2;
}

}  // namespace sarblock
