// SPDX-License-Identifier: Apache-2.0
#include "reduced_system.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "core/memory.h"
#include "core/ranks.h"
#include "core/threads.h"
#include "pieces.h"

namespace sarblock {
namespace {

/// Where points take more than all but this part of what a correction's equations say, S is formed
/// by what they leave, not as a difference that has lost more than a digit.
constexpr double kMinRemainingPart = 1.0 / 16.0;
/// Columns of S are added up side by side, so many values at a time at least.
constexpr std::size_t kValuesPerStripe = std::size_t{1} << 14;

}  // namespace

ReducedSystem::ReducedSystem(const AdjustmentProblem& problem,
                             std::size_t most_kept_bytes,
                             ManyLooks many)
    : problem_(problem) {
  ReducedPattern found = FindPattern(problem, many == ManyLooks::kBorder);
  bordered_ = std::move(found.bordered);
  pattern_ = std::move(found.pattern);
  border_pattern_ = std::move(found.border);
  pieces_ = PointPieces(problem, *pattern_, bordered_);
  const std::size_t points = problem.block.points.size();
  bytes_of_factors_ = KeptFactors::BytesFor(points, found.looks, found.columns);
  KeepFactors(most_kept_bytes);
}

void ReducedSystem::KeepFactors(std::size_t most_bytes) {
  kept_bytes_ = bytes_of_factors_ <= most_bytes ? bytes_of_factors_ : 0;
}

void ReducedSystem::Form(const BlockState& state,
                         const Weighting& weighting,
                         ProgressSink* progress,
                         double damping) {
  damping_ = damping;
  weight_change_ = 0.0;  // of both sums: the second finds the weights of the first
  const std::size_t points = problem_.block.points.size();
  sarblock::Step(progress, "linearise", 0, points);
  if (Ranks* const ranks = RanksScope::Current(); ranks != nullptr) {
    const Eigen::VectorXd& x = state.corrections;
    ranks->RequireSame(std::as_bytes(std::span(x.data(), static_cast<std::size_t>(x.size()))));
  }
  const bool may_be_exact = damping == 0.0 && !weighting.curved;
  const bool subtracted = Sum(state, weighting, may_be_exact && exact_);
  if (may_be_exact && subtracted && PointsTakeNearlyAll()) {
    exact_ = true;
    Sum(state, weighting, true);
  }
  sarblock::Step(progress, "linearise", points, points);
  AddPriors(state);
  if (damping > 0.0) {
    for (std::size_t b = 0; b < problem_.layout.blocks.size(); ++b) {
      const ParameterBlock& block = problem_.layout.blocks[b];
      s_.sparse.Block(static_cast<int>(b), static_cast<int>(b)).diagonal() +=
          damping * full_diagonal_.segment(block.offset, block.size);
    }
  }
  for (Eigen::Index i = 0; i < full_gradient_.size(); ++i) {
    if (full_diagonal_[i] > 0.0) {
      gradient_ = std::max(gradient_, std::abs(full_gradient_[i]) / std::sqrt(full_diagonal_[i]));
    }
  }
}

void ReducedSystem::FormSettled(const Weighting& weighting,
                                double damping,
                                double settle_below,
                                BlockState* state,
                                ProgressSink* progress) {
  following_ = state;
  settle_below_ = settle_below;
  try {
    Form(*state, weighting, progress, damping);
  } catch (...) {
    following_ = nullptr;
    throw;
  }
  following_ = nullptr;
}

void ReducedSystem::ShareMoved(const std::vector<std::uint32_t>& moved) const {
  struct Place {
    std::uint64_t point;
    std::array<double, 3> displacement_m;
  };
  std::vector<Place> places;
  places.reserve(moved.size());
  for (const std::uint32_t point : moved) {
    const Eigen::Vector3d& at_m = following_->displacement_m[point];
    places.push_back({point, {at_m[0], at_m[1], at_m[2]}});
  }
  for (const Place& place : JoinedOfRanks(std::move(places))) {
    following_->displacement_m[place.point] =
        Eigen::Map<const Eigen::Vector3d>(place.displacement_m.data());
  }
}

bool ReducedSystem::Sum(const BlockState& state, const Weighting& weighting, bool exact) {
  const ResidentScope resident;
  if (s_.sparse.pattern() != pattern_) s_ = {BlockSymmetricMatrix(pattern_), Border()};
  BlockSymmetricMatrix& sparse = s_.sparse;
  sparse.SetZero();
  right_side_.setZero(s_.rows());
  full_diagonal_.setZero(s_.rows());
  full_gradient_.setZero(s_.rows());
  weak_points_.clear();
  cost_ = gradient_ = point_step_square_ = 0.0;
  looks_not_evaluated_ = looks_beyond_path_ = 0;
  first_not_evaluated_ = PointTotals::kNoPoint;
  kept_.reset();
  const bool keep = kept_bytes_ > 0 && damping_ == 0.0 && weighting.loss == RobustLoss::kNone &&
                    !weighting.curved;
  if (keep) kept_.emplace(problem_.block.points.size(), pieces_.size(), kept_bytes_);
  s_.border = Border(border_pattern_);
  PointEquations equations{.problem = problem_,
                           .state = state,
                           .weighting = weighting,
                           .bordered = bordered_,
                           .damping = damping_,
                           .exact = exact,
                           .following = following_,
                           .settle_below = settle_below_,
                           .border = &s_.border};
  const NormalSums sums{&sparse, &right_side_, &full_diagonal_, &full_gradient_};
  const auto columns = static_cast<std::size_t>(sparse.block_count());
  const std::size_t stripe = std::clamp<std::size_t>(
      columns * kValuesPerStripe / (1 + sparse.values().size()), 1, columns + 1);
  Pool<PieceScratch> pool;
  bool subtracted = false;
  std::vector<std::uint32_t> moved;
  std::vector<int> rank_of_piece;
  const int threads = ThreadsOfRanks();
  for (std::size_t first = 0; first < pieces_.size();) {
    const std::size_t end = pieces_.GroupEnd(first, threads);
    std::vector<PartialSum> parts(end - first);
    std::vector<PointTotals> totals(parts.size());
    const auto sum_piece = [&](std::size_t k, std::size_t, std::size_t) {
      const auto scratch = pool.Borrow();
      const PointPiece& piece = pieces_[first + k];
      parts[k].Take(piece, *sparse.pattern());
      parts[k].Begin(&*scratch);
      for (std::size_t place = piece.begin; place < piece.end; ++place) {
        const std::size_t point = pieces_.PointAt(place);
        if (!problem_.Solves(point)) continue;
        parts[k].Add(equations, point, &*scratch);
        if (!keep) continue;
        PointColumns& of_point = scratch->terms.columns;
        if (of_point.t.empty()) ProjectColumns(problem_, scratch->factor, &of_point);
        kept_->Keep(first + k, point, scratch->factor, of_point);
      }
      totals[k] = parts[k].totals();
    };
    ForChunksOfRanks(parts.size(), 1, {SharedArray::ByItem(&totals)}, sum_piece);
    for (const PartialSum& part : parts) {
      weak_points_.insert(weak_points_.end(), part.weak().begin(), part.weak().end());
      moved.insert(moved.end(), part.moved().begin(), part.moved().end());
    }
    const std::vector<int> ranks =
        SharePieces(pieces_, *sparse.pattern(), equations, first, &parts);
    rank_of_piece.insert(rank_of_piece.end(), ranks.begin(), ranks.end());
    ParallelForChunks(columns, stripe, [&](std::size_t, std::size_t begin, std::size_t last) {
      for (const PartialSum& part : parts) {
        part.AddColumns(static_cast<int>(begin), static_cast<int>(last), sums);
      }
    });
    for (const PointTotals& of_piece : totals) {
      cost_ += of_piece.cost;
      point_step_square_ += of_piece.step_square;
      gradient_ = std::max(gradient_, std::sqrt(of_piece.gradient_square));
      looks_not_evaluated_ += of_piece.not_evaluated;
      first_not_evaluated_ = std::min(first_not_evaluated_, of_piece.first_not_evaluated);
      looks_beyond_path_ += of_piece.beyond_path;
      weight_change_ = std::max(weight_change_, of_piece.weight_change);
      subtracted |= of_piece.any_subtracted;
    }
    first = end;
  }
  weak_points_ = JoinedOfRanks(std::move(weak_points_));
  if (following_ != nullptr && RanksScope::Current() != nullptr) ShareMoved(moved);
  if (kept_) kept_->Share(pieces_, rank_of_piece);
  std::sort(weak_points_.begin(), weak_points_.end(), [](const WeakPoint& a, const WeakPoint& b) {
    return a.point < b.point;
  });
  return subtracted;
}

bool ReducedSystem::PointsTakeNearlyAll() const {
  return (s_.Diagonal().array() < kMinRemainingPart * full_diagonal_.array()).any();
}

void ReducedSystem::AddStep(const BlockState& state, int block, int row) {
  const ParameterLayout& layout = problem_.layout;
  const Parameter& parameter = layout.parameters[static_cast<std::size_t>(row)];
  const double weight = 1.0 / (parameter.step_sigma * parameter.step_sigma);
  const double x = layout.StepOf(static_cast<std::size_t>(row), state.corrections);
  const std::array<int, 2> rows = {row, parameter.before};
  const std::array<int, 2> blocks = {block, block - 1};
  const std::array<double, 2> factors = {1.0, -parameter.carried};
  for (std::size_t i = 0; i < 2; ++i) {
    const int local = rows[i] - layout.blocks[static_cast<std::size_t>(blocks[i])].offset;
    s_.sparse.Block(blocks[i], blocks[i])(local, local) += weight * factors[i] * factors[i];
    right_side_[rows[i]] += weight * factors[i] * x;
    full_diagonal_[rows[i]] += weight * factors[i] * factors[i];
    full_gradient_[rows[i]] += weight * factors[i] * x;
  }
  const int to = row - layout.blocks[static_cast<std::size_t>(block)].offset;
  const int from = parameter.before - layout.blocks[static_cast<std::size_t>(block - 1)].offset;
  s_.sparse.Block(block, block - 1)(to, from) += weight * factors[1];
  cost_ += 0.5 * weight * x * x;
}

void ReducedSystem::AddPriors(const BlockState& state) {
  const ParameterLayout& layout = problem_.layout;
  for (const FixedParameter& fixed : problem_.fixed) {
    const Eigen::Index row = fixed.parameter;
    const double weight = full_diagonal_[row];  // as much again as all its observations
    const double off = state.corrections[row] - fixed.value;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
      const ParameterBlock& block = layout.blocks[b];
      if (fixed.parameter < block.offset || fixed.parameter >= block.offset + block.size) continue;
      const int i = fixed.parameter - block.offset;
      s_.sparse.Block(static_cast<int>(b), static_cast<int>(b))(i, i) += weight;
    }
    right_side_[row] += weight * off;
    full_diagonal_[row] += weight;
    full_gradient_[row] += weight * off;
    cost_ += 0.5 * weight * off * off;
  }
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    const ParameterBlock& block = layout.blocks[b];
    for (int i = 0; i < block.size; ++i) {
      const int row = block.offset + i;
      const Parameter& parameter = layout.parameters[static_cast<std::size_t>(row)];
      if (parameter.before >= 0) AddStep(state, static_cast<int>(b), row);
      if (!parameter.has_own_prior()) continue;
      const double weight = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
      const double x = state.corrections[row] - parameter.prior_value;
      s_.sparse.Block(static_cast<int>(b), static_cast<int>(b))(i, i) += weight;
      right_side_[row] += weight * x;
      full_diagonal_[row] += weight;
      full_gradient_[row] += weight * x;
      cost_ += 0.5 * weight * x * x;
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
    cost_ += 0.5 * (prior.whitening * x).squaredNorm();
  }
}

