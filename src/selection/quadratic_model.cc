// SPDX-License-Identifier: Apache-2.0
#include "quadratic_model.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "linear/dense.h"
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
double LeastEigenvalue(const dense::Cholesky& factor) {
  const Eigen::Index n = factor.rows();
  // A start that no symmetry of a problem is orthogonal to.
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = 1.0 + 0.37 * std::sin(1.7 * static_cast<double>(i));
  v.normalize();
  double value = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 50; ++step) {
    Eigen::VectorXd next = factor.Solve(v);
    const double now = 1.0 / next.norm();
    v = next.normalized();
    const bool settled = std::abs(now - value) <= 1e-3 * now;
    value = now;
    if (settled) break;
  }
  return value;
}

/// Eigenvalues below this part of the largest are rounding: the observations say nothing there.
constexpr double kNothing = 1e-10;

/// Sweeps over the variances of several sets, and the relative change that ends them: the standard
/// deviation of a variance is many times that.
constexpr int kMaxVarianceSweeps = 30;
constexpr double kSettledVariance = 0.02;
/// A variance q whose likelihood is largest at zero is not zero for certain. The likelihood is
/// multiplied by q^(1/4), a gamma prior without a scale that keeps the estimate off zero (Chung et
/// al. 2013); -2 ln of that is this times -ln q. Coefficients of which nothing is seen then get
/// about their own standard deviation where they are few, less where they are many.
constexpr double kBoundary = 0.5;

/// -2 times the logarithm of the restricted likelihood of columns with one prior variance q, and
/// what they leave of v'Pv (docs/theory/selection.md, eq. 8a).
struct ProcessLikelihood {
  Eigen::ArrayXd information;   ///< eigenvalues of M
  Eigen::ArrayXd square;        ///< of the gradient's parts along its eigenvectors
  double square_without = 0.0;  ///< v'Pv without the columns
  double redundancy = 0.0;
  double boundary = 0.0;  ///< times ln q is subtracted: kBoundary, or 0 without that prior

  [[nodiscard]] double Remaining(double q) const {
    return square_without - (square / (information + 1.0 / q)).sum();
  }
  [[nodiscard]] double LogDeterminant(double q) const {
    return (1.0 + q * information).log().sum();
  }
  [[nodiscard]] double operator()(double log_q) const {
    const double q = std::exp(log_q);
    const double left = std::max(Remaining(q), kMinVariance * redundancy);
    return redundancy * std::log(left) + LogDeterminant(q) - boundary * log_q;
  }
};

/// The most likely logarithm of q: a grid of factors of two, since there may be several minima,
/// then golden sections.
double MostLikelyVariance(const ProcessLikelihood& likelihood) {
  // From coefficients that show nowhere to a prior that says nothing.
  const double largest = likelihood.information.maxCoeff();
  const double first = std::log(1e-4 / largest), last = std::log(1e12 / largest);
  constexpr double kStep = 0.693;
  double best = first;
  for (double at = first; at <= last; at += kStep) {
    if (likelihood(at) < likelihood(best)) best = at;
  }
  double low = best - kStep, high = best + kStep;
  constexpr double kGolden = 0.6180339887498949;
  while (high - low > 1e-4) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    (likelihood(a) < likelihood(b) ? high : low) = likelihood(a) < likelihood(b) ? b : a;
  }
  return 0.5 * (low + high);
}

}  // namespace

double ConditionOf(const Eigen::MatrixXd& scaled) {
  const dense::Cholesky factor(scaled);
  if (!factor.positive_definite()) return std::numeric_limits<double>::infinity();
  return 1.0 / LeastEigenvalue(factor);
}

QuadraticModel::QuadraticModel(Data data) : data_(std::move(data)) {
  CHECK(Reset({})) << "an empty model is never singular";
}

QuadraticModel QuadraticModel::Reduced(const std::vector<int>& columns) const {
  return QuadraticModel({Part(data_.s, columns, columns),
                         data_.b(columns),
                         data_.constant,
                         data_.full_diagonal(columns),
                         data_.prior_weight(columns),
                         data_.log_count(columns),
                         data_.redundancy});
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
  omega_ = data_.constant;
  redundancy_ = data_.redundancy - Takes(active);
  if (active.empty()) return true;
  Eigen::MatrixXd saa = Part(s_, active, active);
  const Eigen::VectorXd scale = saa.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  saa = scale.asDiagonal() * saa * scale.asDiagonal();
  const dense::Cholesky factor(saa);
  if (!factor.positive_definite()) return false;
  const Eigen::MatrixXd y =
      factor.SolveLower(Eigen::MatrixXd(scale.asDiagonal() * s_(active, Eigen::all)));
  const Eigen::VectorXd z = factor.SolveLower(Eigen::VectorXd(scale.asDiagonal() * b_(active)));
  s_.noalias() -= y.transpose() * y;
  b_ -= y.transpose() * z;
  omega_ -= z.squaredNorm();
  return true;
}

