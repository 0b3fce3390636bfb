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
#include "covariance.h"
#include "model/priors.h"
#include "verdict_tests.h"
#include <Eigen/Core>

namespace sarblock {

BlunderSizes::BlunderSizes(const Block& block,
                           const AdjustOptions& options,
                           const AdjustResult& result,
                           double factor)
    : block_(block),
      result_(result),
      delta0_(result.quality.empty() && result.control_quality.empty()
                  ? kNotGiven
                  : ReliabilityOf(options, result).delta0),
      scale_(std::sqrt(factor)),
      sigma_factors_(block.passes.size(), {1.0, 1.0}) {
  if (result.variance_components) {
    sigma_factors_ = SigmaFactors(result.variance_components->components, block.passes.size());
  }
}

std::array<BlunderSize, 2> BlunderSizes::LookSizes(std::uint64_t look, std::size_t point) const {
  const LookQuality& quality = result_.quality;
  const std::array<double, 2>& factor = sigma_factors_[block_.looks.pass[look]];
  std::array<BlunderSize, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto redundancy = static_cast<double>(quality.redundancy[k][look]);
    if (std::isnan(redundancy)) continue;
    const double given_m = k == 0 ? block_.SigmaOf(look).range_m
                                  : AzimuthSigma_m(block_, look, result_.points.position_m[point]);
    out[k].sigma_m = factor[k] * given_m;
    out[k].detectable_m = MinimalDetectable(delta0_, scale_ * out[k].sigma_m, redundancy);
    out[k].influence_m =
        Influence_m(delta0_, scale_ * static_cast<double>(quality.shift_m[k][look]), redundancy);
  }
  return out;
}

BlunderSize BlunderSizes::ControlSize(const ControlQuality& control) const {
  const KnownPosition& known = *block_.points.FindKnown(control.point);
  BlunderSize out;
  out.sigma_m = std::sqrt(known.covariance_enu_m2(control.component, control.component));
  out.detectable_m = MinimalDetectable(delta0_, scale_ * out.sigma_m, control.redundancy);
  out.influence_m = Influence_m(delta0_, scale_ * control.shift_m, control.redundancy);
  return out;
}

void ScaleByPosterior(const AdjustOptions& options, AdjustResult* result) {
  const double factor = PosteriorFactor(options, *result);
  if (factor == 1.0) return;
  result->posterior_factor = factor;
  const auto scale = [factor](auto* covariance_m2) {
    for (double& element_m2 : *covariance_m2) element_m2 *= factor;
  };
  for (SymmetricEnu& of_point : result->points.covariance_m2) scale(&of_point);
  for (SymmetricEnu& of_point : result->points.fixed_path_covariance_m2) scale(&of_point);
  for (PairResult& pair : result->pairs) scale(&pair.covariance_m2);
  for (ParameterResult& parameter : result->parameters) parameter.sigma *= std::sqrt(factor);
  for (ParameterCovariance& entry : result->parameter_covariance) entry.covariance *= factor;
  // v'Pv over the factor is (t + curvature t^2)^2 at t of the new standard deviations.
  for (CorrectionCurvature& of : result->curvatures) of.curvature *= std::sqrt(factor);
  for (StripStation& station : result->strips) station.correction_sigma_m *= std::sqrt(factor);
  if (result->montecarlo) {
    for (std::array<double, 6>& of_point : result->montecarlo->sample_m2) scale(&of_point);
  }
}

PriorSummary SummarisePriors(const AdjustOptions& options, const AdjustResult& result) {
  PriorSummary out;
  const ReliabilityFigures figures = ReliabilityOf(options, result);
  const bool tau = options.quality.test == BlunderTest::kTau;
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const PriorTest& test = tests[i];
    if (std::isnan(test.redundancy)) continue;
    out.redundancy = (out.priors++ == 0 ? 0.0 : out.redundancy) + test.redundancy;
    if (std::isnan(test.w)) continue;
    ++out.tested;
    const double statistic = std::abs(tau ? TauOf(test.w, result) : test.w);
    out.above += statistic > (tau ? figures.critical_tau : figures.critical_w) ? 1U : 0U;
    if (out.tested == 1 || std::abs(test.w) > std::abs(out.worst_w)) {
      out.worst = i;
      out.worst_w = test.w;
    }
  }
  out.expected_above = figures.alpha_one * static_cast<double>(out.tested);
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
      const auto r = static_cast<double>(result.quality.redundancy[k][i]);
      const auto w = static_cast<double>(result.quality.w[k][i]);
      if (std::isnan(r)) continue;
      counts = true;
      share.redundancy += r;
      // v^2 = w^2 r in units of sigma; without redundancy there is no residual either.
      if (!std::isnan(w)) share.square_sum += w * w * r;
    }
    share.looks += counts ? 1U : 0U;
  }
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const PriorTest& test = tests[i];
    if (std::isnan(test.redundancy)) continue;
    PassShare& share = share_of(result.parameters[i].owner);
    share.prior_redundancy += test.redundancy;
    if (!std::isnan(test.square)) share.prior_square_sum += test.square;
  }
  return out;
}

