// SPDX-License-Identifier: Apache-2.0
#include "verdict_tests.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/text.h"
#include "linear/dense.h"
#include "model/priors.h"
#include "model/problem.h"
#include <Eigen/Core>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace sarblock {
namespace {

using Normal = boost::math::normal_distribution<double>;

double LevelOfOne(const QualityOptions& options, std::size_t tests) {
  if (tests < 2) return options.alpha;
  const auto n = static_cast<double>(tests);
  switch (options.family_wise) {
    case FamilyWise::kNone:
      break;
    case FamilyWise::kSidak:
      return -std::expm1(std::log1p(-options.alpha) / n);
    case FamilyWise::kBonferroni:
      return options.alpha / n;
  }
  return options.alpha;
}

double UpperQuantile(double tail) {
  return boost::math::quantile(boost::math::complement(Normal(), tail));
}

double CriticalTau(double alpha, double redundancy) {
  if (!(redundancy > 1.0)) return kNaN;
  // With hardly any freedom the quantile is beyond all numbers, tau at its largest.
  using Unbounded = boost::math::policies::policy<
      boost::math::policies::overflow_error<boost::math::policies::ignore_error>>;
  const boost::math::students_t_distribution<double, Unbounded> student(redundancy - 1.0);
  const double t = boost::math::quantile(boost::math::complement(student, 0.5 * alpha));
  if (std::isinf(t)) return std::sqrt(redundancy);
  return std::sqrt(redundancy) * t / std::hypot(std::sqrt(redundancy - 1.0), t);
}

/// Newton's method; the power grows with the shift and its slope is a difference of densities.
double NonCentrality(double power, double critical) {
  double delta = critical + UpperQuantile(1.0 - power);
  delta = std::max(delta, 0.1);
  for (int i = 0; i < 60; ++i) {
    const double error = TestPower(delta, critical) - power;
    const double slope =
        boost::math::pdf(Normal(), critical - delta) - boost::math::pdf(Normal(), critical + delta);
    const double step = error / slope;
    delta = step < delta ? delta - step : 0.5 * delta;
    if (std::abs(step) < 1e-14 * delta) break;
  }
  return delta;
}

}  // namespace

double TestPower(double shift, double critical) {
  return boost::math::cdf(Normal(), shift - critical) +
         boost::math::cdf(Normal(), -shift - critical);
}

ReliabilityFigures MakeReliability(const QualityOptions& options,
                                   std::size_t tests,
                                   double redundancy) {
  if (!(options.alpha > 0.0 && options.alpha < 1.0)) {
    throw InputError("adjust.quality.alpha", "must lie between 0 and 1");
  }
  if (!(options.power > options.alpha && options.power < 1.0)) {
    throw InputError("adjust.quality.power", "must lie between alpha and 1");
  }
  ReliabilityFigures out;
  out.tests = tests;
  out.alpha_one = LevelOfOne(options, tests);
  out.alpha_all = -std::expm1(static_cast<double>(tests) * std::log1p(-out.alpha_one));
  out.critical_w = UpperQuantile(0.5 * out.alpha_one);
  out.critical_tau = CriticalTau(out.alpha_one, redundancy);
  out.delta0 = NonCentrality(options.power, out.critical_w);
  return out;
}

double MinimalDetectable(double delta0, double sigma_m, double redundancy) {
  return redundancy > kMinRedundancy ? delta0 * sigma_m / std::sqrt(redundancy) : kNaN;
}

double Influence_m(double delta0, double shift_m, double redundancy) {
  return MinimalDetectable(delta0, shift_m, redundancy);
}

double SquareLeftOut(std::size_t dropped, std::size_t looks, const AdjustResult& result) {
  constexpr double kMaxByChance = 0.01;
  const double limit = FarSquare();
  double square_sum = 0.0, count = 0.0;
  const auto add = [&](double number, double square_each) {
    square_sum += number * square_each;
    count += number;
  };
  add(static_cast<double>(dropped), limit);
  if (result.snooping) {
    add(static_cast<double>(result.snooping->robust.size()), limit);
    for (const BlunderFinding& finding : result.snooping->findings) {
      if (!LeavesOut(finding)) continue;
      // One statistic is for all the looks of a point that contradict each other.
      const double square = finding.w * finding.w;
      add(1.0, square < limit ? square : limit);  // no w of its own: NaN
    }
  }
  const double most = kMaxByChance * static_cast<double>(looks);
  return count > most ? square_sum * most / count : square_sum;
}