void QuadraticModel::Add(const std::vector<int>& columns) {
  const dense::Cholesky factor(Part(s_, columns, columns));
  CHECK(factor.positive_definite()) << "columns that are not determined were added";
  const Eigen::MatrixXd y = factor.SolveLower(Eigen::MatrixXd(s_(columns, Eigen::all)));
  const Eigen::VectorXd z = factor.SolveLower(Eigen::VectorXd(b_(columns)));
  s_.noalias() -= y.transpose() * y;
  b_ -= y.transpose() * z;
  omega_ -= z.squaredNorm();
  redundancy_ -= Takes(columns);
  active_.insert(active_.end(), columns.begin(), columns.end());
}

CandidateFigures QuadraticModel::Test(const std::vector<int>& columns,
                                      const Eigen::MatrixXd& m,
                                      const Eigen::VectorXd& g,
                                      double square_without,
                                      double redundancy) const {
  CandidateFigures out;
  const auto k = static_cast<double>(columns.size());
  out.columns = static_cast<int>(columns.size());
  out.condition = std::numeric_limits<double>::infinity();
  out.posterior_prior = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd scale = data_.full_diagonal(columns).cwiseSqrt().cwiseInverse();
  if (columns.empty() || !scale.allFinite()) return out;
  const dense::Cholesky factor(scale.asDiagonal() * m * scale.asDiagonal());
  if (!factor.positive_definite()) return out;
  out.condition = 1.0 / LeastEigenvalue(factor);
  const Eigen::VectorXd scaled = scale.asDiagonal() * g;
  out.statistic = factor.SolveLower(scaled).squaredNorm();

  const Eigen::VectorXd prior = data_.prior_weight(columns);
  if (prior.minCoeff() > 0.0) {
    // log det of information over prior information: the exact penalty where a prior is proper.
    const double log_det = factor.LogDeterminant() - 2.0 * scale.array().log().sum();
    out.penalty = log_det - prior.array().log().sum();
    out.posterior_prior = std::exp(-0.5 * out.penalty / k);
  } else {
    out.penalty = data_.log_count(columns).sum();
  }
  const double left = redundancy - Takes(columns);
  if (!(left > 0.0)) return out;
  const double square_with = std::max(square_without - out.statistic, kMinVariance * left);
  out.f = (out.statistic / k) / (square_with / left);
  out.probability = FisherTailProbability(out.f, k, left);
  out.delta_bic =
      redundancy * std::log(square_with / std::max(square_without, kMinVariance * left)) +
      out.penalty;
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
  return Test(columns, Part(s_, columns, columns), b_(columns), omega_, redundancy_);
}

Eigen::MatrixXd QuadraticModel::Covariance() const {
  const auto n = static_cast<Eigen::Index>(active_.size());
  if (n == 0) return {};
  const Eigen::MatrixXd saa = Part(data_.s, active_, active_);
  const Eigen::VectorXd scale = saa.diagonal().cwiseSqrt().cwiseInverse();
  const dense::Cholesky factor(scale.asDiagonal() * saa * scale.asDiagonal());
  CHECK(factor.positive_definite()) << "the model is singular";
  return scale.asDiagonal() * factor.Inverse() * scale.asDiagonal();
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
  const dense::Cholesky factor(scale.asDiagonal() * ckk * scale.asDiagonal());
  const Eigen::MatrixXd m = scale.asDiagonal() * factor.Inverse() * scale.asDiagonal();
  const Eigen::VectorXd g = m * x;
  return Test(columns, m, g, omega_ + g.dot(x), redundancy_ + Takes(columns));
}

