// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/reduced_system.h"

#include "sarblock/core/error.h"
#include "sarblock/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "thin_point.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;
/// Partial sums are limited to this much memory; their number depends on the block alone, never on
/// the threads.
constexpr std::size_t kPartialBytes = std::size_t{256} << 20;
constexpr std::size_t kMostPartials = 16;

/// Pairs of blocks seen together: a bit table while it is small, else a hash set.
class PairSet {
 public:
  explicit PairSet(std::size_t blocks) : blocks_(blocks), dense_(blocks <= 16384) {
    if (dense_) bits_.assign(blocks * blocks, false);
  }
  void Add(int i, int j, std::vector<std::pair<int, int>>* out) {
    const std::size_t key = static_cast<std::size_t>(i) * blocks_ + static_cast<std::size_t>(j);
    if (dense_) {
      if (bits_[key]) return;
      bits_[key] = true;
    } else if (!seen_.insert(key).second) {
      return;
    }
    out->emplace_back(i, j);
  }

 private:
  std::size_t blocks_;
  bool dense_;
  std::vector<bool> bits_;
  std::unordered_set<std::size_t> seen_;
};

BlockSymmetricMatrix PatternOf(const AdjustmentProblem& problem) {
  const ParameterLayout& layout = problem.layout;
  std::vector<int> sizes;
  for (const ParameterBlock& block : layout.blocks) sizes.push_back(block.size);
  PairSet seen(layout.blocks.size());
  std::vector<std::pair<int, int>> pairs;
  std::vector<int> blocks;
  LookColumns columns;
  const Looks& looks = problem.block.looks;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    blocks.clear();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      problem.model.ColumnsOf(i, &columns);
      blocks.insert(
          blocks.end(), columns.block.begin(), columns.block.begin() + columns.block_count);
    }
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    for (std::size_t a = 0; a < blocks.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) seen.Add(blocks[a], blocks[b], &pairs);
    }
  }
  return BlockSymmetricMatrix(std::move(sizes), std::move(pairs));
}

/// What one range of points adds.
struct Partial {
  explicit Partial(const BlockSymmetricMatrix& pattern)
      : s(pattern),
        right_side(Eigen::VectorXd::Zero(pattern.rows())),
        diagonal(right_side),
        gradient(right_side),
        eliminated(right_side) {
    s.SetZero();
  }
  BlockSymmetricMatrix s;
  Eigen::VectorXd right_side, diagonal, gradient;
  Eigen::VectorXd eliminated;  // damped route: what elimination takes from the gradient
  std::vector<WeakPoint> weak;
  double cost = 0.0, point_step_square = 0.0, point_gradient = 0.0;
  int not_evaluated = 0;
};

/// block += factor a b', a and b as long as its rows and columns.
void AddOuter(Eigen::Map<Eigen::MatrixXd>& block, const double* a, const double* b, double factor) {
  const Eigen::Index rows = block.rows(), columns = block.cols();
  double* out = block.data();
  for (Eigen::Index j = 0; j < columns; ++j, out += rows) {
    const double scale = factor * b[j];
    for (Eigen::Index i = 0; i < rows; ++i) out[i] += scale * a[i];
  }
}