double PosteriorFactor(const AdjustOptions& options, const AdjustResult& result) {
  return options.scale_by_posterior && std::isfinite(result.sigma0_squared) ? result.sigma0_squared
                                                                            : 1.0;
}

void FillChecks(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  const double variance_factor = PosteriorFactor(options, *result);
  for (const KnownPosition& known : block.points.known) {
    const std::size_t point = known.point;
    if (block.points.role[point] != PointRole::kCheck) continue;
    if (!result->points.position_m[point].allFinite()) continue;
    CheckResult check;
    check.point = known.point;
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(block.points.given_m[point]) *
        (result->points.position_m[point] - block.points.given_m[point]);
    check.error_enu_m.setConstant(kNotGiven);
    std::array<int, 3> fixed{};
    for (int i = 0; i < 3; ++i) {
      if (!known.fixed[static_cast<std::size_t>(i)]) continue;
      check.error_enu_m[i] = error_m[i];
      if (!result->points.covariance_m2.empty()) {
        check.sigma_enu_m[i] = std::sqrt(
            variance_factor * result->points.covariance_m2[point][static_cast<std::size_t>(i)] +
            known.covariance_enu_m2(i, i));
      }
      fixed[static_cast<std::size_t>(check.components++)] = i;
    }
    check.chi_square = kNotGiven;
    if (!result->points.covariance_m2.empty() && IsSolved(result->points.status[point]) &&
        check.components > 0) {
      const Eigen::Matrix3d full =
          variance_factor * MatrixOf(result->points.covariance_m2[point]) + known.covariance_enu_m2;
      Eigen::MatrixXd part(check.components, check.components);
      Eigen::VectorXd e(check.components);
      for (int i = 0; i < check.components; ++i) {
        e[i] = error_m[fixed[static_cast<std::size_t>(i)]];
        for (int j = 0; j < check.components; ++j) {
          part(i, j) = full(fixed[static_cast<std::size_t>(i)], fixed[static_cast<std::size_t>(j)]);
        }
      }
      const dense::Cholesky factor(part);
      if (factor.positive_definite()) {
        check.chi_square = factor.SolveLower(e).squaredNorm();
      }
    }
    result->checks.push_back(check);
  }
}

namespace {

bool IsMeasured(const AdjustResult& result) { return result.status != AdjustStatus::kPredicted; }

/// Test of a prior that is independent of all others.
PriorTest TestOfPrior(const AdjustResult& result, const ParameterResult& parameter) {
  PriorTest out;
  const double ratio =
      parameter.sigma / (parameter.prior_sigma * std::sqrt(result.posterior_factor));
  if (std::isnan(ratio)) return out;
  out.redundancy = std::max(0.0, 1.0 - ratio * ratio);
  if (!IsMeasured(result) || out.redundancy <= kMinRedundancy) return out;
  out.w = parameter.value / (parameter.prior_sigma * std::sqrt(out.redundancy));
  out.square = out.w * out.w * out.redundancy;
  return out;
}

/// Tests of the coefficients of a process after its first: the whitened step from the one before.
void TestProcesses(const AdjustResult& result, std::vector<PriorTest>* tests) {
  std::vector<double> with_before(result.parameters.size(), kNotGiven);
  for (const ParameterCovariance& entry : result.parameter_covariance) {
    const auto holds = [&](std::uint32_t to, std::uint32_t from) {
      return result.parameters[to].before == static_cast<int>(from);
    };
    if (holds(entry.a, entry.b)) with_before[entry.a] = entry.covariance;
    if (holds(entry.b, entry.a)) with_before[entry.b] = entry.covariance;
  }
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterResult& to = result.parameters[i];
    if (to.before < 0) continue;
    const ParameterResult& from = result.parameters[static_cast<std::size_t>(to.before)];
    PriorTest& test = (*tests)[i];
    test = {};
    const double carried_sigma = to.carried * from.sigma;
    const double variance =
        (to.sigma * to.sigma + carried_sigma * carried_sigma - 2.0 * to.carried * with_before[i]) /
        (to.step_sigma * to.step_sigma * result.posterior_factor);
    if (std::isnan(variance)) continue;
    test.redundancy = std::clamp(1.0 - variance, 0.0, 1.0);
    if (!IsMeasured(result) || test.redundancy <= kMinRedundancy) continue;
    const double step = (to.value - to.carried * from.value) / to.step_sigma;
    test.w = step / std::sqrt(test.redundancy);
    test.square = step * step;
  }
}