namespace {

constexpr std::size_t kMaxWorst = 10;

double MedianOf(std::vector<float> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](float v) { return std::isnan(v); }),
               values.end());
  return static_cast<double>(Median(std::move(values)));
}

/// A statistic beyond its critical value.
bool IsAbove(double w,
             const AdjustOptions& options,
             const AdjustResult& result,
             const ReliabilityFigures& figures) {
  return options.quality.test == BlunderTest::kTau
             ? std::abs(TauOf(w, result)) > figures.critical_tau
             : std::abs(w) > figures.critical_w;
}

void KeepWorst(const TestedLook& look, std::vector<TestedLook>* worst) {
  const auto larger = [](const TestedLook& a, const TestedLook& b) {
    return std::abs(a.w) > std::abs(b.w);
  };
  if (worst->size() == kMaxWorst && !larger(look, worst->back())) return;
  worst->insert(std::upper_bound(worst->begin(), worst->end(), look, larger), look);
  if (worst->size() > kMaxWorst) worst->pop_back();
}

std::string Percent(double part) { return Digits(100.0 * part, 4) + " %"; }

std::string Short(double value) { return Digits(value, 3); }

/// A redundancy below this is rounding of single precision.
constexpr double kLeastRedundancy = 1e-6;

/// The observation of a kind that others check least.
class LeastChecked {
 public:
  /// An observation of which an error of one sigma moves its point by `shift_m`.
  void Add(std::size_t index, double redundancy, double shift_m) {
    if (std::isnan(redundancy)) return;
    ++figures_.count;
    figures_.hardly += redundancy < CheckedObservations::kHardly ? 1U : 0U;
    // Influence of the least detectable blunder on the point, in units of delta0.
    const double influence_m = redundancy > kLeastRedundancy
                                   ? shift_m / std::sqrt(redundancy)
                                   : std::numeric_limits<double>::infinity();
    if (influence_m <= largest_m_) return;
    largest_m_ = influence_m;
    index_ = index;
    figures_.redundancy = redundancy;
  }
  [[nodiscard]] bool empty() const { return figures_.count == 0; }
  [[nodiscard]] std::size_t index() const { return index_; }
  [[nodiscard]] CheckedObservations Figures(std::uint32_t point,
                                            std::uint32_t part,
                                            const BlunderSize& size) const {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const bool found = figures_.redundancy > kLeastRedundancy;
    CheckedObservations out = figures_;
    out.point = point;
    out.part = part;
    out.blunder_m = found ? size.detectable_m : kNone;
    out.shift_m = found ? size.influence_m : kNone;
    return out;
  }

 private:
  CheckedObservations figures_;
  std::size_t index_ = 0;
  double largest_m_ = -1.0;
};

std::array<CheckedObservations, 3> CheckedBy(const Block& block,
                                             const AdjustOptions& options,
                                             const AdjustResult& result) {
  std::array<CheckedObservations, 3> out;
  const BlunderSizes sizes(block, options, result, 1.0);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::vector<float>& redundancy = result.quality.redundancy[k];
    LeastChecked least;
    for (std::size_t i = 0; i < redundancy.size(); ++i) {
      least.Add(
          i, static_cast<double>(redundancy[i]), static_cast<double>(result.quality.shift_m[k][i]));
    }
    if (least.empty()) continue;
    const std::size_t point = block.looks.PointOf(least.index());
    out[k] = least.Figures(static_cast<std::uint32_t>(point),
                           block.looks.pass[least.index()],
                           sizes.LookSizes(least.index(), point)[k]);
  }
  LeastChecked least;
  for (std::size_t i = 0; i < result.control_quality.size(); ++i) {
    least.Add(i, result.control_quality[i].redundancy, result.control_quality[i].shift_m);
  }
  if (least.empty()) return out;
  const ControlQuality& control = result.control_quality[least.index()];
  out[2] = least.Figures(
      control.point, static_cast<std::uint32_t>(control.component), sizes.ControlSize(control));
  return out;
}

}  // namespace