/// One point by the complement of its Jacobian: no digit is lost to thin intersections.
void AddPoint(const AdjustmentProblem& problem,
              const BlockState& state,
              const Weighting& weighting,
              std::size_t point,
              PointRows* rows,
              Eigen::MatrixXd* scratch,
              Partial* out) {
  LinearisePoint(problem, state, weighting, point, rows);
  const Eigen::Index n = rows->column_count, m = rows->row_count;
  out->cost += rows->cost_1;
  out->not_evaluated += rows->looks_not_evaluated;
  const auto jc = rows->a.block(0, 3, m, n);
  const auto e = rows->a.col(3 + n).head(m);
  for (std::size_t b = 0; b < rows->blocks.size(); ++b) {
    const ParameterBlock& block = problem.layout.blocks[static_cast<std::size_t>(rows->blocks[b])];
    const auto part = jc.middleCols(rows->block_column[b], block.size);
    out->diagonal.segment(block.offset, block.size) += part.colwise().squaredNorm().transpose();
    for (int c = 0; c < block.size; ++c) {
      out->gradient[block.offset + c] += part.col(c).dot(e);
    }
  }
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double length = rows->a.col(k).head(m).norm();
    if (length > 0.0) {
      out->point_gradient =
          std::max(out->point_gradient, std::abs(rows->a.col(k).head(m).dot(e)) / length);
    }
  }
  const EliminatedPoint eliminated = EliminatePoint(rows);
  if (!(eliminated.reciprocal_condition_1 >= kLeastPointCondition_1)) {
    out->weak.push_back({static_cast<std::uint32_t>(point), eliminated.reciprocal_condition_1});
    return;
  }
  out->point_step_square += rows->a.col(3 + n).head<3>().squaredNorm();
  if (n == 0 || m <= 3) return;
  // Rows of Q2' [J_c | e] as contiguous columns, then S += sum of their outer products, lower part.
  *scratch = rows->a.block(3, 3, m - 3, n + 1).transpose();
  for (std::size_t j = 0; j < rows->blocks.size(); ++j) {
    const ParameterBlock& bj = problem.layout.blocks[static_cast<std::size_t>(rows->blocks[j])];
    for (std::size_t i = j; i < rows->blocks.size(); ++i) {
      auto block = out->s.Block(rows->blocks[i], rows->blocks[j]);
      for (Eigen::Index k = 0; k < m - 3; ++k) {
        const double* row = scratch->col(k).data();
        AddOuter(block, row + rows->block_column[i], row + rows->block_column[j], 1.0);
      }
    }
    for (Eigen::Index k = 0; k < m - 3; ++k) {
      const double* row = scratch->col(k).data();
      for (int c = 0; c < bj.size; ++c) {
        out->right_side[bj.offset + c] += row[rows->block_column[j] + c] * row[n];
      }
    }
  }
}

/// Scratch of the damped route: T = Q' J_c by rows over the point's blocks.
struct ThinColumns {
  std::vector<int> blocks, block_column;
  std::array<std::vector<double>, 3> t;
};

