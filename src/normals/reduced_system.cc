// SPDX-License-Identifier: Apache-2.0
#include "reduced_system.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/parallel.h"
#include "point_terms.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerPartial = 128;
/// Where points take more than all but this part of what a correction's equations say, S is formed
/// by what they leave, not as a difference that has lost more than a digit.
constexpr double kLeastLeft_1 = 1.0 / 16.0;
/// Partial sums are limited to this much memory; their number depends on the block alone, never on
/// the threads.
constexpr std::size_t kPartialBytes = std::size_t{256} << 20;
constexpr std::size_t kMostPartials = 16;

/// Equations of a set of points by the corrections before elimination.
struct Unreduced {
  explicit Unreduced(const BlockPattern& pattern)
      : gradient(Eigen::VectorXd::Zero(pattern.rows())), diagonal(gradient) {}
  Eigen::VectorXd gradient;  // J_c' e
  Eigen::VectorXd diagonal;  // of J_c' J_c
};

/// What one range of points adds.
struct Partial {
  explicit Partial(const BlockSymmetricMatrix& pattern)
      : s(pattern.pattern()),
        right_side(Eigen::VectorXd::Zero(pattern.rows())),
        exact(*pattern.pattern()),
        subtracted(*pattern.pattern()) {}
  BlockSymmetricMatrix s;
  Eigen::VectorXd right_side;  // but for the gradient of the subtracted
  Unreduced exact;             // points added by what elimination leaves
  Unreduced subtracted;        // points added as a difference
  bool any_subtracted = false;
  std::vector<WeakPoint> weak;
  double cost = 0.0, point_step_square = 0.0, point_gradient_square = 0.0;
  int not_evaluated = 0, beyond_path = 0;
};

/// Scratch of one range of points.
struct PointScratch {
  PointFactor factor;
  PointTerms terms;
};

void AddLooks(const PointFactor& factor, const ParameterLayout& layout, Unreduced* out) {
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    const double* range = look.row[0].data();
    const double* doppler = look.row[1].data();
    for (int b = 0; b < look.columns.block_count; ++b) {
      const ParameterBlock& block =
          layout.blocks[static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)])];
      Kernels().AddLook(block.size,
                        range,
                        doppler,
                        look.error_1.data(),
                        out->diagonal.data() + block.offset,
                        out->gradient.data() + block.offset);
      range += block.size;
      doppler += block.size;
    }
  }
}

/// J_c' J_c of each look's own blocks.
void AddSquaresOfLooks(const PointFactor& factor,
                       const ParameterLayout& layout,
                       BlockSymmetricMatrix* s) {
  constexpr std::size_t kStride = ParameterLayout::kMaxLocalColumns;
  const BlockPattern& pattern = *s->pattern();
  double* values = s->values().data();
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    int first = 0;
    for (int b = 0; b < look.columns.block_count; ++b) {
      const int id = look.columns.block[static_cast<std::size_t>(b)];
      const int size = layout.blocks[static_cast<std::size_t>(id)].size;
      int other = 0;
      for (int b2 = 0; b2 < look.columns.block_count; ++b2) {
        const int id2 = look.columns.block[static_cast<std::size_t>(b2)];
        const int size2 = layout.blocks[static_cast<std::size_t>(id2)].size;
        if (id2 <= id) {
          const std::size_t slot = id2 == id ? pattern.FirstSlot(id) : pattern.Slot(id, id2);
          Kernels().AddProducts(values + pattern.ValueBegin(slot),
                                size,
                                size2,
                                look.row[0].data() + first,
                                look.row[0].data() + other,
                                kStride,
                                2);
        }
        other += size2;
      }
      first += size;
    }
  }
}

/// right_side += sum_k c_k x_k over the blocks of a point, x_k rows of the width.
void AddRightSide(const PointColumns& columns,
                  const ParameterLayout& layout,
                  const double* x,
                  std::span<const double> c,
                  Eigen::VectorXd* right_side) {
  for (std::size_t j = 0; j < columns.blocks.size(); ++j) {
    const ParameterBlock& block = layout.blocks[static_cast<std::size_t>(columns.blocks[j])];
    Kernels().AddCombination(block.size,
                             x + columns.begin[j],
                             static_cast<std::size_t>(columns.width),
                             static_cast<int>(c.size()),
                             c.data(),
                             right_side->data() + block.offset);
  }
}

