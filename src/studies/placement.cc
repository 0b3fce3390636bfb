// SPDX-License-Identifier: Apache-2.0
#include "placement.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <string>

#include "core/threads.h"
#include "linear/dense.h"
#include "model/problem.h"
#include "normals/reduced_system.h"
#include "quality/point_sweep.h"
#include "solve/rank.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sarblock {
namespace {

constexpr std::size_t kCovariancesPerChunk = 64;

/// G = cov + sigma, factored.
Eigen::LLT<Eigen::Matrix3d> Factored(const Eigen::Matrix3d& matrix_m2) {
  Eigen::LLT<Eigen::Matrix3d> factor(matrix_m2);
  if (factor.info() != Eigen::Success) {
    throw InputError("control", "needs a positive definite covariance");
  }
  return factor;
}

}  // namespace

BlockCovariance::BlockCovariance(const Block& block,
                                 const AdjustOptions& options,
                                 const std::vector<Eigen::Vector3d>& positions_m,
                                 const std::vector<PointStatus>& status) {
  const Block filled = FillMeasurements(block, positions_m);
  const CorrectionModel given = GivenCorrections(options);
  AdjustmentProblem problem(filled, given.groups, {}, given.priors);
  BlockState state;
  state.start_m = positions_m;
  state.displacement_m.assign(positions_m.size(), Eigen::Vector3d::Zero());
  state.corrections = Eigen::VectorXd::Zero(problem.layout.size());
  for (std::size_t point = 0; point < status.size(); ++point) {
    if (IsSolved(status[point])) {
      problem.point_status[point] = PointStatus::kPredicted;
      points_.push_back(static_cast<std::uint32_t>(point));
    } else {
      problem.LeaveOut(point, status[point], "");
    }
  }
  const auto n = static_cast<std::size_t>(problem.layout.size());
  if (n * (n + 3 * points_.size()) > kMaxNumbers) {
    throw InputError("placement",
                     "is for blocks whose corrections times points stay below " +
                         std::to_string(kMaxNumbers) + ", this one has " + std::to_string(n) +
                         " corrections and " + std::to_string(points_.size()) + " points");
  }
  UpdateWeights(state, &problem);
  ReducedSystem system(problem);
  system.Form(state, {}, nullptr);
  FactorRegular(&system);
  const auto size = static_cast<Eigen::Index>(n);
  if (size > 0) {
    c_ = system.SolveFor(Eigen::MatrixXd::Identity(size, size));
    c_ = 0.5 * (c_ + c_.transpose()).eval();
  }
  b_.resize(points_.size());
  y_.resize(size, 3 * static_cast<Eigen::Index>(points_.size()));
  ParallelForChunks(
      points_.size(), kCovariancesPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        PointFactor factor;
        PointColumns columns;
        for (std::size_t i = begin; i < end; ++i) {
          const Eigen::Matrix3d r_inverse =
              PointSensitivity(problem,
                               state,
                               points_[i],
                               &factor,
                               &columns,
                               y_.middleCols(3 * static_cast<Eigen::Index>(i), size > 0 ? 3 : 0));
          b_[i] = r_inverse * r_inverse.transpose();
        }
      });
}

Eigen::Matrix3d BlockCovariance::Point(std::size_t i) const {
  const Eigen::MatrixXd cy = c_ * Y(i);
  return b_[i] + Y(i).transpose() * cy;
}

Eigen::Matrix3d BlockCovariance::Between(std::size_t i, std::size_t j) const {
  const Eigen::MatrixXd cy = c_ * Y(j);
  return Y(i).transpose() * cy;
}

Eigen::Matrix3d BlockCovariance::Difference(std::size_t i, std::size_t j) const {
  const Eigen::MatrixXd d = Y(j) - Y(i);
  const Eigen::MatrixXd cd = c_ * d;
  return b_[i] + b_[j] + d.transpose() * cd;
}