/// One damped point by its thin factor (thin_point.h).
void AddThinPoint(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const Weighting& weighting,
                  double damping,
                  std::size_t point,
                  ThinPoint* thin,
                  ThinColumns* columns,
                  Partial* out) {
  FactorThin(problem, state, weighting, damping, point, thin);
  out->cost += thin->cost_1;
  out->not_evaluated += thin->looks_not_evaluated;
  for (Eigen::Index k = 0; k < 3; ++k) {
    out->point_gradient =
        std::max(out->point_gradient, std::abs(thin->gradient[k]) / std::sqrt(thin->square[k]));
  }
  const Eigen::Vector3d c = Project(*thin, thin->e);
  out->point_step_square += c.squaredNorm();

  std::vector<int>& blocks = columns->blocks;
  blocks.clear();
  for (int k = 0; k < thin->look_count; ++k) {
    const LookColumns& look = thin->looks[static_cast<std::size_t>(k)].columns;
    blocks.insert(blocks.end(), look.block.begin(), look.block.begin() + look.block_count);
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  columns->block_column.clear();
  int width = 0;
  for (const int block : blocks) {
    columns->block_column.push_back(width);
    width += problem.layout.blocks[static_cast<std::size_t>(block)].size;
  }
  for (std::vector<double>& row : columns->t) row.assign(static_cast<std::size_t>(width), 0.0);
  const auto slot_of = [&](int block) {
    return static_cast<std::size_t>(std::lower_bound(blocks.begin(), blocks.end(), block) -
                                    blocks.begin());
  };
  const int m = thin->row_count;
  for (int k = 0; k < thin->look_count; ++k) {
    const WhitenedLook& look = thin->looks[static_cast<std::size_t>(k)];
    const double* range = look.range_row.data();
    const double* doppler = look.doppler_row.data();
    int first = 0;
    for (int b = 0; b < look.columns.block_count; ++b) {
      const int id = look.columns.block[static_cast<std::size_t>(b)];
      const ParameterBlock& block = problem.layout.blocks[static_cast<std::size_t>(id)];
      const int at = columns->block_column[slot_of(id)];
      for (int i = 0; i < block.size; ++i) {
        const double r = range[first + i], d = doppler[first + i];
        out->diagonal[block.offset + i] += r * r + d * d;
        out->gradient[block.offset + i] += r * look.error_1[0] + d * look.error_1[1];
        for (int axis = 0; axis < 3; ++axis) {
          const double* q = thin->q.data() + axis * m + 2 * k;
          columns->t[static_cast<std::size_t>(axis)][static_cast<std::size_t>(at + i)] +=
              q[0] * r + q[1] * d;
        }
      }
      // J_c' J_c of the look: pairs of its own blocks.
      int other = 0;
      for (int b2 = 0; b2 < look.columns.block_count; ++b2) {
        const int id2 = look.columns.block[static_cast<std::size_t>(b2)];
        const int size2 = problem.layout.blocks[static_cast<std::size_t>(id2)].size;
        if (id2 <= id) {
          auto s = out->s.Block(id, id2);
          AddOuter(s, range + first, range + other, 1.0);
          AddOuter(s, doppler + first, doppler + other, 1.0);
        }
        other += size2;
      }
      first += block.size;
    }
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const ParameterBlock& bi = problem.layout.blocks[static_cast<std::size_t>(blocks[i])];
    const auto ci = static_cast<std::size_t>(columns->block_column[i]);
    for (std::size_t j = 0; j <= i; ++j) {
      auto s = out->s.Block(blocks[i], blocks[j]);
      const auto cj = static_cast<std::size_t>(columns->block_column[j]);
      for (const std::vector<double>& t : columns->t) AddOuter(s, &t[ci], &t[cj], -1.0);
    }
    for (int q = 0; q < bi.size; ++q) {
      double sum = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        sum += columns->t[axis][ci + static_cast<std::size_t>(q)] * c[static_cast<int>(axis)];
      }
      out->eliminated[bi.offset + q] += sum;
    }
  }
}

}  // namespace

ReducedSystem::ReducedSystem(const AdjustmentProblem& problem)
    : problem_(problem), s_(PatternOf(problem)) {}