/// A point by what its elimination leaves: the square of N' J_c. No digit is lost to thin
/// intersections.
void AddRest(const ParameterLayout& layout, PointScratch* scratch, Partial* out) {
  PointTerms& terms = scratch->terms;
  FindColumns(layout, scratch->factor, &terms.columns);
  const PointBlocks blocks = FindBlocks(layout, *out->s.pattern(), &terms);
  TurnToRest(layout, scratch->factor, &terms);
  Kernels().AddSquare(blocks,
                      terms.rest.data(),
                      static_cast<std::size_t>(terms.columns.width),
                      static_cast<int>(terms.rest_e.size()),
                      1.0,
                      out->s.values().data());
  AddRightSide(terms.columns, layout, terms.rest.data(), terms.rest_e, &out->right_side);
}

/// J_c' J_c of a point, and the right side of J_c' J_c - T' T.
void AddUnreduced(const AdjustmentProblem& problem,
                  const Eigen::Vector3d& c,
                  PointScratch* scratch,
                  Partial* out) {
  PointColumns& columns = scratch->terms.columns;
  ProjectColumns(problem, scratch->factor, &columns);
  AddLooks(scratch->factor, problem.layout, &out->subtracted);
  AddSquaresOfLooks(scratch->factor, problem.layout, &out->s);
  const Eigen::Vector3d taken = -c;
  AddRightSide(columns,
               problem.layout,
               columns.t.data(),
               std::span<const double>(taken.data(), 3),
               &out->right_side);
  out->any_subtracted = true;
}

/// A point by J_c' J_c - T' T: three rows, however many looks. That subtraction costs digits where
/// points take most of what a correction's equations say.
void AddDifference(const AdjustmentProblem& problem,
                   const Eigen::Vector3d& c,
                   PointScratch* scratch,
                   Partial* out) {
  AddUnreduced(problem, c, scratch, out);
  PointTerms& terms = scratch->terms;
  const PointBlocks blocks = FindBlocks(problem.layout, *out->s.pattern(), &terms);
  Kernels().AddSquare(blocks,
                      terms.columns.t.data(),
                      static_cast<std::size_t>(terms.columns.width),
                      3,
                      -1.0,
                      out->s.values().data());
}

/// A point of the border by J_c' J_c and three rows T of the border.
void AddBordered(const AdjustmentProblem& problem,
                 const Eigen::Vector3d& c,
                 int row,
                 PointScratch* scratch,
                 Partial* out,
                 Eigen::MatrixXd* border) {
  AddUnreduced(problem, c, scratch, out);
  const PointColumns& columns = scratch->terms.columns;
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> t(
      columns.t.data(), 3, columns.width);
  for (std::size_t b = 0; b < columns.blocks.size(); ++b) {
    const ParameterBlock& block =
        problem.layout.blocks[static_cast<std::size_t>(columns.blocks[b])];
    border->block(row, block.offset, 3, block.size) = t.middleCols(columns.begin[b], block.size);
  }
}

/// Adds one point; one whose own equations are rank deficient is only named. `exact`: by what is
/// left of its equations, however many they are. `border_row`: its first row there, or -1.
void Add(const AdjustmentProblem& problem,
         const BlockState& state,
         const Weighting& weighting,
         double damping_1,
         bool exact,
         std::size_t point,
         int border_row,
         PointScratch* scratch,
         Partial* out,
         Eigen::MatrixXd* border) {
  PointFactor& factor = scratch->factor;
  scratch->terms.columns.t.clear();
  FactorPoint(problem, state, weighting, damping_1, point, &factor);
  out->cost += factor.cost_1;
  out->not_evaluated += factor.looks_not_evaluated;
  out->beyond_path += factor.looks_beyond_path;
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (!(factor.square_1[k] > 0.0)) continue;
    const double g = factor.gradient[k];
    out->point_gradient_square = std::max(out->point_gradient_square, g * g / factor.square_1[k]);
  }
  if (damping_1 == 0.0 && !(factor.reciprocal_condition_1 >= kLeastPointCondition_1)) {
    AddLooks(factor, problem.layout, &out->exact);
    out->weak.push_back({static_cast<std::uint32_t>(point), factor.reciprocal_condition_1});
    return;
  }
  const Eigen::Vector3d c = Project(factor, factor.e);
  out->point_step_square += c.squaredNorm();
  if (border_row >= 0) {  // of hundreds of looks: it takes little of the equations of each
    AddBordered(problem, c, border_row, scratch, out, border);
    return;
  }
  // Up to three rows left are no more work than the three of T.
  if (damping_1 == 0.0 && (exact || factor.row_count <= 6)) {
    AddLooks(factor, problem.layout, &out->exact);
    AddRest(problem.layout, scratch, out);
  } else {
    AddDifference(problem, c, scratch, out);
  }
}

}  // namespace