CandidateFigures QuadraticModel::Exchange(const std::vector<int>& out,
                                          const std::vector<int>& in) const {
  // The few columns that matter as a model of their own.
  const std::vector<int> base = ActiveBut({&out, &in});
  QuadraticModel small = Reduced(Joined({&base, &out, &in}));
  CandidateFigures figures;
  figures.condition = std::numeric_limits<double>::infinity();
  if (!small.Reset(Places(0, base.size()))) return figures;
  const CandidateFigures less = small.Score(Places(base.size(), out.size()));
  CandidateFigures more = small.Score(Places(base.size() + out.size(), in.size()));
  const int added = static_cast<int>(in.size()) - static_cast<int>(out.size());
  if (!more.regular || added <= 0) return more;
  // The larger space against the smaller one.
  const double square_out = small.square_sum() - (out.empty() ? 0.0 : less.statistic);
  const double square_in = small.square_sum() - more.statistic;
  const double left = small.redundancy() - Takes(in);
  const double before = small.redundancy() - Takes(out);
  const double floor = kMinVariance * left;
  more.columns = added;
  more.statistic = std::max(0.0, square_out - square_in);
  more.f = (more.statistic / added) / (std::max(square_in, floor) / left);
  more.probability = FisherTailProbability(more.f, added, left);
  more.penalty -= out.empty() ? 0.0 : less.penalty;
  more.delta_bic =
      before * std::log(std::max(square_in, floor) / std::max(square_out, floor)) + more.penalty;
  return more;
}

double QuadraticModel::PartLeft(const std::vector<int>& columns) const {
  double left = 0.0, whole = 0.0;
  for (const int c : columns) {
    left += s_(c, c) - data_.prior_weight[c];
    whole += data_.s(c, c) - data_.prior_weight[c];
  }
  return whole > 0.0 ? std::max(0.0, left / whole) : 0.0;
}

std::vector<double> QuadraticModel::MostLikelyVariances(
    const std::vector<std::vector<int>>& sets) const {
  std::vector<int> all = active_;
  std::vector<std::vector<int>> places;
  for (const std::vector<int>& set : sets) {
    places.push_back(Places(all.size(), set.size()));
    all.insert(all.end(), set.begin(), set.end());
  }
  // Starts from coefficients about as large as what is known of each alone.
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(all.size()));
  std::vector<double> variance(sets.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < sets.size(); ++k) {
    double information = 0.0;
    for (const int c : sets[k]) information = std::max(information, s_(c, c));
    if (!(information > 0.0)) continue;
    variance[k] = 1.0 / information;
    weight(places[k]).setConstant(information);
  }
  const Eigen::MatrixXd s = Part(data_.s, all, all);
  const Eigen::VectorXd b = data_.b(all);
  for (int sweep = 0; sweep < kMaxVarianceSweeps; ++sweep) {
    Eigen::MatrixXd covariance = s;
    covariance.diagonal() += weight;
    const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) break;
    const dense::Cholesky factor(scale.asDiagonal() * covariance * scale.asDiagonal());
    if (!factor.positive_definite()) break;
    covariance = scale.asDiagonal() * factor.Inverse() * scale.asDiagonal();
    double change = 0.0;
    for (std::size_t k = 0; k < sets.size(); ++k) {
      if (std::isnan(variance[k])) continue;
      const double q = variance[k];
      const Eigen::VectorXd x = covariance * b;
      const dense::Eigenpairs eigen = dense::SymmetricEigenpairs(covariance(places[k], places[k]));
      const Eigen::ArrayXd c = eigen.values.array();
      if (!(c[0] > 0.0)) continue;
      const Eigen::ArrayXd along = (eigen.vectors.transpose() * x(places[k])).array();
      ProcessLikelihood likelihood;
      likelihood.information = (1.0 / c - 1.0 / q).max(0.0);
      if (!(likelihood.information.maxCoeff() > 0.0)) continue;
      likelihood.square = (along / c).square();
      likelihood.square_without = data_.constant - b.dot(x) + (along.square() / c).sum();
      likelihood.redundancy = redundancy_;
      likelihood.boundary = kBoundary;
      const double next = std::exp(MostLikelyVariance(likelihood));
      change = std::max(change, std::abs(std::log(next / q)));
      variance[k] = next;
      weight(places[k]).setConstant(1.0 / next);
      // The covariance with the other weight (Sherman, Morrison and Woodbury).
      const double added = 1.0 / next - 1.0 / q;
      const Eigen::MatrixXd columns = covariance(Eigen::all, places[k]) * eigen.vectors;
      const Eigen::ArrayXd factors = added / (1.0 + added * c);
      covariance.noalias() -= columns * factors.matrix().asDiagonal() * columns.transpose();
    }
    if (change < kSettledVariance) break;
  }
  return variance;
}

void QuadraticModel::SetPrior(const std::vector<int>& columns, double variance) {
  for (const int c : columns) {
    const double added = 1.0 / variance - data_.prior_weight[c];
    data_.s(c, c) += added;
    s_(c, c) += added;
    data_.full_diagonal[c] += added;
    data_.prior_weight[c] = 1.0 / variance;
  }
}

