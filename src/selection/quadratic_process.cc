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

/// -2 times the logarithm of the restricted likelihood of columns with one prior variance q, and
/// what they leave of v'Pv (docs/theory/selection.md, eq. 8a).
struct ProcessLikelihood {
  Eigen::ArrayXd information;  ///< eigenvalues of M
  Eigen::ArrayXd square;       ///< of the gradient's parts along its eigenvectors
  double without_1 = 0.0;      ///< v'Pv without the columns
  double redundancy_1 = 0.0;

  [[nodiscard]] double Left(double q) const {
    return without_1 - (square / (information + 1.0 / q)).sum();
  }
  [[nodiscard]] double LogDeterminant(double q) const {
    return (1.0 + q * information).log().sum();
  }
  [[nodiscard]] double operator()(double log_q) const {
    const double q = std::exp(log_q);
    const double left_1 = std::max(Left(q), kLeastVariance_1 * redundancy_1);
    return redundancy_1 * std::log(left_1) + LogDeterminant(q);
  }
};

/// The most likely logarithm of q: a grid of factors of two, since there may be several minima,
/// then golden sections.
double MostLikely(const ProcessLikelihood& likelihood) {
  // From coefficients that show nowhere to a prior that says nothing.
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

void QuadraticModel::SetPrior(const std::vector<int>& columns, double variance_1) {
  for (const int c : columns) {
    const double added = 1.0 / variance_1 - data_.prior_weight[c];
    data_.s(c, c) += added;
    s_(c, c) += added;
    data_.full_diagonal[c] += added;
    data_.prior_weight[c] = 1.0 / variance_1;
  }
}

CandidateFigures QuadraticModel::Process(const std::vector<int>& in,
                                         const std::vector<int>& out,
                                         const std::vector<int>& below) const {
  CandidateFigures figures;
  figures.columns = static_cast<int>(in.size()) - static_cast<int>(below.size());
  figures.condition_1 = std::numeric_limits<double>::infinity();
  figures.posterior_prior_1 = std::numeric_limits<double>::quiet_NaN();
  if (in.empty()) return figures;
  // What matters as a model of its own; the three sets may have columns in common.
  const std::vector<int> base = ActiveBut({&in, &out, &below});
  std::vector<int> all = base;
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
  const std::vector<int> places = places_of(in);
  small.SetPrior(places, std::numeric_limits<double>::infinity());
  if (!small.Reset(places_of(base))) return figures;
  const CandidateFigures less = small.Score(places_of(out)), poor = small.Score(places_of(below));
  const double without_1 = small.square_sum(), redundancy_1 = small.redundancy();

  const auto k = static_cast<Eigen::Index>(places.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(small.s_(places, places)));
  const double largest = eigen.eigenvalues()[k - 1];
  if (!(largest > 0.0)) return figures;
  ProcessLikelihood likelihood;
  likelihood.information = eigen.eigenvalues().cwiseMax(0.0).array();
  likelihood.square = (eigen.eigenvectors().transpose() * small.b_(places)).array().square();
  likelihood.without_1 = without_1;
  likelihood.redundancy_1 = redundancy_1;
  figures.variance_1 = std::exp(MostLikely(likelihood));

  // The space of the columns against `below`: an exact test of no variance (Wald 1947).
  int free = 0;
  double free_1 = without_1;
  for (Eigen::Index i = 0; i < k; ++i) {
    if (likelihood.information[i] <= kNothing_1 * largest) continue;
    ++free;
    free_1 -= likelihood.square[i] / likelihood.information[i];
  }
  const int added = free - static_cast<int>(below.size());
  const double left = redundancy_1 - free;
  if (added <= 0 || !(left > 0.0)) return figures;
  const double floor_1 = kLeastVariance_1 * left;
  const double below_1 = without_1 - (below.empty() ? 0.0 : poor.statistic_1);
  figures.statistic_1 = std::max(0.0, below_1 - free_1);
  figures.f_1 = (figures.statistic_1 / added) / (std::max(free_1, floor_1) / left);
  figures.probability_1 = FisherTailProbability(figures.f_1, added, left);

  small.SetPrior(places, figures.variance_1);
  const Eigen::VectorXd scale = small.data_.full_diagonal(places).cwiseSqrt().cwiseInverse();
  figures.condition_1 = ConditionOf(scale.asDiagonal() * Eigen::MatrixXd(small.s_(places, places)) *
                                    scale.asDiagonal());
  const double out_1 = without_1 - (out.empty() ? 0.0 : less.statistic_1);
  figures.penalty_1 = likelihood.LogDeterminant(figures.variance_1) +
                      std::log(static_cast<double>(k)) - (out.empty() ? 0.0 : less.penalty_1);
  figures.delta_bic_1 = (redundancy_1 - small.Takes(places_of(out))) *
                            std::log(std::max(likelihood.Left(figures.variance_1), floor_1) /
                                     std::max(out_1, floor_1)) +
                        figures.penalty_1;
  figures.regular = std::isfinite(figures.condition_1);
  return figures;
}

}  // namespace sarblock
