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
#include "verdict_tests.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 128;
/// Variance that corrections give to an equation of unit variance, above which the short form of
/// the look's leverage loses more digits than a float holds: then the complement is used (not for a
/// point of the border, where it would need all pairs of its passes).
constexpr double kLargeLeverage = 1e6;

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
  out->fixed_path_covariance_m2.resize(points);
  out->redundancy.assign(points, kNaN);
  for (std::size_t component = 0; component < 2; ++component) {
    for (auto* values : {&out->quality.redundancy, &out->quality.w, &out->quality.shift_m}) {
      (*values)[component].assign(looks, std::numeric_limits<float>::quiet_NaN());
    }
  }
}

}  // namespace

PointLinearization::PointLinearization(const AdjustmentProblem& problem,
                                       const BlockState& state,
                                       const CorrectionCovariance* inverse,
                                       bool quality,
                                       const KeptFactors* kept)
    : problem_(problem),
      state_(state),
      inverse_(inverse == nullptr || inverse->rows() == 0 ? nullptr : inverse),
      quality_(quality),
      kept_(kept) {}

/// Y = T C of a point of the border.
void PointLinearization::GatherBorder() {
  const PointColumns& columns = terms_.columns;
  for (std::size_t b = 0; b < columns.blocks.size(); ++b) {
    const ParameterBlock& block =
        problem_.layout.blocks[static_cast<std::size_t>(columns.blocks[b])];
    for (int i = 0; i < block.size; ++i) {
      const double* const of_column = inverse_->t_c.At(border_row_, block.offset + i);
      double* const y = y_.data() + columns.begin[b] + i;
      for (int axis = 0; axis < 3; ++axis) y[axis * columns.width] = of_column[axis];
    }
  }
}

/// Y = T C and I + T C T' where looks are asked for, else the second alone.
void PointLinearization::MultiplyByInverse() {
  const auto width = static_cast<std::size_t>(terms_.columns.width);
  const double* values = inverse_->blocks.values().data();
  const bool bordered = border_row_ >= 0;
  if (!quality_ && !bordered) {
    const PointBlocks blocks = FindBlocks(problem_.layout, *inverse_->blocks.pattern(), &terms_);
    Kernels().AddQuadraticForm(blocks, t_, width, values, core_.data());
    return;
  }
  y_.assign(3 * width, 0.0);
  if (bordered) {
    GatherBorder();
  } else {
    const PointBlocks blocks = FindBlocks(problem_.layout, *inverse_->blocks.pattern(), &terms_);
    Kernels().AddProductWithMatrix(blocks, t_, width, values, y_.data());
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = 0.0;
      for (std::size_t c = 0; c < width; ++c) sum += t_[a * width + c] * y_[b * width + c];
      core_(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) += sum;
      if (a != b) core_(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) += sum;
    }
  }
}

PointLinearization& PointLinearization::At(std::size_t point) {
  PointColumns& columns = terms_.columns;
  t_ = kept_ != nullptr ? kept_->Restore(problem_, point, &factor_.r, &columns) : nullptr;
  const bool restored = t_ != nullptr;
  if (restored && quality_) kept_->RestoreLooks(problem_, point, &factor_);
  if (!restored) FactorPoint(problem_, state_, {}, 0.0, point, &factor_);
  r_inverse_ = InverseOfUpper(factor_.r);
  core_.setIdentity();
  complement_formed_ = false;
  if (inverse_ == nullptr) return *this;
  border_row_ = inverse_->bordered.RowOf(point);
  if (!restored) {
    ProjectColumns(problem_, factor_, &columns);
    t_ = columns.t.data();
  }
  MultiplyByInverse();
  return *this;
}