BorderedMatrix ReducedSystem::Scaled() {
  const ResidentScope resident;
  Analyse();
  return s_.Scaled(scale_);
}

void ReducedSystem::Analyse() {
  if (factor_) return;
  factor_.emplace(pattern_, SharedBlocks(problem_.layout));
}

SystemNeeds ReducedSystem::Needs(int threads) {
  SystemNeeds needs;
  if (rows() == 0) return needs;
  Analyse();
  needs.matrix = pattern_->ValueBegin(pattern_->slot_count());
  needs.border = border_pattern_->value_count();
  needs.partial_sums = pieces_.MaxDoubles(threads);
  needs.kept = kept_bytes_ / sizeof(double);
  needs.operations = pieces_.operations();
  needs.factor = factor_->Needs();
  // Z and K beside the factor of what is not in the border (linear/block_cholesky.h).
  const auto border_rows = static_cast<std::size_t>(bordered_.rows());
  needs.factor.factor += needs.border + border_rows * border_rows;
  const double m = bordered_.rows();
  needs.factor.operations += 0.5 * (border_pattern_->SquareOperations() + m * m * m / 3.0);
  return needs;
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
  if (rows() == 0) return true;
  const Eigen::VectorXd diagonal = s_.Diagonal();
  if (!(diagonal.minCoeff() > 0.0) || !diagonal.allFinite()) return false;
  scale_ = diagonal.cwiseSqrt().cwiseInverse();
  const BorderedMatrix scaled = Scaled();
  return factor_->Factorize(scaled);
}