void BlockCovariance::AddControl(std::size_t i, const Eigen::Matrix3d& sigma_m2) {
  const Eigen::MatrixXd cy = c_ * Y(i);
  const Eigen::Matrix3d q = b_[i] + Y(i).transpose() * cy;
  const auto g = Factored(q + sigma_m2);
  const Eigen::MatrixXd half = g.matrixL().solve(cy.transpose());  // 3 x n
  c_.noalias() -= half.transpose() * half;
  const auto own = Factored(b_[i] + sigma_m2);
  const Eigen::Matrix3d keep = own.solve(sigma_m2);  // (B + Sigma)^-1 Sigma
  b_[i] = (b_[i] * keep).eval();
  b_[i] = 0.5 * (b_[i] + b_[i].transpose()).eval();
  y_.middleCols(3 * static_cast<Eigen::Index>(i), 3) = (Y(i) * keep).eval();
}

void BlockCovariance::RemoveControl(std::size_t i, const Eigen::Matrix3d& sigma_m2) {
  const Eigen::Matrix3d free = Factored(sigma_m2 - b_[i]).solve(sigma_m2);  // Sigma^-1 N
  Eigen::Matrix3d n_m2 = sigma_m2 * free;
  n_m2 = 0.5 * (n_m2 + n_m2.transpose()).eval();
  b_[i] = n_m2 - sigma_m2;
  y_.middleCols(3 * static_cast<Eigen::Index>(i), 3) = (Y(i) * free).eval();
  const Eigen::MatrixXd cy = c_ * Y(i);
  const auto left = Factored(n_m2 - Y(i).transpose() * cy);
  const Eigen::MatrixXd half = left.matrixL().solve(cy.transpose());  // 3 x n
  c_.noalias() += half.transpose() * half;
}

double BlockCovariance::SquareFreedom(const std::vector<std::size_t>& chosen) const {
  const double mean = 3.0 * static_cast<double>(chosen.size());
  if (c_.rows() == 0 || chosen.empty()) return mean;
  const dense::Cholesky root(c_);
  if (!root.positive_definite()) {
    throw InputError("study", "the covariance of the corrections is not positive definite");
  }
  const Eigen::MatrixXd upper = root.L().transpose();
  Eigen::MatrixXd u(c_.rows(), 3 * static_cast<Eigen::Index>(chosen.size()));
  double own = 0.0;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Eigen::MatrixXd half = upper.triangularView<Eigen::Upper>() * Y(chosen[k]);
    const auto q = Factored(b_[chosen[k]] + half.transpose() * half);
    const Eigen::MatrixXd column = q.matrixL().solve(half.transpose()).transpose();
    own += (column.transpose() * column).squaredNorm();
    u.middleCols(3 * static_cast<Eigen::Index>(k), 3) = column;
  }
  const Eigen::MatrixXd square = u * u.transpose();
  return mean * mean / (mean + square.squaredNorm() - own);
}

double BlockCovariance::SumOfVariances(const std::vector<std::size_t>& chosen) const {
  double sum = 0.0;
  for (const std::size_t i : chosen) sum += Point(i).trace();
  return sum;
}

double BlockCovariance::SumOfVariances(const Pairs& pairs) const {
  double sum = 0.0;
  for (const auto& [a, b] : pairs) sum += Difference(a, b).trace();
  return sum;
}

std::vector<double> BlockCovariance::Gains(const std::vector<std::size_t>& candidates,
                                           const std::vector<Eigen::Matrix3d>& sigma_m2,
                                           const std::vector<std::size_t>& chosen) const {
  // sum_j tr(Q_jk G^-1 Q_kj) = tr(G^-1 Y_k' C M C Y_k), M = sum_j Y_j Y_j', but for j = k, whose
  // own B_k is added to Y_k' C Y_k.
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(c_.rows(), c_.rows());
  std::vector<bool> counted(points_.size());
  for (const std::size_t j : chosen) {
    m.noalias() += Y(j) * Y(j).transpose();
    counted[j] = true;
  }
  const Eigen::MatrixXd cmc = c_ * m * c_;
  std::vector<double> gains(candidates.size());
  const auto evaluate = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t k = candidates[i];
      const Eigen::MatrixXd cy = c_ * Y(k), mixed = cmc * Y(k);
      const Eigen::Matrix3d shared = Y(k).transpose() * cy;
      const Eigen::Matrix3d q = b_[k] + shared;
      Eigen::Matrix3d square = Y(k).transpose() * mixed;
      if (counted[k]) square += q * q - shared * shared;
      const Eigen::Matrix3d taken = Factored(q + sigma_m2[i]).solve(square);
      gains[i] = taken.trace();
    }
  };
  ParallelForChunks(candidates.size(), kCovariancesPerChunk, evaluate);
  return gains;
}

