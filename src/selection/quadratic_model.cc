// SPDX-License-Identifier: Apache-2.0
#include "quadratic_model.h"

#include "sarblock/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Cholesky>
#include <glog/logging.h>

namespace sarblock {
namespace {

Eigen::MatrixXd Part(const Eigen::MatrixXd& s,
                     const std::vector<int>& rows,
                     const std::vector<int>& columns) {
  return s(rows, columns);
}

std::vector<int> Joined(std::initializer_list<const std::vector<int>*> sets) {
  std::vector<int> all;
  for (const std::vector<int>* set : sets) all.insert(all.end(), set->begin(), set->end());
  return all;
}

/// begin, begin + 1, ...
std::vector<int> Places(std::size_t begin, std::size_t count) {
  std::vector<int> list(count);
  std::iota(list.begin(), list.end(), static_cast<int>(begin));
  return list;
}

/// Least eigenvalue by inverse iteration on a factor, never below the true one but for rounding.
double LeastEigenvalue(const Eigen::LLT<Eigen::MatrixXd>& factor) {
  const Eigen::Index n = factor.rows();
  // A start that no symmetry of a problem is orthogonal to.
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = 1.0 + 0.37 * std::sin(1.7 * static_cast<double>(i));
  v.normalize();
  double value = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 50; ++step) {
    Eigen::VectorXd next = factor.solve(v);
    const double now = 1.0 / next.norm();
    v = next.normalized();
    const bool settled = std::abs(now - value) <= 1e-3 * now;
    value = now;
    if (settled) break;
  }
  return value;
}

}  // namespace

double ConditionOf(const Eigen::MatrixXd& scaled) {
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return 1.0 / LeastEigenvalue(factor);
}

QuadraticModel::QuadraticModel(Data data) : data_(std::move(data)) {
  CHECK(Reset({})) << "an empty model is never singular";
}

QuadraticModel QuadraticModel::Reduced(const std::vector<int>& columns) const {
  return QuadraticModel({Part(data_.s, columns, columns),
                         data_.b(columns),
                         data_.constant_1,
                         data_.full_diagonal(columns),
                         data_.prior_weight(columns),
                         data_.log_count(columns),
                         data_.redundancy_1});
}

std::vector<int> QuadraticModel::ActiveBut(
    std::initializer_list<const std::vector<int>*> sets) const {
  std::vector<int> out;
  for (const int c : active_) {
    const auto holds = [c](const std::vector<int>* set) {
      return std::find(set->begin(), set->end(), c) != set->end();
    };
    if (std::none_of(sets.begin(), sets.end(), holds)) out.push_back(c);
  }
  return out;
}

double QuadraticModel::Takes(const std::vector<int>& columns) const {
  // A prior is an observation of its own.
  double takes = 0.0;
  for (const int c : columns) takes += data_.prior_weight[c] > 0.0 ? 0.0 : 1.0;
  return takes;
}

bool QuadraticModel::Reset(const std::vector<int>& active) {
  active_ = active;
  s_ = data_.s;
  b_ = data_.b;
  omega_1_ = data_.constant_1;
  redundancy_1_ = data_.redundancy_1 - Takes(active);
  if (active.empty()) return true;
  Eigen::MatrixXd saa = Part(s_, active, active);
  const Eigen::VectorXd scale = saa.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  saa = scale.asDiagonal() * saa * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(saa);
  if (factor.info() != Eigen::Success) return false;
  const Eigen::MatrixXd y =
      factor.matrixL().solve(Eigen::MatrixXd(scale.asDiagonal() * s_(active, Eigen::all)));
  const Eigen::VectorXd z =
      factor.matrixL().solve(Eigen::VectorXd(scale.asDiagonal() * b_(active)));
  s_.noalias() -= y.transpose() * y;
  b_ -= y.transpose() * z;
  omega_1_ -= z.squaredNorm();
  return true;
}

void QuadraticModel::Add(const std::vector<int>& columns) {
  const Eigen::LLT<Eigen::MatrixXd> factor(Part(s_, columns, columns));
  CHECK(factor.info() == Eigen::Success) << "columns that are not determined were added";
  const Eigen::MatrixXd y = factor.matrixL().solve(Eigen::MatrixXd(s_(columns, Eigen::all)));
  const Eigen::VectorXd z = factor.matrixL().solve(Eigen::VectorXd(b_(columns)));
  s_.noalias() -= y.transpose() * y;
  b_ -= y.transpose() * z;
  omega_1_ -= z.squaredNorm();
  redundancy_1_ -= Takes(columns);
  active_.insert(active_.end(), columns.begin(), columns.end());
}