ReducedSystem::ReducedSystem(const AdjustmentProblem& problem,
                             std::size_t most_kept_bytes,
                             ManyLooks many)
    : problem_(problem) {
  ReducedPattern found = FindPattern(problem, many == ManyLooks::kBorder);
  bordered_ = std::move(found.bordered);
  s_ = {std::move(found.pattern), {}};
  const std::size_t points = problem.block.points.size();
  const std::size_t bytes = KeptFactors::BytesFor(points, found.looks, found.columns);
  if (bytes <= most_kept_bytes) kept_bytes_ = bytes;
}

void ReducedSystem::Form(const BlockState& state,
                         const Weighting& weighting,
                         ProgressSink* progress,
                         double damping_1) {
  damping_1_ = damping_1;
  const std::size_t points = problem_.block.points.size();
  sarblock::Step(progress, "linearise", 0, points);
  const bool subtracted = Sum(state, weighting, damping_1 == 0.0 && exact_);
  if (damping_1 == 0.0 && subtracted && PointsTakeNearlyAll()) {
    exact_ = true;
    Sum(state, weighting, true);
  }
  sarblock::Step(progress, "linearise", points, points);
  AddPriors(state);
  if (damping_1 > 0.0) {
    for (std::size_t b = 0; b < problem_.layout.blocks.size(); ++b) {
      const ParameterBlock& block = problem_.layout.blocks[b];
      s_.sparse.Block(static_cast<int>(b), static_cast<int>(b)).diagonal() +=
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

bool ReducedSystem::Sum(const BlockState& state, const Weighting& weighting, bool exact) {
  const std::size_t points = problem_.block.points.size();
  BlockSymmetricMatrix& sparse = s_.sparse;
  const std::size_t bytes = 1 + sizeof(double) * sparse.values().size();
  const std::size_t partials = std::clamp<std::size_t>(
      std::min(kPartialBytes / bytes, points / kPointsPerPartial), 1, kMostPartials);
  std::vector<std::optional<Partial>> parts(partials);
  kept_.reset();
  const bool keep = kept_bytes_ > 0 && damping_1_ == 0.0 && weighting.loss == RobustLoss::kNone;
  if (keep) kept_.emplace(points, partials, kept_bytes_);
  const std::size_t per_part = (points + partials - 1) / partials;
  s_.border.setZero(bordered_.rows(), sparse.rows());
  ParallelForChunks(points, per_part, [&](std::size_t part, std::size_t begin, std::size_t end) {
    Partial& out = parts[part].emplace(sparse);
    PointScratch scratch;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem_.Solves(point)) continue;
      Add(problem_,
          state,
          weighting,
          damping_1_,
          exact,
          point,
          bordered_.RowOf(point),
          &scratch,
          &out,
          &s_.border);
      if (!keep) continue;
      PointColumns& columns = scratch.terms.columns;
      if (columns.t.empty()) ProjectColumns(problem_, scratch.factor, &columns);
      kept_->Keep(part, point, scratch.factor, columns);
    }
  });
  sparse.SetZero();
  right_side_.setZero(s_.rows());
  full_diagonal_.setZero(s_.rows());
  full_gradient_.setZero(s_.rows());
  weak_points_.clear();
  cost_1_ = gradient_1_ = point_step_square_1_ = 0.0;
  looks_not_evaluated_ = looks_beyond_path_ = 0;
  bool subtracted = false;
  for (const std::optional<Partial>& part : parts) {
    if (!part) continue;
    const std::span<double> sum = sparse.values();
    const std::span<const double> add = part->s.values();
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += add[i];
    right_side_ += part->right_side + part->subtracted.gradient;
    full_diagonal_ += part->exact.diagonal + part->subtracted.diagonal;
    full_gradient_ += part->exact.gradient + part->subtracted.gradient;
    weak_points_.insert(weak_points_.end(), part->weak.begin(), part->weak.end());
    cost_1_ += part->cost;
    point_step_square_1_ += part->point_step_square;
    gradient_1_ = std::max(gradient_1_, std::sqrt(part->point_gradient_square));
    looks_not_evaluated_ += part->not_evaluated;
    looks_beyond_path_ += part->beyond_path;
    subtracted |= part->any_subtracted;
  }
  return subtracted;
}

bool ReducedSystem::PointsTakeNearlyAll() const {
  return (s_.Diagonal().array() < kLeastLeft_1 * full_diagonal_.array()).any();
}

void ReducedSystem::AddPriors(const BlockState& state) {
  const ParameterLayout& layout = problem_.layout;
  for (const HeldParameter& held : problem_.held) {
    const Eigen::Index row = held.parameter;
    const double weight = full_diagonal_[row];  // as much again as all its observations
    const double off = state.corrections[row] - held.value;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
      const ParameterBlock& block = layout.blocks[b];
      if (held.parameter < block.offset || held.parameter >= block.offset + block.size) continue;
      const int i = held.parameter - block.offset;
      s_.sparse.Block(static_cast<int>(b), static_cast<int>(b))(i, i) += weight;
    }
    right_side_[row] += weight * off;
    full_diagonal_[row] += weight;
    full_gradient_[row] += weight * off;
    cost_1_ += 0.5 * weight * off * off;
  }
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    const ParameterBlock& block = layout.blocks[b];
    for (int i = 0; i < block.size; ++i) {
      const int row = block.offset + i;
      const Parameter& parameter = layout.parameters[static_cast<std::size_t>(row)];
      if (!parameter.has_own_prior()) continue;
      const double weight = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
      const double x = state.corrections[row] - parameter.prior_value;
      s_.sparse.Block(static_cast<int>(b), static_cast<int>(b))(i, i) += weight;
      right_side_[row] += weight * x;
      full_diagonal_[row] += weight;
      full_gradient_[row] += weight * x;
      cost_1_ += 0.5 * weight * x * x;
    }
  }
  for (const JointPriorTerm& prior : layout.joint_priors) {
    const Eigen::VectorXd x = layout.FromPrior(prior, state.corrections);
    const Eigen::VectorXd gradient = prior.information * x;
    const std::vector<int>& at = prior.parameters;
    const int offset = layout.blocks[static_cast<std::size_t>(prior.block)].offset;
    auto block = s_.sparse.Block(prior.block, prior.block);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const int row = at[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < x.size(); ++j) {
        block(row - offset, at[static_cast<std::size_t>(j)] - offset) += prior.information(i, j);
      }
      full_diagonal_[row] += prior.information(i, i);
    }
    right_side_(at) += gradient;
    full_gradient_(at) += gradient;
    cost_1_ += 0.5 * (prior.whitening * x).squaredNorm();
  }
}