CandidateFigures QuadraticModel::Process(const std::vector<int>& in,
                                         const std::vector<int>& out,
                                         const std::vector<int>& below) const {
  CandidateFigures figures;
  figures.columns = static_cast<int>(in.size()) - static_cast<int>(below.size());
  figures.condition = std::numeric_limits<double>::infinity();
  figures.posterior_prior = std::numeric_limits<double>::quiet_NaN();
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
  const double square_without = small.square_sum(), redundancy = small.redundancy();

  const auto k = static_cast<Eigen::Index>(places.size());
  const dense::Eigenpairs eigen = dense::SymmetricEigenpairs(small.s_(places, places));
  const double largest = eigen.values[k - 1];
  if (!(largest > 0.0)) return figures;
  ProcessLikelihood likelihood;
  likelihood.information = eigen.values.cwiseMax(0.0).array();
  likelihood.square = (eigen.vectors.transpose() * small.b_(places)).array().square();
  likelihood.square_without = square_without;
  likelihood.redundancy = redundancy;
  figures.variance = std::exp(MostLikelyVariance(likelihood));

  // The space of the columns against `below`: an exact test of no variance (Wald 1947).
  int free = 0;
  double square_free = square_without;
  for (Eigen::Index i = 0; i < k; ++i) {
    if (likelihood.information[i] <= kNothing * largest) continue;
    ++free;
    square_free -= likelihood.square[i] / likelihood.information[i];
  }
  const int added = free - static_cast<int>(below.size());
  const double left = redundancy - free;
  if (added <= 0 || !(left > 0.0)) return figures;
  const double floor = kMinVariance * left;
  const double square_below = square_without - (below.empty() ? 0.0 : poor.statistic);
  figures.statistic = std::max(0.0, square_below - square_free);
  figures.f = (figures.statistic / added) / (std::max(square_free, floor) / left);
  figures.probability = FisherTailProbability(figures.f, added, left);

  small.SetPrior(places, figures.variance);
  const Eigen::VectorXd scale = small.data_.full_diagonal(places).cwiseSqrt().cwiseInverse();
  figures.condition = ConditionOf(scale.asDiagonal() * Eigen::MatrixXd(small.s_(places, places)) *
                                  scale.asDiagonal());
  const double square_out = square_without - (out.empty() ? 0.0 : less.statistic);
  figures.penalty = likelihood.LogDeterminant(figures.variance) + std::log(static_cast<double>(k)) -
                    (out.empty() ? 0.0 : less.penalty);
  figures.delta_bic = (redundancy - small.Takes(places_of(out))) *
                          std::log(std::max(likelihood.Remaining(figures.variance), floor) /
                                   std::max(square_out, floor)) +
                      figures.penalty;
  figures.regular = std::isfinite(figures.condition);
  return figures;
}

namespace {

/// Logarithm of the number of equations of looks that touch each column.
Eigen::VectorXd LogCounts(const AdjustmentProblem& problem) {
  std::vector<double> equations(problem.layout.blocks.size(), 0.0);
  LookColumns columns;
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] == 0) continue;
    problem.model.ColumnsOf(i, &columns);
    for (int b = 0; b < columns.block_count; ++b) {
      equations[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])] += 2.0;
    }
  }
  Eigen::VectorXd out(problem.layout.size());
  for (std::size_t b = 0; b < equations.size(); ++b) {
    const ParameterBlock& block = problem.layout.blocks[b];
    out.segment(block.offset, block.size).setConstant(std::log(std::max(2.0, equations[b])));
  }
  return out;
}

}  // namespace

QuadraticModel::Data DataAt(const ReducedSystem& system,
                            const Eigen::VectorXd& corrections,
                            const std::vector<Parameter>& parameters) {
  QuadraticModel::Data data;
  data.s = system.matrix().ToDense();
  const Eigen::VectorXd sx = data.s * corrections;
  data.b = sx - system.right_side();
  data.constant = 2.0 * system.cost() - system.point_step_square() -
                  2.0 * system.right_side().dot(corrections) + sx.dot(corrections);
  data.full_diagonal = system.full_diagonal();
  data.prior_weight.setZero(corrections.size());
  data.log_count = LogCounts(system.problem());
  for (Eigen::Index i = 0; i < corrections.size(); ++i) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
    if (parameter.has_prior()) {
      data.prior_weight[i] = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
    }
  }
  return data;
}

}  // namespace sarblock