std::vector<double> BlockCovariance::Gains(const std::vector<std::size_t>& candidates,
                                           const std::vector<Eigen::Matrix3d>& sigma_m2,
                                           const Pairs& pairs) const {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(c_.rows(), c_.rows());
  std::vector<std::vector<std::size_t>> pairs_of(points_.size());
  for (std::size_t q = 0; q < pairs.size(); ++q) {
    const Eigen::MatrixXd d = Y(pairs[q].second) - Y(pairs[q].first);
    m.noalias() += d * d.transpose();
    pairs_of[pairs[q].first].push_back(q);
    pairs_of[pairs[q].second].push_back(q);
  }
  const Eigen::MatrixXd cmc = c_ * m * c_;
  std::vector<double> gains(candidates.size());
  const auto evaluate = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t k = candidates[i];
      const Eigen::MatrixXd cy = c_ * Y(k), mixed = cmc * Y(k);
      const Eigen::Matrix3d q = b_[k] + Y(k).transpose() * cy;
      Eigen::Matrix3d square = Y(k).transpose() * mixed;
      for (const std::size_t p : pairs_of[k]) {
        const Eigen::MatrixXd d = Y(pairs[p].second) - Y(pairs[p].first);
        const Eigen::Matrix3d shared = d.transpose() * cy;
        const Eigen::Matrix3d with_own = shared + (pairs[p].second == k ? 1.0 : -1.0) * b_[k];
        square += with_own.transpose() * with_own - shared.transpose() * shared;
      }
      const Eigen::Matrix3d taken = Factored(q + sigma_m2[i]).solve(square);
      gains[i] = taken.trace();
    }
  };
  ParallelForChunks(candidates.size(), kCovariancesPerChunk, evaluate);
  return gains;
}

std::vector<double> BlockCovariance::WorstAfter(const std::vector<std::size_t>& candidates,
                                                const std::vector<Eigen::Matrix3d>& sigma_m2,
                                                const std::vector<std::size_t>& chosen) const {
  Eigen::MatrixXd z(c_.rows(), 3 * static_cast<Eigen::Index>(chosen.size()));  // Y of `chosen`
  std::vector<double> now(chosen.size());
  for (std::size_t j = 0; j < chosen.size(); ++j) {
    z.middleCols(3 * static_cast<Eigen::Index>(j), 3) = Y(chosen[j]);
    now[j] = Point(chosen[j]).trace();
  }
  std::vector<double> worst(candidates.size());
  const auto evaluate = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t k = candidates[i];
      const Eigen::MatrixXd cy = c_ * Y(k);
      const Eigen::Matrix3d q = b_[k] + Y(k).transpose() * cy;
      const auto g = Factored(q + sigma_m2[i]);
      const Eigen::MatrixXd half = g.matrixL().solve(cy.transpose());  // 3 x n
      const Eigen::MatrixXd taken = half * z;                          // L^-1 Q_kj side by side
      double most = 0.0;
      for (std::size_t j = 0; j < chosen.size(); ++j) {
        const auto part = taken.middleCols(3 * static_cast<Eigen::Index>(j), 3);
        const double drop = chosen[j] == k ? Eigen::Matrix3d(g.matrixL().solve(q)).squaredNorm()
                                           : part.squaredNorm();
        most = std::max(most, now[j] - drop);
      }
      worst[i] = most;
    }
  };
  ParallelForChunks(candidates.size(), 8, evaluate);
  return worst;
}

const char* NameOf(PlacementCriterion criterion) {
  switch (criterion) {
    case PlacementCriterion::kWorstPoint:
      return "worst-point";
    case PlacementCriterion::kMeanDifferences:
      return "mean-differences";
    case PlacementCriterion::kMeanVariance:
      break;
  }
  return "mean-variance";
}

double ValueOf(const PlacementObjective& objective, const BlockCovariance& covariance) {
  switch (objective.criterion) {
    case PlacementCriterion::kWorstPoint: {
      double worst_m2 = 0.0;
      for (const std::size_t i : objective.points) {
        worst_m2 = std::max(worst_m2, covariance.Point(i).trace());
      }
      return worst_m2;
    }
    case PlacementCriterion::kMeanDifferences:
      return covariance.SumOfVariances(objective.pairs) /
             static_cast<double>(objective.pairs.size());
    case PlacementCriterion::kMeanVariance:
      break;
  }
  return covariance.SumOfVariances(objective.points) / static_cast<double>(objective.points.size());
}

