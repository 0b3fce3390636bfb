// SPDX-License-Identifier: Apache-2.0
#include "assess.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "blunder_search.h"
#include "core/text.h"
#include "model/priors.h"
#include "reliability.h"
#include <Eigen/Core>

namespace sarblock {

BlunderSizes::BlunderSizes(const Block& block,
                           const AdjustOptions& options,
                           const AdjustResult& result,
                           double factor_1)
    : block_(block),
      result_(result),
      delta0_1_(result.quality.empty() && result.control_quality.empty()
                    ? kNotGiven
                    : ReliabilityOf(options, result).delta0_1),
      scale_1_(std::sqrt(factor_1)),
      sigma_factor_1_(block.passes.size(), {1.0, 1.0}) {
  if (result.variance_components) {
    sigma_factor_1_ = SigmaFactors(result.variance_components->components, block.passes.size());
  }
}

std::array<BlunderSize, 2> BlunderSizes::OfLook(std::uint64_t look, std::size_t point) const {
  const LookQuality& quality = result_.quality;
  const std::array<double, 2>& factor_1 = sigma_factor_1_[block_.looks.pass[look]];
  std::array<BlunderSize, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto redundancy_1 = static_cast<double>(quality.redundancy_1[k][look]);
    if (std::isnan(redundancy_1)) continue;
    const double given_m = k == 0 ? block_.SigmaOf(look).range_m
                                  : AzimuthSigma_m(block_, look, result_.points.position_m[point]);
    out[k].sigma_m = factor_1[k] * given_m;
    out[k].detectable_m = MinimalDetectable(delta0_1_, scale_1_ * out[k].sigma_m, redundancy_1);
    out[k].influence_m = Influence_m(
        delta0_1_, scale_1_ * static_cast<double>(quality.shift_m[k][look]), redundancy_1);
  }
  return out;
}

BlunderSize BlunderSizes::OfControl(const ControlQuality& control) const {
  const KnownPosition& known = *block_.points.FindKnown(control.point);
  BlunderSize out;
  out.sigma_m = std::sqrt(known.covariance_enu_m2(control.component, control.component));
  out.detectable_m = MinimalDetectable(delta0_1_, scale_1_ * out.sigma_m, control.redundancy_1);
  out.influence_m = Influence_m(delta0_1_, scale_1_ * control.shift_m, control.redundancy_1);
  return out;
}

namespace {

/// Chance that a block whose priors hold is warned of.
constexpr double kWarnLevel_1 = 0.001;

bool IsMeasured(const AdjustResult& result) { return result.status != AdjustStatus::kPredicted; }

/// Of a prior that is independent of all others.
PriorTest TestOfPrior(const AdjustResult& result, const ParameterResult& parameter) {
  PriorTest out;
  const double ratio_1 = parameter.sigma / parameter.prior_sigma;
  if (std::isnan(ratio_1)) return out;
  out.redundancy_1 = std::max(0.0, 1.0 - ratio_1 * ratio_1);
  if (!IsMeasured(result) || out.redundancy_1 <= kLeastRedundancy_1) return out;
  out.w_1 = parameter.value / (parameter.prior_sigma * std::sqrt(out.redundancy_1));
  out.square_1 = out.w_1 * out.w_1 * out.redundancy_1;
  return out;
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
    out[a->prior](a->row, b->row) = out[a->prior](b->row, a->row) = entry.covariance;
  }
  return out;
}

void TestJointPriors(const AdjustResult& result, std::vector<PriorTest>* tests) {
  const std::vector<Eigen::MatrixXd> covariances = CovariancesOfJointPriors(result);
  for (std::size_t p = 0; p < covariances.size(); ++p) {
    const JointPriorResult& prior = result.joint_priors[p];
    const Eigen::MatrixXd& c = covariances[p];
    JointPriorTerm term;
    term.Set(prior.covariance);
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
      test.redundancy_1 = (term.factor * left * term.whitening)(i, i);
      const double least = kLeastRedundancy_1 * term.information(i, i);
      if (!IsMeasured(result)) continue;
      test.square_1 = value[i] * weighted[i];
      if (n[i] > least) test.w_1 = weighted[i] / std::sqrt(n[i]);
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
  if (!result.joint_priors.empty()) TestJointPriors(result, &out);
  return out;
}

std::string ContradictedPriors(const AdjustResult& result) {
  std::vector<double> w_1;
  std::size_t tested = 0;
  for (const PriorTest& test : TestsOfPriors(result)) {
    w_1.push_back(std::abs(test.w_1));
    tested += std::isnan(w_1.back()) ? 0U : 1U;
  }
  QualityOptions all;
  all.alpha_1 = kWarnLevel_1;
  all.family_wise = FamilyWise::kBonferroni;
  const double critical_1 = MakeReliability(all, tested, result.redundancy()).critical_w_1;
  std::size_t above = 0, worst = 0;
  for (std::size_t i = 0; i < w_1.size(); ++i) {
    if (!(w_1[i] > critical_1)) continue;
    if (above++ == 0 || w_1[i] > w_1[worst]) worst = i;
  }
  if (above == 0) return {};
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
      w_1[worst],
      critical_1);
  return "priors: the observations contradict those of " + std::to_string(above) + " of " +
         std::to_string(tested) + " corrections, most that of " + p.owner + " " + p.name + " (" +
         figures.data() +
         "): a path that belongs to another pass, a prior that is too tight, or blunders in looks "
         "or control";
}