void ReducedSystem::Form(const BlockState& state,
                         const Weighting& weighting,
                         ProgressSink* progress,
                         double damping_1) {
  damping_1_ = damping_1;
  const std::size_t points = problem_.block.points.size();
  const std::size_t bytes = 1 + sizeof(double) * s_.values().size();
  const std::size_t partials = std::clamp<std::size_t>(
      std::min(kPartialBytes / bytes, points / kPointsPerChunk), 1, kMostPartials);
  std::vector<std::optional<Partial>> parts(partials);
  sarblock::Step(progress, "linearise", 0, points);
  const std::size_t per_part = (points + partials - 1) / partials;
  ParallelForChunks(points, per_part, [&](std::size_t part, std::size_t begin, std::size_t end) {
    Partial& out = parts[part].emplace(s_);
    PointRows rows;
    Eigen::MatrixXd scratch;
    ThinPoint thin;
    ThinColumns columns;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem_.Solves(point)) continue;
      if (damping_1 > 0.0) {
        AddThinPoint(problem_, state, weighting, damping_1, point, &thin, &columns, &out);
      } else {
        AddPoint(problem_, state, weighting, point, &rows, &scratch, &out);
      }
    }
    if (damping_1 > 0.0) out.right_side = out.gradient - out.eliminated;
  });
  s_.SetZero();
  right_side_.setZero(s_.rows());
  full_diagonal_.setZero(s_.rows());
  full_gradient_.setZero(s_.rows());
  weak_points_.clear();
  cost_1_ = gradient_1_ = point_step_square_1_ = 0.0;
  looks_not_evaluated_ = 0;
  for (const std::optional<Partial>& part : parts) {
    if (!part) continue;
    const std::span<double> sum = s_.values();
    const std::span<const double> add = part->s.values();
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += add[i];
    right_side_ += part->right_side;
    full_diagonal_ += part->diagonal;
    full_gradient_ += part->gradient;
    weak_points_.insert(weak_points_.end(), part->weak.begin(), part->weak.end());
    cost_1_ += part->cost;
    point_step_square_1_ += part->point_step_square;
    gradient_1_ = std::max(gradient_1_, part->point_gradient);
    looks_not_evaluated_ += part->not_evaluated;
  }
  sarblock::Step(progress, "linearise", points, points);
  AddPriors(state);
  if (damping_1 > 0.0) {
    for (std::size_t b = 0; b < problem_.layout.blocks.size(); ++b) {
      const ParameterBlock& block = problem_.layout.blocks[b];
      s_.Block(static_cast<int>(b), static_cast<int>(b)).diagonal() +=
          damping_1 * full_diagonal_.segment(block.offset, block.size);
    }
  }
  for (Eigen::Index i = 0; i < full_gradient_.size(); ++i) {
    if (full_diagonal_[i] > 0.0) {
      gradient_1_ =
          std::max(gradient_1_, std::abs(full_gradient_[i]) / std::sqrt(full_diagonal_[i]));
    }
  }
}

void ReducedSystem::AddPriors(const BlockState& state) {
  const ParameterLayout& layout = problem_.layout;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    const ParameterBlock& block = layout.blocks[b];
    for (int i = 0; i < block.size; ++i) {
      const int row = block.offset + i;
      const Parameter& parameter = layout.parameters[static_cast<std::size_t>(row)];
      if (!parameter.has_prior()) continue;
      const double weight = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
      const double x = state.corrections[row];
      s_.Block(static_cast<int>(b), static_cast<int>(b))(i, i) += weight;
      right_side_[row] += weight * x;
      full_diagonal_[row] += weight;
      full_gradient_[row] += weight * x;
      cost_1_ += 0.5 * weight * x * x;
    }
  }
}

void ReducedSystem::ThrowUndetermined(const Eigen::VectorXd& direction) const {
  const double most = direction.cwiseAbs().maxCoeff();
  std::vector<std::pair<double, int>> share;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) >= 0.1 * most) {
      share.emplace_back(-std::abs(direction[i]), static_cast<int>(i));
    }
  }
  std::sort(share.begin(), share.end());
  std::vector<std::string> names;
  std::string text;
  for (const auto& [weight, row] : share) {
    names.push_back(problem_.layout.Describe(row));
    if (names.size() <= 12) text += (text.empty() ? "" : ", ") + names.back();
  }
  if (names.size() > 12) text += " and " + std::to_string(names.size() - 12) + " more";
  throw UndeterminedError(
      "the block does not determine its corrections: these move together without changing any "
      "observation: " +
          text +
          "; add control points or a prior standard deviation, or leave a correction group out",
      names);
}

BlockSymmetricMatrix ReducedSystem::Scaled() {
  BlockSymmetricMatrix scaled = s_;
  for (int j = 0; j < scaled.block_count(); ++j) {
    for (const int i : scaled.RowsOfColumn(j)) {
      scaled.Block(i, j) = scale_.segment(scaled.offset(i), scaled.size(i)).asDiagonal() *
                           scaled.Block(i, j) *
                           scale_.segment(scaled.offset(j), scaled.size(j)).asDiagonal();
    }
  }
  if (!factor_) {
    std::vector<int> last;
    for (std::size_t b = 0; b < problem_.layout.blocks.size(); ++b) {
      if (problem_.layout.blocks[b].shared) last.push_back(static_cast<int>(b));
    }
    factor_.emplace(scaled, last);
  }
  return scaled;
}