ReliabilityFigures ReliabilityOf(const AdjustOptions& options, const AdjustResult& result) {
  return MakeReliability(
      options.quality,
      CountTests(result.quality, result.control_quality),
      std::isnan(result.test_redundancy) ? result.redundancy() : result.test_redundancy);
}

double TauOf(double w, const AdjustResult& result) { return w / std::sqrt(result.sigma0_squared); }

namespace {

/// On the nominal path, the point of the look at `p_m`; NaN where its time is not on the path.
TimeRates RatesOf(const Block& block, std::uint64_t look, const Eigen::Vector3d& p_m) {
  const auto motion = block.passes[block.looks.pass[look]].path.At(block.looks.time_s[look]);
  if (!motion) return {kNotGiven, kNotGiven, kNotGiven};
  return LookTimeRates(
      p_m, motion->position_m, motion->velocity_mps, motion->acceleration_mps2, block.ConeOf(look));
}

}  // namespace

std::array<double, 2> InRaster(const Block& block,
                               std::uint64_t look,
                               const Eigen::Vector3d& p_m,
                               const std::array<double, 2>& shift_m) {
  const std::optional<ImageGrid>& image = block.passes[block.looks.pass[look]].image;
  if (!image) return {kNotGiven, kNotGiven};
  const auto pixel_m = SlantRangePerPixel_m(*image, block.Measured(look));
  const TimeRates rates = RatesOf(block, look, p_m);
  const double metre_s = 1.0 / (block.MeasuresDoppler(look) ? -rates.doppler_mps : rates.along_mps);
  return {shift_m[0] / pixel_m.value_or(kNotGiven), shift_m[1] * metre_s / image->line_interval_s};
}

double AzimuthSigma_m(const Block& block, std::uint64_t look, const Eigen::Vector3d& p_m) {
  const LookSigma sigma = block.SigmaOf(look);
  if (sigma.azimuth_unit == AzimuthUnit::kMetres) return sigma.azimuth;
  if (!block.MeasuresDoppler(look)) return sigma.azimuth * RatesOf(block, look, p_m).along_mps;
  const auto motion = block.passes[block.looks.pass[look]].path.At(block.looks.time_s[look]);
  return motion ? block.ApproximateAzimuthSigma_m(look, motion->velocity_mps.norm()) : kNotGiven;
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
      if (!std::isnan(result.quality.w[0][i])) out.looks_not_localisable += alone;
      for (std::size_t k = 0; k < 2; ++k) {
        const auto w = static_cast<double>(result.quality.w[k][i]);
        if (std::isnan(w)) continue;
        ++out.looks_tested[k];
        if (!measured) continue;
        out.looks_above[k] += IsAbove(w, options, result, out.figures) ? 1U : 0U;
        const auto r = static_cast<double>(result.quality.redundancy[k][i]);
        KeepWorst({i, point, k == 1, w, r}, &out.worst);
      }
    }
  }
  for (std::size_t i = 0; i < result.control_quality.size(); ++i) {
    const ControlQuality& control = result.control_quality[i];
    if (std::isnan(control.w)) continue;
    ++out.control_tested;
    if (!measured) continue;
    if (!(std::abs(control.w) <= std::abs(out.worst_control_w))) {
      out.worst_control = i;
      out.worst_control_w = control.w;
    }
    out.control_above += IsAbove(control.w, options, result, out.figures) ? 1U : 0U;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    out.median_redundancy[k] = MedianOf(result.quality.redundancy[k]);
  }
  out.checked = CheckedBy(block, options, result);
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
  out.freedom = std::isnan(result.check_freedom) ? n : result.check_freedom;
  out.chi_square_interval = ChiSquareInterval(level, out.freedom);
  out.chi_square_interval.lower *= n / out.freedom;
  out.chi_square_interval.upper *= n / out.freedom;
  out.error_ratio = std::sqrt(out.chi_square / n);
  out.error_ratio_interval = {std::sqrt(out.chi_square_interval.lower / n),
                              std::sqrt(out.chi_square_interval.upper / n)};
  return out;
}