CandidateFigures QuadraticModel::Test(const std::vector<int>& columns,
                                      const Eigen::MatrixXd& m,
                                      const Eigen::VectorXd& g,
                                      double without_1,
                                      double redundancy_1) const {
  CandidateFigures out;
  const auto k = static_cast<double>(columns.size());
  out.columns = static_cast<int>(columns.size());
  out.condition_1 = std::numeric_limits<double>::infinity();
  out.posterior_prior_1 = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd scale = data_.full_diagonal(columns).cwiseSqrt().cwiseInverse();
  if (columns.empty() || !scale.allFinite()) return out;
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * m * scale.asDiagonal());
  if (factor.info() != Eigen::Success) return out;
  out.condition_1 = 1.0 / LeastEigenvalue(factor);
  const Eigen::VectorXd scaled = scale.asDiagonal() * g;
  out.statistic_1 = factor.matrixL().solve(scaled).squaredNorm();

  const Eigen::VectorXd prior = data_.prior_weight(columns);
  if (prior.minCoeff() > 0.0) {
    // log det of information over prior information: the exact penalty where a prior is proper.
    const double log_det =
        2.0 * factor.matrixLLT().diagonal().array().log().sum() - 2.0 * scale.array().log().sum();
    out.penalty_1 = log_det - prior.array().log().sum();
    out.posterior_prior_1 = std::exp(-0.5 * out.penalty_1 / k);
  } else {
    out.penalty_1 = data_.log_count(columns).sum();
  }
  const double left = redundancy_1 - Takes(columns);
  if (!(left > 0.0)) return out;
  const double with_1 = std::max(without_1 - out.statistic_1, kLeastVariance_1 * left);
  out.f_1 = (out.statistic_1 / k) / (with_1 / left);
  out.probability_1 = FisherTailProbability(out.f_1, k, left);
  out.delta_bic_1 = redundancy_1 * std::log(with_1 / std::max(without_1, kLeastVariance_1 * left)) +
                    out.penalty_1;
  out.regular = true;
  return out;
}

double QuadraticModel::Condition(const std::vector<int>& columns) const {
  if (columns.empty()) return 1.0;
  const Eigen::VectorXd scale = data_.full_diagonal(columns).cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::numeric_limits<double>::infinity();
  return ConditionOf(scale.asDiagonal() * Part(data_.s, columns, columns) * scale.asDiagonal());
}

CandidateFigures QuadraticModel::Score(const std::vector<int>& columns) const {
  return Test(columns, Part(s_, columns, columns), b_(columns), omega_1_, redundancy_1_);
}

Eigen::MatrixXd QuadraticModel::Covariance() const {
  const auto n = static_cast<Eigen::Index>(active_.size());
  if (n == 0) return {};
  const Eigen::MatrixXd saa = Part(data_.s, active_, active_);
  const Eigen::VectorXd scale = saa.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * saa * scale.asDiagonal());
  CHECK(factor.info() == Eigen::Success) << "the model is singular";
  return scale.asDiagonal() * factor.solve(Eigen::MatrixXd::Identity(n, n)) * scale.asDiagonal();
}

CandidateFigures QuadraticModel::Wald(const std::vector<int>& columns,
                                      const Eigen::MatrixXd& covariance) const {
  std::vector<int> places;
  for (const int c : columns) {
    const auto found = std::find(active_.begin(), active_.end(), c);
    CHECK(found != active_.end()) << "a column that is not active";
    places.push_back(static_cast<int>(found - active_.begin()));
  }
  const Eigen::VectorXd x = covariance(places, Eigen::all) * data_.b(active_);
  const Eigen::MatrixXd ckk = covariance(places, places);
  const Eigen::VectorXd scale = ckk.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * ckk * scale.asDiagonal());
  const Eigen::Index k = ckk.rows();
  const Eigen::MatrixXd m =
      scale.asDiagonal() * factor.solve(Eigen::MatrixXd::Identity(k, k)) * scale.asDiagonal();
  const Eigen::VectorXd g = m * x;
  return Test(columns, m, g, omega_1_ + g.dot(x), redundancy_1_ + Takes(columns));
}

CandidateFigures QuadraticModel::Exchange(const std::vector<int>& out,
                                          const std::vector<int>& in) const {
  // The few columns that matter as a model of their own.
  const std::vector<int> base = ActiveBut({&out, &in});
  QuadraticModel small = Reduced(Joined({&base, &out, &in}));
  CandidateFigures figures;
  figures.condition_1 = std::numeric_limits<double>::infinity();
  if (!small.Reset(Places(0, base.size()))) return figures;
  const CandidateFigures less = small.Score(Places(base.size(), out.size()));
  CandidateFigures more = small.Score(Places(base.size() + out.size(), in.size()));
  const int added = static_cast<int>(in.size()) - static_cast<int>(out.size());
  if (!more.regular || added <= 0) return more;
  // The larger space against the smaller one.
  const double out_1 = small.square_sum() - (out.empty() ? 0.0 : less.statistic_1);
  const double in_1 = small.square_sum() - more.statistic_1;
  const double left = small.redundancy() - Takes(in);
  const double before = small.redundancy() - Takes(out);
  const double floor_1 = kLeastVariance_1 * left;
  more.columns = added;
  more.statistic_1 = std::max(0.0, out_1 - in_1);
  more.f_1 = (more.statistic_1 / added) / (std::max(in_1, floor_1) / left);
  more.probability_1 = FisherTailProbability(more.f_1, added, left);
  more.penalty_1 -= out.empty() ? 0.0 : less.penalty_1;
  more.delta_bic_1 =
      before * std::log(std::max(in_1, floor_1) / std::max(out_1, floor_1)) + more.penalty_1;
  return more;
}

}  // namespace sarblock
