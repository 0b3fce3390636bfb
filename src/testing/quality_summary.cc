// SPDX-License-Identifier: Apache-2.0
#include "quality_summary.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.h"
#include "suspects.h"

namespace sarblock {
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

}  // namespace sarblock