std::vector<double> ValuesAfter(const PlacementObjective& objective,
                                const BlockCovariance& covariance,
                                const std::vector<std::size_t>& candidates,
                                const std::vector<Eigen::Matrix3d>& sigma_m2) {
  if (objective.criterion == PlacementCriterion::kWorstPoint) {
    return covariance.WorstAfter(candidates, sigma_m2, objective.points);
  }
  const bool differences = objective.criterion == PlacementCriterion::kMeanDifferences;
  const double now_m2 = ValueOf(objective, covariance);
  const auto count =
      static_cast<double>(differences ? objective.pairs.size() : objective.points.size());
  std::vector<double> values = differences
                                   ? covariance.Gains(candidates, sigma_m2, objective.pairs)
                                   : covariance.Gains(candidates, sigma_m2, objective.points);
  for (double& value : values) value = now_m2 - value / count;
  return values;
}

std::vector<PlacementStep> PlaceGreedily(const PlacementObjective& objective,
                                         std::vector<std::size_t> candidates,
                                         std::vector<Eigen::Matrix3d> sigma_m2,
                                         std::size_t count,
                                         BlockCovariance* covariance,
                                         const std::function<void(const PlacementStep&)>& after) {
  std::vector<PlacementStep> steps;
  while (steps.size() < count && !candidates.empty()) {
    const std::vector<double> values_m2 = ValuesAfter(objective, *covariance, candidates, sigma_m2);
    const auto best = std::min_element(values_m2.begin(), values_m2.end()) - values_m2.begin();
    steps.push_back({candidates[static_cast<std::size_t>(best)], *(values_m2.begin() + best)});
    covariance->AddControl(steps.back().point, *(sigma_m2.begin() + best));
    candidates.erase(candidates.begin() + best);
    sigma_m2.erase(sigma_m2.begin() + best);
    if (after) after(steps.back());
  }
  return steps;
}

std::vector<PlacementExchange> ExchangePlacement(const PlacementObjective& objective,
                                                 const std::vector<std::size_t>& candidates,
                                                 const std::vector<Eigen::Matrix3d>& sigma_m2,
                                                 std::vector<std::size_t>* chosen,
                                                 BlockCovariance* covariance,
                                                 const std::function<void()>& before) {
  // A smaller part than this is rounding, and could go back and forth for ever.
  constexpr double kMinDrop = 1e-9;
  std::vector<PlacementExchange> exchanges;
  const auto sigma_of = [&](std::size_t point) -> const Eigen::Matrix3d& {
    const auto at = std::find(candidates.begin(), candidates.end(), point);
    return sigma_m2[static_cast<std::size_t>(at - candidates.begin())];
  };
  std::size_t kept = 0;  // points in a row that nothing is better than
  for (std::size_t k = 0; kept < chosen->size(); k = (k + 1) % chosen->size()) {
    if (before) before();
    const std::size_t old = (*chosen)[k];
    covariance->RemoveControl(old, sigma_of(old));
    std::vector<std::size_t> open = {old};
    std::vector<Eigen::Matrix3d> open_m2 = {sigma_of(old)};
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (std::find(chosen->begin(), chosen->end(), candidates[i]) != chosen->end()) continue;
      open.push_back(candidates[i]);
      open_m2.push_back(sigma_m2[i]);
    }
    const std::vector<double> values_m2 = ValuesAfter(objective, *covariance, open, open_m2);
    auto best = std::min_element(values_m2.begin(), values_m2.end());
    if (!(*best < values_m2.front() * (1.0 - kMinDrop))) best = values_m2.begin();
    const auto at = static_cast<std::size_t>(best - values_m2.begin());
    covariance->AddControl(open[at], open_m2[at]);
    (*chosen)[k] = open[at];
    if (at == 0) {
      ++kept;
    } else {
      exchanges.push_back({old, open[at], *best});
      kept = 1;
    }
  }
  return exchanges;
}

}  // namespace sarblock