/// Covariances of the result within each joint prior.
std::vector<Eigen::MatrixXd> CovariancesOfJointPriors(const AdjustResult& result) {
  struct Place {
    std::size_t prior = 0;
    Eigen::Index row = 0;
  };
  std::vector<Eigen::MatrixXd> out;
  std::vector<std::optional<Place>> places(result.parameters.size());
  for (std::size_t p = 0; p < result.joint_priors.size(); ++p) {
    const std::vector<std::uint32_t>& parameters = result.joint_priors[p].parameters;
    const auto size = static_cast<Eigen::Index>(parameters.size());
    out.emplace_back(Eigen::MatrixXd::Constant(size, size, kNotGiven));
    for (Eigen::Index i = 0; i < size; ++i) {
      places[parameters[static_cast<std::size_t>(i)]] = Place{p, i};
    }
  }
  for (const ParameterCovariance& entry : result.parameter_covariance) {
    const auto &a = places[entry.a], &b = places[entry.b];
    if (!a || !b || a->prior != b->prior) continue;
    out[a->prior](a->row, b->row) = out[a->prior](b->row, a->row) =
        entry.covariance / result.posterior_factor;
  }
  return out;
}

void TestJointPriors(const AdjustResult& result, std::vector<PriorTest>* tests) {
  const std::vector<Eigen::MatrixXd> covariances = CovariancesOfJointPriors(result);
  for (std::size_t p = 0; p < covariances.size(); ++p) {
    const JointPriorResult& prior = result.joint_priors[p];
    const Eigen::MatrixXd& c = covariances[p];
    JointPriorTerm term;
    term.Set(prior.covariance.matrix());
    const Eigen::Index size = c.rows();
    Eigen::VectorXd value(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      value[i] = result.parameters[prior.parameters[static_cast<std::size_t>(i)]].value;
    }
    const Eigen::VectorXd weighted = term.information * value;
    // N by whitened rows: I - W C W' loses no more digits than 1 - sigma^2 / sigma0^2 does.
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::Identity(size, size) - term.whitening * c * term.whitening.transpose();
    const Eigen::VectorXd n = (term.whitening.transpose() * left * term.whitening).diagonal();
    for (Eigen::Index i = 0; i < size; ++i) {
      PriorTest& test = (*tests)[prior.parameters[static_cast<std::size_t>(i)]];
      test = {};
      if (!c.allFinite()) continue;
      test.redundancy = (term.factor * left * term.whitening)(i, i);
      const double least = kMinRedundancy * term.information(i, i);
      if (!IsMeasured(result)) continue;
      test.square = value[i] * weighted[i];
      if (n[i] > least) test.w = weighted[i] / std::sqrt(n[i]);
    }
  }
}

}  // namespace

std::vector<PriorTest> TestsOfPriors(const AdjustResult& result) {
  std::vector<PriorTest> out;
  out.reserve(result.parameters.size());
  for (const ParameterResult& parameter : result.parameters) {
    out.push_back(TestOfPrior(result, parameter));
  }
  TestProcesses(result, &out);
  if (!result.joint_priors.empty()) TestJointPriors(result, &out);
  return out;
}

double LevelOfOneTest(double test_level) { return 1.0 - (1.0 - test_level) / kTestsOfVerdict; }