PriorSummary SummarisePriors(const AdjustOptions& options, const AdjustResult& result) {
  PriorSummary out;
  const ReliabilityFigures figures = ReliabilityOf(options, result);
  const bool tau = options.quality.test == BlunderTest::kTau;
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const PriorTest& test = tests[i];
    if (std::isnan(test.redundancy_1)) continue;
    out.redundancy_1 = (out.priors++ == 0 ? 0.0 : out.redundancy_1) + test.redundancy_1;
    if (std::isnan(test.w_1)) continue;
    ++out.tested;
    const double statistic = std::abs(tau ? TauOf(test.w_1, result) : test.w_1);
    out.above += statistic > (tau ? figures.critical_tau_1 : figures.critical_w_1) ? 1U : 0U;
    if (out.tested == 1 || std::abs(test.w_1) > std::abs(out.worst_w_1)) {
      out.worst = i;
      out.worst_w_1 = test.w_1;
    }
  }
  out.expected_above_1 = figures.alpha_one_1 * static_cast<double>(out.tested);
  return out;
}

std::vector<PassShare> SharesOf(const Block& block, const AdjustResult& result) {
  std::vector<PassShare> out;
  if (result.quality.empty()) return out;
  std::map<std::string, std::size_t> index;
  const auto share_of = [&](const std::string& owner) -> PassShare& {
    const auto [found, added] = index.emplace(owner, out.size());
    if (added) {
      out.emplace_back();
      out.back().owner = owner;
    }
    return out[found->second];
  };
  for (const Pass& pass : block.passes) share_of(pass.id);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    PassShare& share = out[block.looks.pass[i]];
    bool counts = false;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto r_1 = static_cast<double>(result.quality.redundancy_1[k][i]);
      const auto w_1 = static_cast<double>(result.quality.w_1[k][i]);
      if (std::isnan(r_1)) continue;
      counts = true;
      share.redundancy_1 += r_1;
      // v^2 = w^2 r in units of sigma; without redundancy there is no residual either.
      if (!std::isnan(w_1)) share.square_sum_1 += w_1 * w_1 * r_1;
    }
    share.looks += counts ? 1U : 0U;
  }
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const PriorTest& test = tests[i];
    if (std::isnan(test.redundancy_1)) continue;
    PassShare& share = share_of(result.parameters[i].owner);
    share.prior_redundancy_1 += test.redundancy_1;
    if (!std::isnan(test.square_1)) share.prior_square_sum_1 += test.square_1;
  }
  return out;
}

namespace {

constexpr std::size_t kMostWorst = 10;

double MedianOf(std::vector<float> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](float v) { return std::isnan(v); }),
               values.end());
  return static_cast<double>(Median(std::move(values)));
}

/// A statistic beyond its critical value.
bool IsAbove(double w_1,
             const AdjustOptions& options,
             const AdjustResult& result,
             const ReliabilityFigures& figures) {
  return options.quality.test == BlunderTest::kTau
             ? std::abs(TauOf(w_1, result)) > figures.critical_tau_1
             : std::abs(w_1) > figures.critical_w_1;
}

void KeepWorst(const TestedLook& look, std::vector<TestedLook>* worst) {
  const auto larger = [](const TestedLook& a, const TestedLook& b) {
    return std::abs(a.w_1) > std::abs(b.w_1);
  };
  if (worst->size() == kMostWorst && !larger(look, worst->back())) return;
  worst->insert(std::upper_bound(worst->begin(), worst->end(), look, larger), look);
  if (worst->size() > kMostWorst) worst->pop_back();
}

std::string Percent(double part_1) { return Digits(100.0 * part_1, 4) + " %"; }

