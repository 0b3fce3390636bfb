// SPDX-License-Identifier: Apache-2.0
#include "headline.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "html.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

std::string Brief(double value) { return ReadableNumber(value, 3); }

/// "in x" of a local frame, "east" of a geocentric one.
std::array<std::string, 3> AxisPhrases(const Frame& frame) {
  std::array<std::string, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool geocentric = frame.kind() == FrameKind::kGeocentric;
    out[k] = std::string(geocentric ? "" : "in ") + AxisNames(frame)[k];
  }
  return out;
}

std::string Percent(double part) { return fmt::format("{:.0f} %", 100.0 * part); }

const char* Plural(std::size_t count) { return count == 1 ? "" : "s"; }

/// "0.38 m in x, 1.6 m in y and 2.8 m in z"
std::string InAxes(const std::array<double, 3>& sigma_m, const std::array<std::string, 3>& axes) {
  return fmt::format("{} m {}, {} m {} and {} m {}",
                     Brief(sigma_m[0]),
                     axes[0],
                     Brief(sigma_m[1]),
                     axes[1],
                     Brief(sigma_m[2]),
                     axes[2]);
}

std::string StatusSentence(const ResultSummary& summary) {
  const std::string rounds = fmt::format("{} iterations", summary.iterations);
  if (summary.status == "not_converged") {
    return fmt::format(
        "The adjustment did not converge in {}: a step of {} sigma was still to go, so its numbers "
        "are those of an unfinished solution.",
        rounds,
        Brief(summary.remaining_step));
  }
  if (summary.status == "intersected") {
    return "Every point was intersected alone from its looks, with the flight paths taken as "
           "exact: the standard deviations hold the noise of the looks only.";
  }
  if (summary.status == "predicted") {
    return "This is a plan: the covariance follows from geometry and weights alone, nothing was "
           "measured, so there is nothing to accept or to reject.";
  }
  switch (summary.verdict) {
    case Verdict::kAccepted:
      return fmt::format("The adjustment converged in {} and every test is passed.", rounds);
    case Verdict::kTestsFailed:
      return fmt::format("The adjustment converged in {}, but tests failed: see below.", rounds);
    case Verdict::kNotAccepted:
      return fmt::format(
          "The adjustment converged in {} to a solution whose standard deviations mean nothing.",
          rounds);
  }
  return "";
}

void AddFit(const ResultSummary& summary, Headline* out) {
  if (!summary.chi_square) return;
  const ResultTest& test = *summary.chi_square;
  const double ratio = std::sqrt(test.sigma0_squared);
  const std::string figures = fmt::format("variance factor {}, {} to {} allowed at {}",
                                          Brief(test.sigma0_squared),
                                          Brief(test.lower / test.redundancy),
                                          Brief(test.upper / test.redundancy),
                                          Percent(test.level));
  if (test.passed) {
    out->sentences.push_back(
        fmt::format("The looks fit as well as their standard deviations promise ({}).", figures));
    return;
  }
  const bool worse = test.sigma0_squared * test.redundancy > test.upper;
  out->sentences.push_back(fmt::format(
      "The looks fit {} than their standard deviations promise: residuals are {} times as large "
      "({}); {}.",
      worse ? "worse" : "better",
      Brief(ratio),
      figures,
      summary.sigma_scaled_by_posterior
          ? "the standard deviations in this report have been scaled by this factor"
      : worse ? "until the cause is mended, the standard deviations below are too small by about "
                "this factor"
              : "those below may be too large"));
}

void AddAccuracy(const ResultFolder& result, const AccuracyFigures& accuracy, Headline* out) {
  if (accuracy.points == 0) {
    out->sentences.push_back("No covariance was computed, so nothing can be said of the accuracy.");
    return;
  }
  const std::array<std::string, 3> axes = AxisPhrases(result.file.frame);
  const auto weak = static_cast<std::size_t>(accuracy.weakest);
  out->sentences.push_back(
      fmt::format("Half of the {} points are known to {} or better, 95 % to {}; the weakest is {} "
                  "with {} m {} (one sigma).",
                  ReadableCount(accuracy.points),
                  InAxes(accuracy.median_m, axes),
                  InAxes(accuracy.most_m, axes),
                  accuracy.largest_point[weak],
                  Brief(accuracy.largest_m[weak]),
                  axes[weak]));
}

void AddChecks(const ResultFolder& result, Headline* out) {
  const auto& checks = result.file.summary.checks;
  if (!checks || checks->points == 0) {
    if (result.file.summary.status == "converged") {
      out->sentences.push_back(
          "There are no check points, so nothing independent confirms this accuracy.");
    }
    return;
  }
  if (checks->realistic && !checks->says.empty()) {  // else a reason of the verdict says it
    out->sentences.push_back(
        fmt::format("{} check point{}: {}{}{}",
                    checks->points,
                    Plural(checks->points),
                    static_cast<char>(std::tolower(static_cast<unsigned char>(checks->says[0]))),
                    checks->says.substr(1),
                    checks->says.ends_with('.') ? "" : "."));
  }
}