PriorSums SumPriors(const ParameterLayout& layout,
                    const Eigen::VectorXd& corrections,
                    const std::vector<ParameterCovariance>& covariance) {
  PriorSums out;
  struct Weight {
    std::uint32_t row = 0;
    double weight = 0.0;
  };
  std::vector<std::vector<Weight>> rows_of(layout.parameters.size());
  std::uint32_t rows = 0;
  for (int block = 0; block < static_cast<int>(layout.blocks.size()); ++block) {
    for (const PriorRow& row : PriorRowsOf(layout, block)) {
      double v = 0.0;
      for (const PriorRow::Term& term : row.terms) {
        const auto i = static_cast<std::size_t>(term.parameter);
        v += term.weight * (corrections[term.parameter] - layout.parameters[i].prior_value);
        rows_of[i].push_back({rows, term.weight});
      }
      out.square_sum += v * v;
      ++rows;
    }
  }
  std::unordered_map<std::uint64_t, double> k;  // W C W' by row and column, row <= column
  std::vector<std::uint8_t> has_sigma(layout.parameters.size(), 0);
  for (const ParameterCovariance& entry : covariance) {
    if (entry.a == entry.b) has_sigma[entry.a] = std::isfinite(entry.covariance) ? 1 : 0;
    for (const Weight& a : rows_of[entry.a]) {
      for (const Weight& b : rows_of[entry.b]) {
        // A diagonal entry of C is met in both orders of two rows, K has it once.
        if (entry.a == entry.b && a.row > b.row) continue;
        const auto [low, high] = std::minmax(a.row, b.row);
        const double part = a.weight * entry.covariance * b.weight;
        // C has each entry off its diagonal twice; both fall on the diagonal of one row.
        const double twice = entry.a != entry.b && low == high ? 2.0 : 1.0;
        k[(static_cast<std::uint64_t>(low) << 32U) | high] += twice * part;
      }
    }
  }
  out.known = true;
  for (std::size_t i = 0; i < rows_of.size(); ++i) {
    out.known = out.known && (rows_of[i].empty() || has_sigma[i] != 0);
  }
  double trace = 0.0, square = 0.0;
  for (const auto& [key, value] : k) {
    const bool diagonal = (key >> 32U) == (key & 0xffffffffU);
    if (diagonal) trace += value;
    square += (diagonal ? 1.0 : 2.0) * value * value;
  }
  out.redundancy = std::max(0.0, static_cast<double>(rows) - trace);
  out.unsure = std::max(0.0, trace - square);
  return out;
}

namespace {

/// Where v'Pv of observations with this redundancy lies at a level, two-sided. A quadratic form of
/// normal variables has the expectation tr(M) and the variance 2 tr(M^2), the eigenvalues of M
/// between 0 and 1: so tr(M^2) <= tr(M), and below a redundancy of 1 <= tr(M)^2. That of a
/// chi-square of max(1, r) degrees times r / max(1, r) is the widest (Satterthwaite 1946).
Interval BandOf(double level, double redundancy) {
  const double degrees = std::max(1.0, redundancy);
  const Interval interval = ChiSquareInterval(level, degrees);
  return {interval.lower * redundancy / degrees, interval.upper * redundancy / degrees};
}

/// The same where priors may be wider than the errors of their corrections, which takes up to
/// `unsure` off the redundancy, and good looks may have been left out; at least the size that
/// matters.
Interval BandOfMeasurements(double level, double redundancy, double unsure, double left_out) {
  Interval band = BandOf(level, redundancy);
  const double least = redundancy - unsure;
  band.lower = least > kMinRedundancy ? BandOf(level, least).lower : 0.0;
  const double small = 1.0 - kSigmaThatMatters, large = 1.0 + kSigmaThatMatters;
  band.lower = std::max(0.0, std::min(band.lower, small * small * redundancy) - left_out);
  band.upper = std::max(band.upper, large * large * redundancy);
  return band;
}

/// Rounding of the redundancy of a block, as a part of its observations.
constexpr double kRedundancyRounding = 1e-9;

}  // namespace