std::string DescribeChecks(const CheckSummary& summary, double level) {
  if (summary.components == 0) return "";
  const bool large = summary.chi_square > summary.chi_square_interval.upper;
  std::string text = summary.realistic() ? "the predicted accuracy is realistic"
                     : large             ? "the predicted accuracy is TOO OPTIMISTIC"
                                         : "the predicted accuracy is too pessimistic";
  text += ": errors of check points are " + Short(summary.error_ratio) +
          " times as large as predicted, " + Short(summary.error_ratio_interval.lower) + " to " +
          Short(summary.error_ratio_interval.upper) + " is expected (" + Percent(level) + ", " +
          Short(summary.freedom) + " independent components); " +
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
      "point " + std::string(block.points.ids[finding.point]) + ", w " + Short(finding.w) + ": ";
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
constexpr double kGrossVariance = 10.0;

/// Observations of one contradiction: where two looks determine a point, range and azimuth of both
/// have the same |w|.
constexpr double kMaxSingleContradiction = 4.0;

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

/// Variance factor of looks and control, or of all observations with priors where that is larger.
double GrossFactor(const AdjustResult& result) {
  double factor = result.sigma0_squared;
  for (const ObservationGroup& group : result.assessment.groups) {
    if (group.name == "all") factor = std::fmax(factor, group.factor());
  }
  return factor;
}

bool IsGross(const AdjustOptions& options, const AdjustResult& result) {
  return IsAdjusted(result) && !options.scale_by_posterior && GrossFactor(result) > kGrossVariance;
}

constexpr const char* kLarger =
    "the looks are noisier than stated, or there are blunders or errors of the flights without a "
    "correction";
constexpr const char* kSmaller =
    "standard deviations are stated too large, or the same measurements stand in the block more "
    "than once";

std::string GlobalTestReason(const AdjustOptions& options, const AdjustResult& result) {
  if (std::isnan(result.sigma0_squared) || result.chi_square_passed) return {};
  const double f = result.test_redundancy;
  const bool worse = result.sigma0_squared * f > result.chi_square.upper;
  return Format(
             "global test: s0^2 is %.4g where %.4g to %.4g is expected (%.4g %% for all tests): ",
             result.sigma0_squared,
             result.chi_square.lower / f,
             result.chi_square.upper / f,
             100.0 * options.test_level) +
         (worse ? kLarger : kSmaller);
}

/// Ranges, azimuths and control that do not agree with their standard deviations.
std::string GroupReason(const AdjustResult& result) {
  std::string text;
  bool worse = false;
  for (const ObservationGroup& group : result.assessment.groups) {
    if (group.name == "priors" || group.name == "all" || group.agrees()) continue;
    worse = worse || group.factor() > group.band.upper;
    text += (text.empty() ? "" : ", ") + group.name +
            Format(" %.4g where %.4g to %.4g is expected",
                   group.factor(),
                   group.band.lower,
                   group.band.upper);
  }
  if (text.empty()) return {};
  return "variance factors of " + text + ": " + (worse ? kLarger : kSmaller);
}

std::string ControlReason(const Block& block, const AdjustResult& result) {
  std::size_t control = 0;
  for (const KnownPosition& known : block.points.known) {
    if (block.points.role[known.point] != PointRole::kControl) continue;
    ++control;
    const auto begin = block.looks.offsets[known.point], end = block.looks.offsets[known.point + 1];
    for (auto look = begin; look < end; ++look) {
      if (!block.looks.rejected(look)) return {};
    }
  }
  if (control == 0 || !IsAdjusted(result)) return {};
  return Format(
      "control: none of %zu control points has a look that takes part, so nothing holds the "
      "block to them: their names are others in the observations, or their looks are "
      "rejected or missing",
      control);
}

/// How many times wider the priors are than the corrections that came out, as a group, where looks
/// and control are as they are stated; nothing where it may be less than kPriorsThatMatter.
std::optional<double> WidthOfPriors(const AdjustOptions& options, const AdjustResult& result) {
  if (!result.chi_square_passed || !GroupReason(result).empty()) return std::nullopt;
  constexpr double kFactor = kPriorsThatMatter * kPriorsThatMatter;
  const double chance = 1.0 - LevelOfOneTest(options.test_level);
  for (const ObservationGroup& group : result.assessment.groups) {
    if (group.name != "priors" || !(group.square_sum > 0.0)) continue;
    if (kFactor * group.square_sum > ChiSquareQuantile(chance, group.redundancy)) continue;
    return 1.0 / std::sqrt(group.factor());
  }
  return std::nullopt;
}

/// `width`: of priors that explain why errors are smaller than predicted (WidthOfPriors).
std::string CheckReason(const AdjustOptions& options,
                        const CheckSummary& checks,
                        std::optional<double> width) {
  if (checks.components == 0 || checks.realistic()) return {};
  std::string why = "standard deviations are stated too large";
  if (checks.chi_square > checks.chi_square_interval.upper) {
    why =
        "errors of the flights without a correction, or check points of another frame or source "
        "than the control points";
  } else if (width) {
    why = Format(
        "priors of the corrections that are %.3g times wider than what came out make standard "
        "deviations of points too large",
        *width);
  }
  return Format(
             "check points: errors are %.3g times as large as predicted where %.3g to %.3g is "
             "expected (%.4g %%): ",
             checks.error_ratio,
             checks.error_ratio_interval.lower,
             checks.error_ratio_interval.upper,
             100.0 * LevelOfOneTest(options.test_level)) +
         why;
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
  if (tests.worst.empty() && std::isnan(tests.worst_control_w)) return {};
  const double look_w = tests.worst.empty() ? 0.0 : std::abs(tests.worst.front().w);
  const double control_w =
      std::isnan(tests.worst_control_w) ? 0.0 : std::abs(tests.worst_control_w);
  const bool control = control_w > look_w;
  const double largest_w = control ? control_w : look_w;
  QualityOptions all;
  all.alpha = 1.0 - LevelOfOneTest(options.test_level);
  all.family_wise = FamilyWise::kBonferroni;
  const ReliabilityFigures limits =
      MakeReliability(all, tests.figures.tests, result.test_redundancy);
  const bool tau = options.quality.test == BlunderTest::kTau;
  const bool beyond = tau ? std::abs(TauOf(largest_w, result)) > limits.critical_tau
                          : largest_w > limits.critical_w;
  // More than chance allows are beyond the critical value: of contradictions of at most four
  // observations each, as a Poisson count; P(N >= n) = P(chi-square of 2 n <= 2 mu).
  const auto above = static_cast<double>(tests.above());
  const double half = 2.0 / kMaxSingleContradiction;
  const bool crowded =
      above > 0.0 && ChiSquareProbability(half * tests.expected_above(), half * above) < all.alpha;
  if (!beyond && !crowded) return {};
  return Format(
             "tests of observations: %zu of %zu are beyond the critical value, %.1f are "
             "expected by chance; the largest |w| is %.1f, ",
             tests.above(),
             tests.figures.tests,
             tests.expected_above(),
             largest_w) +
         NameLargest(block, result, tests, control) +
         ": blunders, exchanged points, or standard deviations that are too small";
}

}  // namespace

