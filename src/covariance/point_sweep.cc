// SPDX-License-Identifier: Apache-2.0
#include "point_sweep.h"

#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <cmath>
#include <limits>
#include <vector>

#include "core/threads.h"
#include "normals/point.h"
#include <Eigen/LU>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 128;
/// Variance that corrections give to an equation of unit variance, above which the short form of
/// the look's leverage loses more digits than a float holds: then the complement is used (not for a
/// point of the border, where it would need all pairs of its passes).
constexpr double kLargeLeverage_1 = 1e6;

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
    for (int axis = 0; axis < 3; ++axis) {
      double* y = p->y.data() + axis * columns.width + columns.begin[b];
      for (int i = 0; i < block.size; ++i) {
        y[i] = inverse.t_c(p->border_row + axis, block.offset + i);
      }
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
    if (p->border_row >= 0 || products.own.diagonal().maxCoeff() <= kLargeLeverage_1) {
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
  return {look.look, look.error_1, q, adjusted, p->r_inverse * shift.transpose()};
}

/// Reliability of both components of one look; returns its redundancy.
double FillLook(const LookCovariance& look, LookQuality* out) {
  double total = 0.0;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto component = static_cast<std::size_t>(i);
    const double redundancy = 1.0 - look.adjusted_1(i, i);
    total += redundancy;
    out->redundancy_1[component][look.look] = static_cast<float>(redundancy);
    out->w_1[component][look.look] =
        redundancy > kLeastRedundancy_1
            ? static_cast<float>(look.error_1[i] / std::sqrt(redundancy))
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
    for (auto* values : {&out->quality.redundancy_1, &out->quality.w_1, &out->quality.shift_m}) {
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
                    by_look(&q.redundancy_1[0]),
                    by_look(&q.redundancy_1[1]),
                    by_look(&q.w_1[0]),
                    by_look(&q.w_1[1]),
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
    std::vector<int> held;
    for (int i = 0; i < 3; ++i) {
      if (known.held[static_cast<std::size_t>(i)]) held.push_back(i);
    }
    const SymmetricEnu& c = covariance_m2[known.point];
    const Eigen::Matrix3d adjusted = MatrixOf(c);
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(control.known_m) * (state.Position(known.point) - control.known_m);
    const auto n = static_cast<Eigen::Index>(held.size());
    Eigen::MatrixXd given(n, n), of_held(3, n);
    Eigen::VectorXd residual(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int hi = held[static_cast<std::size_t>(i)];
      residual[i] = error_m[hi];
      of_held.col(i) = adjusted.col(hi);
      for (Eigen::Index j = 0; j < n; ++j) {
        given(i, j) = known.covariance_enu_m2(hi, held[static_cast<std::size_t>(j)]);
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
      of_residual.row(i) -= of_held.row(held[static_cast<std::size_t>(i)]);
    }
    const Eigen::VectorXd weighted = weight * residual;
    const Eigen::MatrixXd of_weighted = weight * of_residual * weight;
    const Eigen::MatrixXd gain = of_held * weight;
    for (Eigen::Index i = 0; i < n; ++i) {
      ControlQuality q;
      q.point = known.point;
      q.component = held[static_cast<std::size_t>(i)];
      q.residual_m = residual[i];
      q.redundancy_1 = (of_residual * weight)(i, i);
      q.w_1 =
          q.redundancy_1 > kLeastRedundancy_1 ? weighted[i] / std::sqrt(of_weighted(i, i)) : kNaN;
      q.shift_m = gain.col(i).norm() * std::sqrt(given(i, i));
      out.push_back(q);
    }
  }
  return out;
}

}  // namespace sarblock