std::string Short(double value) { return Digits(value, 3); }

}  // namespace

ReliabilityFigures ReliabilityOf(const AdjustOptions& options, const AdjustResult& result) {
  return MakeReliability(
      options.quality, CountTests(result.quality, result.control_quality), result.redundancy());
}

double TauOf(double w_1, const AdjustResult& result) {
  return w_1 / std::sqrt(result.sigma0_squared);
}

double AzimuthSigma_m(const Block& block, std::uint64_t look, const Eigen::Vector3d& p_m) {
  const LookSigma sigma = block.SigmaOf(look);
  if (sigma.azimuth_unit == AzimuthUnit::kMetres) return sigma.azimuth;
  const Pass& pass = block.passes[block.looks.pass[look]];
  const auto motion = pass.path.At(block.looks.time_s[look]);
  if (!motion) return kNotGiven;
  const double speed_mps = motion->velocity_mps.norm();
  if (block.MeasuresDoppler(look)) return block.RoughAzimuthSigma_m(look, speed_mps);
  const TimeRates rates = LookTimeRates(
      p_m, motion->position_m, motion->velocity_mps, motion->acceleration_mps2, block.ConeOf(look));
  return sigma.azimuth * std::abs(rates.doppler_mps);
}

QualitySummary SummariseQuality(const Block& block,
                                const AdjustOptions& options,
                                const AdjustResult& result) {
  QualitySummary out;
  out.figures = ReliabilityOf(options, result);
  if (result.quality.empty()) return out;
  const bool measured = result.status != AdjustStatus::kPredicted;
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    const bool alone =
        block.points.role[point] != PointRole::kControl && result.points.looks[point] == 2;
    for (std::uint64_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (!std::isnan(result.quality.w_1[0][i])) out.looks_not_localisable += alone;
      for (std::size_t k = 0; k < 2; ++k) {
        const auto w_1 = static_cast<double>(result.quality.w_1[k][i]);
        if (std::isnan(w_1)) continue;
        ++out.looks_tested[k];
        out.looks_above[k] += IsAbove(w_1, options, result, out.figures) ? 1U : 0U;
        const auto r_1 = static_cast<double>(result.quality.redundancy_1[k][i]);
        if (measured) KeepWorst({i, point, k == 1, w_1, r_1}, &out.worst);
      }
    }
  }
  for (std::size_t i = 0; i < result.control_quality.size(); ++i) {
    const ControlQuality& control = result.control_quality[i];
    if (std::isnan(control.w_1)) continue;
    ++out.control_tested;
    if (measured && !(std::abs(control.w_1) <= std::abs(out.worst_control_w_1))) {
      out.worst_control = i;
      out.worst_control_w_1 = control.w_1;
    }
    out.control_above += IsAbove(control.w_1, options, result, out.figures) ? 1U : 0U;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    out.median_redundancy_1[k] = MedianOf(result.quality.redundancy_1[k]);
  }
  return out;
}

namespace {

/// Whether a check point's error can be compared with a prediction. Without covariances at all
/// every solved point is as good as another.
bool IsCompared(const AdjustResult& result, const CheckResult& check) {
  if (!result.points.covariance_m2.empty()) return !std::isnan(check.chi_square);
  return result.points.status.empty() || IsSolved(result.points.status[check.point]);
}

}  // namespace

CheckSummary SummariseChecks(const AdjustResult& result, double level) {
  CheckSummary out;
  std::array<double, 3> square_m2{}, count{};
  for (const CheckResult& check : result.checks) {
    if (!IsCompared(result, check)) {
      ++out.points_without_sigma;
      continue;
    }
    ++out.points;
    for (std::size_t k = 0; k < 3; ++k) {
      const double error_m = check.error_enu_m[static_cast<Eigen::Index>(k)];
      if (std::isnan(error_m)) continue;
      square_m2[k] += error_m * error_m;
      count[k] += 1.0;
    }
    if (std::isnan(check.chi_square)) continue;
    out.chi_square += check.chi_square;
    out.components += check.components;
    const double limit = ChiSquareQuantile(level, static_cast<double>(check.components));
    out.points_outside += check.chi_square > limit ? 1U : 0U;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    out.rms_m[k] = count[k] > 0.0 ? std::sqrt(square_m2[k] / count[k]) : kNotGiven;
  }
  if (out.components == 0) return out;
  const auto n = static_cast<double>(out.components);
  out.freedom_1 = std::isnan(result.check_freedom_1) ? n : result.check_freedom_1;
  out.chi_square_interval = ChiSquareInterval(level, out.freedom_1);
  out.chi_square_interval.lower *= n / out.freedom_1;
  out.chi_square_interval.upper *= n / out.freedom_1;
  out.error_ratio_1 = std::sqrt(out.chi_square / n);
  out.error_ratio_interval_1 = {std::sqrt(out.chi_square_interval.lower / n),
                                std::sqrt(out.chi_square_interval.upper / n)};
  return out;
}