GlobalTest TestMeasurements(const ProblemCounts& counts,
                            const PriorSums& priors,
                            const SquareSum& square_sum,
                            double test_level) {
  GlobalTest test;
  double square = square_sum.kept;
  double redundancy = counts.redundancy();
  if (priors.known) {
    square = std::max(0.0, square - priors.square_sum);
    redundancy -= priors.redundancy;
  }
  if (!(redundancy > kRedundancyRounding * static_cast<double>(counts.observations))) return test;
  test.redundancy = redundancy;
  test.sigma0_squared = square / redundancy;
  test.chi_square = BandOfMeasurements(LevelOfOneTest(test_level),
                                       redundancy,
                                       priors.known ? priors.unsure : 0.0,
                                       square_sum.left_out);
  test.passed = test.chi_square.Contains(square);
  return test;
}

bool PriorsHold(const PriorSums& priors, double test_level) {
  return priors.square_sum <= BandOf(LevelOfOneTest(test_level), priors.redundancy).upper;
}

std::vector<ObservationGroup> ListGroups(const AdjustmentProblem& problem,
                                         const PriorSums& priors,
                                         const SquareSum& square_sum,
                                         double test_level,
                                         const AdjustResult& result) {
  const double level = LevelOfOneTest(test_level);
  std::vector<ObservationGroup> out;
  const auto add = [&](const char* name, double square, double redundancy, Interval band) {
    if (!(redundancy > kMinRedundancy)) return;
    out.push_back({name,
                   std::max(0.0, square),
                   redundancy,
                   {band.lower / redundancy, band.upper / redundancy}});
  };
  const auto add_measured = [&](const char* name, double square, double redundancy) {
    add(name,
        square,
        redundancy,
        BandOfMeasurements(level, redundancy, priors.unsure, square_sum.left_out));
  };
  const ProblemCounts counts = CountProblem(problem);
  // Without covariances of the corrections the redundancy numbers are those of each point alone.
  const bool of_block = problem.layout.size() == 0 || !result.parameter_covariance.empty();
  if (priors.known && of_block && !result.quality.empty()) {
    std::array<double, 2> square{}, redundancy{};
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t i = 0; i < result.quality.redundancy[k].size(); ++i) {
        const auto r = static_cast<double>(result.quality.redundancy[k][i]);
        const auto w = static_cast<double>(result.quality.w[k][i]);
        if (std::isnan(r)) continue;
        redundancy[k] += r;
        if (!std::isnan(w)) square[k] += w * w * r;
      }
    }
    add_measured("ranges", square[0], redundancy[0]);
    add_measured("azimuths", square[1], redundancy[1]);
    if (!result.control_quality.empty()) {
      // By difference: where components are correlated, the squares of their tests do not add up to
      // v'Pv.
      add_measured("control",
                   square_sum.kept - priors.square_sum - square[0] - square[1],
                   counts.redundancy() - priors.redundancy - redundancy[0] - redundancy[1]);
    }
  }
  if (priors.known && priors.redundancy > 0.0) {
    const double least = kPriorsThatMatter * kPriorsThatMatter * priors.redundancy;
    const Interval band{0.0, std::max(least, BandOf(level, priors.redundancy).upper)};
    add("priors", priors.square_sum, priors.redundancy, band);
  }
  add_measured("all", square_sum.kept, counts.redundancy());
  return out;
}