double ReducedSystem::PredictedDecrease(const Eigen::VectorXd& dx) const {
  return 0.5 * (-full_gradient_.dot(dx) + damping_ * dx.cwiseAbs2().dot(full_diagonal_));
}

Eigen::MatrixXd ReducedSystem::SolveFor(const Eigen::Ref<const Eigen::MatrixXd>& b) const {
  Eigen::MatrixXd x = scale_.asDiagonal() * b;
  factor_->Solve(x);
  return scale_.asDiagonal() * x;
}

void ReducedSystem::SolveEach(std::span<Eigen::MatrixXd> sets) const {
  if (factor_->divided()) {
    for (Eigen::MatrixXd& set : sets) set = SolveFor(set);
    return;
  }
  ParallelForChunks(sets.size(), 1, [&](std::size_t k, std::size_t, std::size_t) {
    sets[k] = SolveFor(sets[k]);
  });
}

Eigen::VectorXd ReducedSystem::Step() const {
  if (rows() == 0) return {};
  return -SolveFor(right_side_);
}

double ReducedSystem::NewtonDecrement() const { return NewtonDecrement(Step()); }

double ReducedSystem::NewtonDecrement(const Eigen::VectorXd& step) const {
  double square = point_step_square_;
  if (rows() > 0) square -= right_side_.dot(step);
  return std::sqrt(std::max(0.0, square));
}

CorrectionCovariance ReducedSystem::SelectedInverse() const {
  const ResidentScope resident;
  BorderedInverse inverse = factor_->SelectedInverse();
  BlockSymmetricMatrix& blocks = inverse.blocks;
  ScaleBlocks(scale_, &blocks);
  return {std::move(blocks), bordered_, inverse.border.Scaled(scale_)};
}

}  // namespace sarblock