std::string DescribeChecks(const CheckSummary& summary, double level) {
  if (summary.components == 0) return "";
  const bool large = summary.chi_square > summary.chi_square_interval.upper;
  std::string text = summary.realistic() ? "the predicted accuracy is realistic"
                     : large             ? "the predicted accuracy is TOO OPTIMISTIC"
                                         : "the predicted accuracy is too pessimistic";
  text += ": errors of check points are " + Short(summary.error_ratio_1) +
          " times as large as predicted, " + Short(summary.error_ratio_interval_1.lower) + " to " +
          Short(summary.error_ratio_interval_1.upper) + " is expected (" + Percent(level) + ", " +
          Short(summary.freedom_1) + " independent components); " +
          std::to_string(summary.points_outside) + " of " + std::to_string(summary.points) +
          " points exceed their own " + Percent(level) + " limit (" +
          Short((1.0 - level) * static_cast<double>(summary.points)) + " expected)";
  if (summary.points_without_sigma > 0) {
    text += "; " + std::to_string(summary.points_without_sigma) +
            " more have no standard deviation and are not compared";
  }
  return text;
}

const char* NameOf(BlunderFinding::Action action) {
  switch (action) {
    case BlunderFinding::Action::kRejected:
      return "rejected";
    case BlunderFinding::Action::kPointLeftOut:
      return "point left out";
    case BlunderFinding::Action::kControlReleased:
      return "control released";
    case BlunderFinding::Action::kKept:
      return "kept";
    case BlunderFinding::Action::kReadmitted:
      return "readmitted";
  }
  return "";
}

std::string DescribeFinding(const Block& block, const BlunderFinding& finding) {
  std::string text =
      "point " + std::string(block.points.ids[finding.point]) + ", w " + Short(finding.w_1) + ": ";
  std::string who;
  for (const std::uint64_t look : finding.looks) {
    who += (who.empty() ? "" : ", ") + block.passes[block.looks.pass[look]].id;
  }
  if (finding.control) who += who.empty() ? "its known position" : ", its known position";
  if (finding.located()) {
    text += finding.control ? who : (finding.azimuth ? "azimuth of " : "range of ") + who;
  } else {
    text += "one of " + who;
  }
  text += std::string("; ") + NameOf(finding.action);
  if (!finding.note.empty()) text += ": " + finding.note;
  return text;
}