/// J_c Y' and J_c C J_c' of one look over its own columns.
PointLinearization::Products<2> PointLinearization::ProductsOf(const WhitenedLook& look) const {
  Products<2> out{Eigen::Matrix<double, 2, 3>::Zero(), Eigen::Matrix2d::Zero()};
  const auto width = static_cast<std::size_t>(terms_.columns.width);
  const double* j0 = look.row[0].data();
  const double* j1 = look.row[1].data();
  int first = 0;
  for (int b = 0; b < look.columns.block_count; ++b) {
    const int id = look.columns.block[static_cast<std::size_t>(b)];
    const int size = problem_.layout.blocks[static_cast<std::size_t>(id)].size;
    const double* y = y_.data() + terms_.columns.column_of_block[static_cast<std::size_t>(id)];
    for (Eigen::Index axis = 0; axis < 3; ++axis, y += width) {
      for (int i = 0; i < size; ++i) {
        out.with_point(0, axis) += j0[first + i] * y[i];
        out.with_point(1, axis) += j1[first + i] * y[i];
      }
    }
    int other = 0;
    for (int b2 = 0; b2 < look.columns.block_count; ++b2) {
      const int id2 = look.columns.block[static_cast<std::size_t>(b2)];
      const int size2 = problem_.layout.blocks[static_cast<std::size_t>(id2)].size;
      if (id2 <= id) {
        const auto block = inverse_->blocks.Block(id, id2);
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

PointLinearization::Complements PointLinearization::Complement() {
  PointColumns& columns = terms_.columns;
  if (!complement_formed_) {
    sarblock::Complement(problem_, factor_, &columns);
    complement_formed_ = true;
  }
  return {columns.m.data(),
          factor_.row_count,
          columns.width,
          Eigen::OuterStride<>(static_cast<Eigen::Index>(columns.width) + 1)};
}

/// The same two products of rows of the complement M: M Y' and M C M'.
template <int Rows>
PointLinearization::Products<Rows> PointLinearization::ComplementProducts(int first, int rows) {
  static_cast<void>(Complement());
  PointColumns& columns = terms_.columns;
  const auto width = static_cast<std::size_t>(columns.width), stride = width + 1;
  const PointBlocks blocks = FindBlocks(problem_.layout, *inverse_->blocks.pattern(), &terms_);
  const auto row_of = [&](int row) {
    return columns.m.data() + static_cast<std::size_t>(row) * stride;
  };
  Products<Rows> out;
  out.with_point.resize(rows, 3);
  out.own.resize(rows, rows);
  std::vector<double>& c_m = columns.scratch;  // three rows of M C
  for (int k = 0; k < rows; k += 3) {
    const int at = std::min(first + k, factor_.row_count - 3);
    c_m.assign(3 * stride, 0.0);
    Kernels().AddProductWithMatrix(
        blocks, row_of(at), stride, inverse_->blocks.values().data(), c_m.data());
    for (int row = k; row < std::min(k + 3, rows); ++row) {
      for (int axis = 0; axis < 3; ++axis) {
        const double* const of_axis = y_.data() + static_cast<std::size_t>(axis) * width;
        out.with_point(row, axis) = Dot(width, row_of(first + row), of_axis);
      }
      const double* const product =
          c_m.data() + static_cast<std::size_t>(first + row - at) * stride;
      for (int other = 0; other < rows; ++other) {
        out.own(row, other) = Dot(width, product, row_of(first + other));
      }
    }
  }
  return out;
}

LookCovariance PointLinearization::Look(int k) {
  const WhitenedLook& look = factor_.looks[static_cast<std::size_t>(k)];
  Eigen::Matrix<double, 2, 3> q;
  q.row(0) = factor_.RowOfQ(2 * k);
  q.row(1) = factor_.RowOfQ(2 * k + 1);
  Eigen::Matrix2d adjusted = q * q.transpose();  // covariance of the adjusted look
  Eigen::Matrix<double, 2, 3> shift = q;         // by unit errors, times R'
  if (inverse_ != nullptr) {
    Products<2> products = ProductsOf(look);
    if (border_row_ >= 0 || products.own.diagonal().maxCoeff() <= kLargeLeverage) {
      const Eigen::Matrix<double, 2, 3> qc = q * core_;
      const Eigen::Matrix2d mixed = products.with_point * q.transpose();
      adjusted = qc * q.transpose() - mixed - mixed.transpose() + products.own;
      shift = qc - products.with_point;
    } else {
      products = ComplementProducts<2>(2 * k, 2);
      adjusted += products.own;
      shift = q - products.with_point;
    }
  }
  return {look.look, look.whitened_error, q, adjusted, r_inverse_ * shift.transpose()};
}

PointResiduals PointLinearization::Information() const {
  PointResiduals out;
  for (int k = 0; k < factor_.look_count; ++k) {
    out.looks.push_back(factor_.looks[static_cast<std::size_t>(k)].look);
  }
  out.looks_of_point = out.looks.size();
  out.v = Eigen::Map<const Eigen::VectorXd>(factor_.e.data(), factor_.row_count);
  out.information = Eigen::Map<const Eigen::MatrixX3d>(factor_.q.data(), factor_.row_count, 3);
  return out;
}

PointResiduals PointLinearization::Residuals() {
  PointResiduals out = Information();
  const Eigen::Index m = out.size();
  out.q_vv = Eigen::MatrixXd::Identity(m, m) - out.information * out.information.transpose();
  out.corrections_share = Eigen::MatrixXd::Zero(m, m);
  Eigen::MatrixX3d shift = out.information;
  if (inverse_ != nullptr) {
    const Products<Eigen::Dynamic> products =
        ComplementProducts<Eigen::Dynamic>(0, factor_.row_count);
    out.corrections_share = products.own;
    out.q_vv -= products.own;
    shift -= products.with_point;
  }
  out.shift_m = r_inverse_ * shift.transpose();
  return out;
}

PointResiduals PointLinearization::ResidualsOf(std::uint64_t look) {
  const auto begin = factor_.looks.begin(), end = begin + factor_.look_count;
  const auto found =
      std::find_if(begin, end, [look](const WhitenedLook& of) { return of.look == look; });
  const LookCovariance at = Look(static_cast<int>(found - begin));
  PointResiduals out;
  out.looks = {look};
  out.looks_of_point = static_cast<std::size_t>(factor_.look_count);
  out.v = at.whitened_error;
  out.q_vv = Eigen::Matrix2d::Identity() - at.adjusted_covariance;
  out.information = at.information;
  out.corrections_share = at.adjusted_covariance - at.information * at.information.transpose();
  out.shift_m = at.shift_m;
  return out;
}

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
  Step(progress, "covariance", 0, points);
  const auto sweep = [&](std::size_t, std::size_t begin, std::size_t end) {
    PointLinearization at(problem, state, inverse, quality, kept);
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) {
        out.covariance_m2[point].fill(kNaN);
        if (quality) out.fixed_path_covariance_m2[point].fill(kNaN);
        continue;
      }
      at.At(point);
      const auto enu = [&](const Eigen::Matrix3d& covariance_m2) {
        return ToEnu(problem.block.frame, state.Position(point), covariance_m2);
      };
      out.covariance_m2[point] = enu(at.Covariance());
      if (!quality) continue;
      out.fixed_path_covariance_m2[point] = enu(at.FixedPathCovariance());
      double sum = 0.0;
      for (int k = 0; k < at.factor().look_count; ++k) sum += FillLook(at.Look(k), &out.quality);
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
                    SharedArray::ByItem(&out.fixed_path_covariance_m2),
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
    const Eigen::MatrixXd weight = dense::Cholesky(given).Inverse();
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

double PointResiduals::w(Eigen::Index i) const {
  const double r = q_vv(i, i);
  return r > kMinRedundancy ? v[i] / std::sqrt(r) : std::numeric_limits<double>::quiet_NaN();
}

double PointResiduals::Correlation(Eigen::Index i, Eigen::Index k) const {
  return q_vv(i, k) / std::sqrt(q_vv(i, i) * q_vv(k, k));
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

}  // namespace sarblock