void Assess(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  Assessment& out = result->assessment;
  out.tests = SummariseQuality(block, options, *result);
  out.priors = SummarisePriors(options, *result);
  out.checks = SummariseChecks(*result, LevelOfOneTest(options.test_level));
  out.shares = SharesOf(block, *result);
  if (options.pairs == PairChoice::kDistances) {
    out.differences = SummariseDifferences(block, *result);
  }
  const bool gross = IsGross(options, *result);
  if (gross) {
    Refuse(result,
           Format("s0^2 is %.3g where 1 is expected, above %g: observations, control and priors "
                  "contradict each other so much that standard deviations mean nothing (a pass's "
                  "times, ranges or states, a control point, or the standard deviations given are "
                  "wrong)",
                  GrossFactor(*result),
                  kGrossVariance));
  }
  out.verdict = out.reasons.empty() ? Verdict::kAccepted : Verdict::kNotAccepted;
  if (result->status == AdjustStatus::kPredicted) return;
  const PriorFindings priors = TestPriors(*result, options.test_level);
  // Errors below what wide priors let expect are no mistake of the block.
  const bool nearer = out.checks.chi_square < out.checks.chi_square_interval.lower;
  const std::optional<double> width = nearer ? WidthOfPriors(options, *result) : std::nullopt;
  std::string of_checks = CheckReason(options, out.checks, width);
  if (width) Warn(result, std::exchange(of_checks, {}));
  for (std::string& reason :
       std::array<std::string, 6>{priors.reason,
                                  gross ? std::string() : GlobalTestReason(options, *result),
                                  gross ? std::string() : GroupReason(*result),
                                  ControlReason(block, *result),
                                  std::move(of_checks),
                                  ObservationReason(block, options, *result)}) {
    if (reason.empty()) continue;
    out.reasons.push_back(std::move(reason));
    if (out.verdict == Verdict::kAccepted) out.verdict = Verdict::kTestsFailed;
  }
  if (!priors.note.empty()) Warn(result, priors.note);
  if (const std::string empty = EmptyPriors(*result); !empty.empty()) Warn(result, empty);
}

}  // namespace sarblock