namespace {

/// Above this v'Pv over the redundancy standard deviations mean nothing, unless they are scaled by
/// it.
constexpr double kGrossVariance_1 = 10.0;

/// Chance that observations without blunders fail their test.
constexpr double kObservationLevel_1 = 0.001;

/// Observations of one contradiction: where two looks determine a point, range and azimuth of both
/// have the same |w|.
constexpr double kMostOfOneContradiction_1 = 4.0;

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...) {
  std::array<char, 400> text{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

bool IsAdjusted(const AdjustResult& result) {
  return result.status == AdjustStatus::kConverged || result.status == AdjustStatus::kNotConverged;
}

bool IsGross(const AdjustOptions& options, const AdjustResult& result) {
  return IsAdjusted(result) && !options.scale_by_posterior &&
         result.sigma0_squared > kGrossVariance_1;
}

std::string GlobalTestReason(const AdjustOptions& options, const AdjustResult& result) {
  if (std::isnan(result.sigma0_squared) || result.chi_square_passed) return {};
  const double f = result.redundancy();
  const bool worse = result.sigma0_squared * f > result.chi_square.upper;
  return Format("global test: s0^2 is %.4g where %.4g to %.4g is expected (%.4g %%): ",
                result.sigma0_squared,
                result.chi_square.lower / f,
                result.chi_square.upper / f,
                100.0 * options.test_level) +
         (worse ? "the looks are noisier than stated, or there are blunders or errors of the "
                  "flights without a correction"
                : "standard deviations are stated too large, or the same measurements stand in "
                  "the block more than once");
}

std::string CheckReason(const AdjustOptions& options, const CheckSummary& checks) {
  if (checks.components == 0 || checks.realistic()) return {};
  const bool large = checks.chi_square > checks.chi_square_interval.upper;
  return Format(
             "check points: errors are %.3g times as large as predicted where %.3g to %.3g is "
             "expected (%.4g %%)",
             checks.error_ratio_1,
             checks.error_ratio_interval_1.lower,
             checks.error_ratio_interval_1.upper,
             100.0 * options.test_level) +
         (large ? ": errors of the flights without a correction, or check points of another frame "
                  "or source than the control points"
                : ": standard deviations are stated too large");
}

/// "range of S5 at T697", or the component of a control point.
std::string NameLargest(const Block& block,
                        const AdjustResult& result,
                        const QualitySummary& tests,
                        bool control) {
  if (control) {
    constexpr std::array<const char*, 3> kComponents = {"east (x)", "north (y)", "up (z)"};
    const ControlQuality& largest = result.control_quality[tests.worst_control];
    return std::string("control point ") + std::string(block.points.ids[largest.point]) + ", " +
           kComponents.at(static_cast<std::size_t>(largest.component));
  }
  const TestedLook& largest = tests.worst.front();
  return std::string(largest.azimuth ? "azimuth of " : "range of ") +
         block.passes[block.looks.pass[largest.look]].id + " at point " +
         std::string(block.points.ids[largest.point]);
}

std::string ObservationReason(const Block& block,
                              const AdjustOptions& options,
                              const AdjustResult& result) {
  const QualitySummary& tests = result.assessment.tests;
  if (tests.worst.empty() && std::isnan(tests.worst_control_w_1)) return {};
  const double look_w_1 = tests.worst.empty() ? 0.0 : std::abs(tests.worst.front().w_1);
  const double control_w_1 =
      std::isnan(tests.worst_control_w_1) ? 0.0 : std::abs(tests.worst_control_w_1);
  const bool control = control_w_1 > look_w_1;
  const double largest_w_1 = control ? control_w_1 : look_w_1;
  QualityOptions all;
  all.alpha_1 = kObservationLevel_1;
  all.family_wise = FamilyWise::kBonferroni;
  const ReliabilityFigures limits = MakeReliability(all, tests.figures.tests, result.redundancy());
  const bool tau = options.quality.test == BlunderTest::kTau;
  const bool beyond = tau ? std::abs(TauOf(largest_w_1, result)) > limits.critical_tau_1
                          : largest_w_1 > limits.critical_w_1;
  // More than chance allows stand beyond the critical value: of contradictions of at most four
  // observations each, as a Poisson count; P(N >= n) = P(chi-square of 2 n <= 2 mu).
  const auto above = static_cast<double>(tests.above());
  const double half = 2.0 / kMostOfOneContradiction_1;
  const bool crowded = above > 0.0 && ChiSquareProbability(half * tests.expected_above_1(),
                                                           half * above) < kObservationLevel_1;
  if (!beyond && !crowded) return {};
  return Format(
             "tests of observations: %zu of %zu are beyond the critical value, %.1f are "
             "expected by chance; the largest |w| is %.1f, ",
             tests.above(),
             tests.figures.tests,
             tests.expected_above_1(),
             largest_w_1) +
         NameLargest(block, result, tests, control) +
         ": blunders, exchanged points, or standard deviations that are too small";
}

}  // namespace

void Assess(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  Assessment& out = result->assessment;
  out.tests = SummariseQuality(block, options, *result);
  out.priors = SummarisePriors(options, *result);
  out.checks = SummariseChecks(*result, options.test_level);
  out.shares = SharesOf(block, *result);
  const bool gross = IsGross(options, *result);
  if (gross) {
    Refuse(result,
           Format("s0^2 is %.3g where 1 is expected, above %g: observations, control and priors "
                  "contradict each other so much that standard deviations mean nothing (a pass's "
                  "times, ranges or states, a control point, or the standard deviations given are "
                  "wrong)",
                  result->sigma0_squared,
                  kGrossVariance_1));
  }
  out.verdict = out.reasons.empty() ? Verdict::kAccepted : Verdict::kNotAccepted;
  if (result->status == AdjustStatus::kPredicted) return;
  for (std::string& reason :
       std::array<std::string, 4>{gross ? std::string() : GlobalTestReason(options, *result),
                                  CheckReason(options, out.checks),
                                  ObservationReason(block, options, *result),
                                  ContradictedPriors(*result)}) {
    if (reason.empty()) continue;
    out.reasons.push_back(std::move(reason));
    if (out.verdict == Verdict::kAccepted) out.verdict = Verdict::kTestsFailed;
  }
}

}  // namespace sarblock