namespace {

/// The priors of one kind of correction, such as "position.along.0", in all passes and groups.
struct KindOfPrior {
  std::size_t priors = 0;
  double square_sum = 0.0, redundancy = 0.0;
  double value_square = 0.0, prior_square = 0.0;  ///< of their values and standard deviations
  std::string unit;
  [[nodiscard]] double TooTight() const { return std::sqrt(square_sum / redundancy); }
  [[nodiscard]] double Rms() const { return std::sqrt(value_square / static_cast<double>(priors)); }
  [[nodiscard]] double PriorRms() const {
    return std::sqrt(prior_square / static_cast<double>(priors));
  }
};

/// The kind of every parameter by name; the many coefficients of one axis, as splines have them,
/// are one kind.
std::vector<std::string> NamesOfKinds(const std::vector<ParameterResult>& parameters) {
  constexpr std::size_t kMaxApart = 6;
  const auto axis_of = [](const std::string& name) { return name.substr(0, name.rfind('.')); };
  std::map<std::pair<std::string, std::string>, std::size_t> count;
  for (const ParameterResult& p : parameters) ++count[{p.owner, axis_of(p.name)}];
  std::vector<std::string> names;
  for (const ParameterResult& p : parameters) {
    const std::string axis = axis_of(p.name);
    names.push_back(count[{p.owner, axis}] > kMaxApart ? axis : p.name);
  }
  return names;
}

std::map<std::string, KindOfPrior> KindsOfPriors(const AdjustResult& result,
                                                 const std::vector<PriorTest>& tests) {
  std::map<std::string, KindOfPrior> kinds;
  const std::vector<std::string> names = NamesOfKinds(result.parameters);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (std::isnan(tests[i].redundancy)) continue;
    const ParameterResult& p = result.parameters[i];
    KindOfPrior& kind = kinds[names[i]];
    ++kind.priors;
    kind.redundancy += tests[i].redundancy;
    if (!std::isnan(tests[i].square)) kind.square_sum += tests[i].square;
    kind.value_square += p.value * p.value;
    kind.prior_square += p.prior_sigma * p.prior_sigma;
    kind.unit = p.unit;
  }
  return kinds;
}

std::string ThreeDigits(double value) { return Digits(value, 3); }

std::string TightKinds(const std::map<std::string, KindOfPrior>& kinds, double test_level) {
  const double level =
      1.0 - (1.0 - LevelOfOneTest(test_level)) / static_cast<double>(kinds.size() + 1);
  std::vector<std::pair<double, std::string>> tight;
  for (const auto& [name, kind] : kinds) {
    if (!(kind.redundancy > kMinRedundancy)) continue;
    const double least = kPriorsThatMatter * kPriorsThatMatter * kind.redundancy;
    if (kind.square_sum <= std::max(least, BandOf(level, kind.redundancy).upper)) continue;
    tight.emplace_back(-kind.TooTight(),
                       name + " (" + ThreeDigits(kind.TooTight()) +
                           " times too tight: " + ThreeDigits(kind.Rms()) + " beside " +
                           ThreeDigits(kind.PriorRms()) + " " + kind.unit + ")");
  }
  std::sort(tight.begin(), tight.end());
  std::string text;
  for (const auto& [factor, words] : tight) text += (text.empty() ? "" : ", ") + words;
  return text;
}

}  // namespace

PriorFindings TestPriors(const AdjustResult& result, double test_level) {
  PriorFindings out;
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  const std::map<std::string, KindOfPrior> kinds = KindsOfPriors(result, tests);
  if (kinds.empty()) return out;
  if (const std::string tight = TightKinds(kinds, test_level); !tight.empty()) {
    out.reason =
        "priors: the observations contradict those of " + tight +
        ": standard deviations of these corrections in another unit or too small, or flights of "
        "another date";
    return out;
  }
  std::size_t tested = 0;
  for (const PriorTest& test : tests) tested += std::isnan(test.w) ? 0U : 1U;
  QualityOptions all;
  all.alpha = 1.0 - LevelOfOneTest(test_level);
  all.family_wise = FamilyWise::kBonferroni;
  const double critical = MakeReliability(all, tested, result.test_redundancy).critical_w;
  std::size_t above = 0, worst = 0;
  bool matters = false;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const double w = std::abs(tests[i].w);
    if (!(w > critical)) continue;
    // Without the prior the correction would be another one by w sqrt((1 - r) / r) of its standard
    // deviations.
    const double r = std::clamp(tests[i].redundancy, kMinRedundancy, 1.0);
    matters = matters || w * std::sqrt((1.0 - r) / r) > 1.0 || w > kPriorsThatMatter * critical;
    if (above++ == 0 || w > std::abs(tests[worst].w)) worst = i;
  }
  if (above == 0) return out;
  const ParameterResult& p = result.parameters[worst];
  std::array<char, 160> figures{};
  std::snprintf(
      figures.data(),
      figures.size(),
      "%.4g %s beside a standard deviation of %.4g %s, |w| %.1f; beyond %.2f is no chance",
      p.value,
      p.unit.c_str(),
      p.prior_sigma,
      p.unit.c_str(),
      std::abs(tests[worst].w),
      critical);
  (matters ? out.reason : out.note) =
      "priors: the observations contradict those of " + std::to_string(above) + " of " +
      std::to_string(tested) + " corrections, most that of " + p.owner + " " + p.name + " (" +
      figures.data() +
      "): a path that belongs to another pass, a prior that is too tight, or blunders in looks or "
      "control" +
      (matters ? "" : "; the corrections hardly follow these priors");
  return out;
}