bool ReducedSystem::FactorDamped() {
  if (s_.rows() == 0) return true;
  scale_.resize(s_.rows());
  for (int b = 0; b < s_.block_count(); ++b) {
    const auto diagonal = s_.Block(b, b).diagonal();
    for (int i = 0; i < s_.size(b); ++i) {
      if (!(diagonal[i] > 0.0) || !std::isfinite(diagonal[i])) return false;
      scale_[s_.offset(b) + i] = 1.0 / std::sqrt(diagonal[i]);
    }
  }
  const BlockSymmetricMatrix scaled = Scaled();
  return factor_->Factorize(scaled).positive_definite;
}

double ReducedSystem::Promised(const Eigen::VectorXd& dx) const {
  return 0.5 * (-full_gradient_.dot(dx) + damping_1_ * dx.cwiseAbs2().dot(full_diagonal_));
}

void ReducedSystem::Factor() {
  const Eigen::Index n = s_.rows();
  condition_1_ = 1.0;
  if (n == 0) return;
  scale_.resize(n);
  const ParameterLayout& layout = problem_.layout;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    const auto diagonal = s_.Block(static_cast<int>(b), static_cast<int>(b)).diagonal();
    for (int i = 0; i < layout.blocks[b].size; ++i) {
      const int row = layout.blocks[b].offset + i;
      // A diagonal that elimination reduced to rounding belongs to a parameter of its own null
      // direction.
      if (!(diagonal[i] > 1e-14 * full_diagonal_[row]) || !std::isfinite(diagonal[i])) {
        ThrowUndetermined(Eigen::VectorXd::Unit(n, row));
      }
      scale_[row] = 1.0 / std::sqrt(diagonal[i]);
    }
  }
  BlockSymmetricMatrix scaled = Scaled();
  if (!factor_->Factorize(scaled).positive_definite) {
    // Lift the null space a little to find the direction that has none.
    for (int b = 0; b < scaled.block_count(); ++b) {
      scaled.Block(b, b).diagonal().array() += 1e-9;
    }
    if (!factor_->Factorize(scaled).positive_definite) {
      ThrowUndetermined(Eigen::VectorXd::Ones(n));
    }
    ThrowUndetermined(factor_->SmallestEigenpair().vector);
  }
  const BlockCholesky::EigenPair least = factor_->SmallestEigenpair();
  if (!(least.value > kLeastEigenvalue_1)) ThrowUndetermined(least.vector);
  condition_1_ = factor_->ConditionEstimate(scaled);
}

Eigen::MatrixXd ReducedSystem::SolveFor(const Eigen::Ref<const Eigen::MatrixXd>& b) const {
  Eigen::MatrixXd x = scale_.asDiagonal() * b;
  factor_->Solve(x);
  return scale_.asDiagonal() * x;
}

Eigen::VectorXd ReducedSystem::Step() const {
  if (s_.rows() == 0) return {};
  return -SolveFor(right_side_);
}

double ReducedSystem::RemainingStep() const {
  double square = point_step_square_1_;
  if (s_.rows() > 0) square += right_side_.dot(SolveFor(right_side_).col(0));
  return std::sqrt(std::max(0.0, square));
}

BlockSymmetricMatrix ReducedSystem::SelectedInverse() const {
  BlockSymmetricMatrix inverse = factor_->SelectedInverse();
  for (int j = 0; j < inverse.block_count(); ++j) {
    for (const int i : inverse.RowsOfColumn(j)) {
      inverse.Block(i, j) = scale_.segment(inverse.offset(i), inverse.size(i)).asDiagonal() *
                            inverse.Block(i, j) *
                            scale_.segment(inverse.offset(j), inverse.size(j)).asDiagonal();
    }
  }
  return inverse;
}

}  // namespace sarblock