BorderedMatrix ReducedSystem::Scaled() {
  BorderedMatrix scaled = s_.Scaled(scale_);
  if (!factor_) {
    std::vector<int> last;
    for (std::size_t b = 0; b < problem_.layout.blocks.size(); ++b) {
      if (problem_.layout.blocks[b].shared) last.push_back(static_cast<int>(b));
    }
    factor_.emplace(scaled.sparse, last);
  }
  return scaled;
}

BorderedMatrix ReducedSystem::FormScaled() {
  const Eigen::VectorXd diagonal = s_.Diagonal();
  scale_.resize(diagonal.size());
  for (Eigen::Index row = 0; row < diagonal.size(); ++row) {
    // A diagonal that elimination reduced to rounding belongs to a parameter of its own null
    // direction: scaled by what it was before, it stays as small as it is.
    const bool own = diagonal[row] > 1e-14 * full_diagonal_[row] && std::isfinite(diagonal[row]);
    const double unit = own ? diagonal[row] : full_diagonal_[row] > 0.0 ? full_diagonal_[row] : 1.0;
    scale_[row] = 1.0 / std::sqrt(unit);
  }
  return Scaled();
}

bool ReducedSystem::FactorDamped() {
  if (s_.rows() == 0) return true;
  const Eigen::VectorXd diagonal = s_.Diagonal();
  if (!(diagonal.minCoeff() > 0.0) || !diagonal.allFinite()) return false;
  scale_ = diagonal.cwiseSqrt().cwiseInverse();
  const BorderedMatrix scaled = Scaled();
  return factor_->Factorize(scaled);
}

double ReducedSystem::PredictedDecrease(const Eigen::VectorXd& dx) const {
  return 0.5 * (-full_gradient_.dot(dx) + damping_1_ * dx.cwiseAbs2().dot(full_diagonal_));
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

double ReducedSystem::NewtonDecrement() const {
  double square = point_step_square_1_;
  if (s_.rows() > 0) square += right_side_.dot(SolveFor(right_side_).col(0));
  return std::sqrt(std::max(0.0, square));
}

CorrectionCovariance ReducedSystem::SelectedInverse() const {
  BorderedInverse inverse = factor_->SelectedInverse();
  BlockSymmetricMatrix& blocks = inverse.blocks;
  ScaleBlocks(scale_, &blocks);
  return {std::move(blocks), bordered_, inverse.border * scale_.asDiagonal()};
}

}  // namespace sarblock