namespace {

/// Priors that many times wider than what came out say nothing of it.
constexpr double kEmpty = 10.0;

/// Largest eigenvalue of D^1/2 C D^1/2, D the weight that priors of the right size would add, by
/// powers of the matrix; D zero where a prior is not empty.
double LargestGain(const AdjustResult& result, const std::vector<double>& added) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(added.size()));
  for (std::size_t i = 0; i < added.size(); ++i) x[static_cast<Eigen::Index>(i)] = added[i] > 0.0;
  double gain = 0.0;
  for (int power = 0; power < 60 && x.norm() > 0.0; ++power) {
    x.normalize();
    Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
    for (const ParameterCovariance& c : result.parameter_covariance) {
      if (!(added[c.a] > 0.0 && added[c.b] > 0.0)) continue;
      const double entry = std::sqrt(added[c.a] * added[c.b]) * c.covariance;
      const auto a = static_cast<Eigen::Index>(c.a), b = static_cast<Eigen::Index>(c.b);
      y[a] += entry * x[b];
      if (a != b) y[b] += entry * x[a];
    }
    gain = x.dot(y);
    x = y;
  }
  return gain;
}

}  // namespace

std::string EmptyPriors(const AdjustResult& result) {
  const std::map<std::string, KindOfPrior> kinds = KindsOfPriors(result, TestsOfPriors(result));
  const std::vector<std::string> names = NamesOfKinds(result.parameters);
  constexpr std::size_t kNamed = 3;
  std::vector<double> added(result.parameters.size(), 0.0);
  std::size_t empty = 0;
  std::string text;
  for (const auto& [name, kind] : kinds) {
    // What came out: the corrections and how well they are known.
    double out_square = 0.0;
    bool in_process = false;
    for (std::size_t i = 0; i < added.size(); ++i) {
      const ParameterResult& p = result.parameters[i];
      if (names[i] != name || std::isnan(p.prior_sigma)) continue;
      in_process = in_process || p.before >= 0;
      out_square += p.value * p.value + p.sigma * p.sigma;
    }
    const double came_out = std::sqrt(out_square / static_cast<double>(kind.priors));
    // Steps of a process may be narrow where its coefficients may go far.
    if (in_process || !(kind.PriorRms() > kEmpty * came_out)) continue;
    for (std::size_t i = 0; i < added.size(); ++i) {
      const ParameterResult& p = result.parameters[i];
      if (names[i] != name || std::isnan(p.prior_sigma)) continue;
      added[i] = 1.0 / (came_out * came_out) - 1.0 / (p.prior_sigma * p.prior_sigma);
    }
    if (empty++ >= kNamed) continue;
    text += (text.empty() ? "" : ", ") + name + " (" + ThreeDigits(came_out) + " " + kind.unit +
            " beside " + ThreeDigits(kind.PriorRms()) + " " + kind.unit + ")";
  }
  if (empty == 0) return {};
  if (empty > kNamed) text += " and " + std::to_string(empty - kNamed) + " more";
  const double narrower = 1.0 - 1.0 / std::sqrt(1.0 + LargestGain(result, added));
  if (!(narrower > kSigmaThatMatters)) return {};
  return kWidePriors + (": " + text) +
         "; with priors of that size standard deviations of points would be smaller, by at most " +
         ThreeDigits(100.0 * narrower) + " %";
}

}  // namespace sarblock