void AddLimit(const ResultFolder& result, const AccuracyFigures& accuracy, Headline* out) {
  if (accuracy.points == 0) return;
  const std::string axis =
      AxisPhrases(result.file.frame)[static_cast<std::size_t>(accuracy.weakest)];
  std::string text;
  if (!std::isnan(accuracy.path_part_1)) {
    const double part = accuracy.path_part_1;
    text = fmt::format(
        "What limits it: {}, the weakest component, {} of the variance comes from the flight "
        "paths and {} from the noise of the looks at their intersection angles (median {} "
        "degrees); ",
        axis,
        Percent(part),
        Percent(1.0 - part),
        Brief(accuracy.median_intersection_deg));
    text += part > 0.6 ? "control points or better paths would help most."
            : part < 0.4
                ? "only better looks, or looks that intersect at larger angles, would help."
                : "both would have to improve.";
  } else {
    text = fmt::format(
        "What limits it: {} is the weakest component, at a median intersection angle of {} "
        "degrees.",
        axis,
        Brief(accuracy.median_intersection_deg));
  }
  const AccuracyFigures::Group& weak = accuracy.weak;
  const AccuracyFigures::Group& all = accuracy.all;
  std::vector<std::string> facets;
  if (weak.median_intersection_deg < 0.8 * all.median_intersection_deg) {
    facets.push_back(
        fmt::format("intersect at {} degrees in the median", Brief(weak.median_intersection_deg)));
  }
  if (weak.median_looks_1 < all.median_looks_1) {
    facets.push_back(fmt::format(
        "have {:.0f} looks where {:.0f} are usual", weak.median_looks_1, all.median_looks_1));
  }
  if (weak.outside_control_1 > all.outside_control_1 + 0.2) {
    facets.push_back(fmt::format("lie to {} outside the control points, of all points {}",
                                 Percent(weak.outside_control_1),
                                 Percent(all.outside_control_1)));
  }
  if (!facets.empty() && weak.points >= 5) {
    text += " The weakest twentieth of the points ";
    for (std::size_t i = 0; i < facets.size(); ++i) {
      text += (i == 0 ? "" : (i + 1 == facets.size() ? " and " : ", ")) + facets[i];
    }
    text += ".";
  }
  out->sentences.push_back(text);
}

void AddAttention(const ResultFolder& result, Headline* out) {
  const ResultSummary& summary = result.file.summary;
  std::vector<std::string>& list = out->attention;
  for (const std::string& reason : summary.verdict_reasons) list.push_back(reason + ".");
  if (const std::size_t count = result.unsolved.size(); count > 0) {
    list.push_back(fmt::format("{} point{} could not be determined and {} left out.",
                               ReadableCount(count),
                               Plural(count),
                               count == 1 ? "was" : "were"));
  }
  if (result.looks.rejected > 0) {
    std::string reasons;
    for (const auto& [reason, count] : result.looks.rejected_by_reason) {
      reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, reason);
    }
    list.push_back(fmt::format("{} of {} looks were left out ({}).",
                               ReadableCount(result.looks.rejected),
                               ReadableCount(result.file.looks.size()),
                               reasons));
  }
  if (const std::size_t count = result.correlation_count; count > 0) {
    list.push_back(
        fmt::format("{} pair{} of corrections {} correlated above {}: what they do together is "
                    "known better than each alone.",
                    ReadableCount(count),
                    Plural(count),
                    count == 1 ? "is" : "are",
                    kHighCorrelation_1));
  }
  if (!summary.warnings.empty()) {
    const std::size_t count = summary.warnings.size();
    list.push_back(fmt::format(
        "The run gave {} warning{}, listed under Counts and settings.", count, Plural(count)));
  }
}

}  // namespace

Headline HeadlineOf(const ResultFolder& result, const AccuracyFigures& accuracy) {
  const ResultSummary& summary = result.file.summary;
  Headline out;
  out.sentences.push_back(StatusSentence(summary));
  AddFit(summary, &out);
  AddAccuracy(result, accuracy, &out);
  AddChecks(result, &out);
  AddLimit(result, accuracy, &out);
  AddAttention(result, &out);
  if (summary.status == "predicted") {
    out.state = HeadlineState::kNeutral;
    out.word = "Predicted";
  } else if (summary.status == "intersected") {
    out.state = HeadlineState::kNeutral;
    out.word = "Intersected";
  } else if (summary.verdict == Verdict::kNotAccepted) {
    out.state = HeadlineState::kNotAccepted;
    out.word = summary.status == "not_converged" ? "Not accepted: not converged" : "Not accepted";
  } else if (summary.verdict == Verdict::kTestsFailed) {
    out.state = HeadlineState::kTestsFailed;
    out.word = "Converged, tests failed";
  } else {
    out.state = HeadlineState::kAccepted;
    out.word = "Accepted";
  }
  return out;
}

}  // namespace sarblock
