// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "quadratic_model.h"
#include <Eigen/Eigenvalues>
#include <glog/logging.h>

namespace sarblock {
namespace {

/// Eigenvalues below this part of the largest are rounding: the observations say nothing there.
constexpr double kNothing_1 = 1e-10;

/// -2 times the logarithm of the restricted likelihood of steps with one variance q, and what the
/// steps leave of v'Pv (docs/theory/selection.md, eqs. 9 and 10).
struct StepLikelihood {
  Eigen::ArrayXd information;  ///< eigenvalues of M
  Eigen::ArrayXd square;       ///< of the gradient's parts along its eigenvectors
  double without_1 = 0.0;      ///< v'Pv with no step
  double redundancy_1 = 0.0;

  [[nodiscard]] double Left(double q) const {
    return without_1 - (square / (information + 1.0 / q)).sum();
  }
  [[nodiscard]] double LogDeterminant(double q) const { return (1.0 + q * information).log().sum(); }
  [[nodiscard]] double operator()(double log_q) const {
    const double q = std::exp(log_q);
    const double left_1 = std::max(Left(q), 1e-10 * redundancy_1);
    return redundancy_1 * std::log(left_1) + LogDeterminant(q);
  }
};

/// The most likely logarithm of q: a grid of factors of two, since there may be several minima,
/// then golden sections.
double MostLikely(const StepLikelihood& likelihood) {
  // From steps that show nowhere to steps whose prior says nothing.
  const double largest = likelihood.information.maxCoeff();
  const double first = std::log(1e-4 / largest), last = std::log(1e12 / largest);
  constexpr double kStep = 0.693;
  double best = first;
  for (double at = first; at <= last; at += kStep) {
    if (likelihood(at) < likelihood(best)) best = at;
  }
  double low = best - kStep, high = best + kStep;
  constexpr double kGolden_1 = 0.6180339887498949;
  while (high - low > 1e-4) {
    const double a = high - kGolden_1 * (high - low), b = low + kGolden_1 * (high - low);
    (likelihood(a) < likelihood(b) ? high : low) = likelihood(a) < likelihood(b) ? b : a;
  }
  return 0.5 * (low + high);
}

}  // namespace

void QuadraticModel::SetSteps(const WalkColumns& walk, double variance_m2) {
  for (std::size_t i = 0; i < walk.steps.size(); ++i) {
    const int c = walk.steps[i];
    const double weight = 1.0 / (variance_m2 * walk.closer_1[i]);
    data_.s(c, c) += weight - data_.prior_weight[c];
    s_(c, c) += weight - data_.prior_weight[c];
    data_.full_diagonal[c] += weight - data_.prior_weight[c];
    data_.prior_weight[c] = weight;
  }
}

CandidateFigures QuadraticModel::Walk(const WalkColumns& walk,
                                      const std::vector<int>& out,
                                      const std::vector<int>& below) const {
  const std::vector<int> in = walk.All();
  const std::vector<int> base = ActiveBut({&out, &in, &below});
  std::vector<int> all = base;
  // `below` and `out` may be the same columns.
  for (const std::vector<int>* set : {&in, &out, &below}) {
    for (const int c : *set) {
      if (std::find(all.begin(), all.end(), c) == all.end()) all.push_back(c);
    }
  }
  const auto places_of = [&all](const std::vector<int>& columns) {
    std::vector<int> places;
    for (const int c : columns) {
      places.push_back(static_cast<int>(std::find(all.begin(), all.end(), c) - all.begin()));
    }
    return places;
  };
  QuadraticModel small = Reduced(all);
  const std::vector<int> steps = places_of(walk.steps), start = places_of(walk.start);
  for (const int c : steps) {  // free
    small.data_.s(c, c) -= small.data_.prior_weight[c];
    small.data_.full_diagonal[c] -= small.data_.prior_weight[c];
    small.data_.prior_weight[c] = 0.0;
  }
  CandidateFigures figures;
  figures.columns = static_cast<int>(in.size()) - static_cast<int>(below.size());
  figures.condition_1 = std::numeric_limits<double>::infinity();
  figures.posterior_prior_1 = std::numeric_limits<double>::quiet_NaN();
  std::vector<int> model = places_of(base);
  if (!small.Reset(model)) return figures;
  const CandidateFigures less = small.Score(places_of(out)), poor = small.Score(places_of(below));
  const double base_1 = small.omega_1_, base_redundancy_1 = small.redundancy_1_;

  model.insert(model.end(), start.begin(), start.end());
  if (!small.Reset(model)) return figures;
  const auto k = static_cast<Eigen::Index>(steps.size());
  const Eigen::VectorXd root =
      Eigen::Map<const Eigen::VectorXd>(walk.closer_1.data(), k).cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      root.asDiagonal() * Eigen::MatrixXd(small.s_(steps, steps)) * root.asDiagonal());
  const double largest = k > 0 ? eigen.eigenvalues()[k - 1] : 0.0;
  if (!(largest > 0.0)) return figures;
  StepLikelihood likelihood;
  likelihood.information = eigen.eigenvalues().cwiseMax(0.0).array();
  likelihood.square = (eigen.eigenvectors().transpose() * root.cwiseProduct(small.b_(steps)))
                          .array()
                          .square();
  likelihood.without_1 = small.omega_1_;
  likelihood.redundancy_1 = small.redundancy_1_;
  const double q = std::exp(MostLikely(likelihood));
  figures.step_variance_m2 = q;

  // The space of the walk, steps free, against the polynomial: exact where there is no walk.
  int free = static_cast<int>(start.size());
  double free_1 = small.omega_1_;
  for (Eigen::Index i = 0; i < k; ++i) {
    if (likelihood.information[i] <= kNothing_1 * largest) continue;
    ++free;
    free_1 -= likelihood.square[i] / likelihood.information[i];
  }
  const int added = free - static_cast<int>(below.size());
  const double left = base_redundancy_1 - free;
  if (added <= 0 || !(left > 0.0)) return figures;
  const double below_1 = base_1 - (below.empty() ? 0.0 : poor.statistic_1);
  figures.statistic_1 = std::max(0.0, below_1 - free_1);
  figures.f_1 = (figures.statistic_1 / added) / (std::max(free_1, 1e-10 * left) / left);
  figures.probability_1 = FisherTailProbability(figures.f_1, added, left);

  small.SetSteps({start, steps, walk.closer_1}, q);
  model.resize(base.size());
  if (!small.Reset(model)) return figures;
  const std::vector<int> places = places_of(in);
  const Eigen::VectorXd scale = small.data_.full_diagonal(places).cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return figures;
  figures.condition_1 = ConditionOf(
      scale.asDiagonal() * Eigen::MatrixXd(small.s_(places, places)) * scale.asDiagonal());
  const double out_1 = base_1 - (out.empty() ? 0.0 : less.statistic_1);
  const double before = base_redundancy_1 - small.Takes(places_of(out));
  const double floor_1 = 1e-10 * left;
  figures.penalty_1 = small.data_.log_count(start).sum() + likelihood.LogDeterminant(q) +
                      std::log(static_cast<double>(k)) - (out.empty() ? 0.0 : less.penalty_1);
  figures.delta_bic_1 = before * std::log(std::max(likelihood.Left(q), floor_1) /
                                          std::max(out_1, floor_1)) +
                        figures.penalty_1;
  figures.regular = std::isfinite(figures.condition_1);
  return figures;
}

}  // namespace sarblock
