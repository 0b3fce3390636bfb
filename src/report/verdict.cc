// SPDX-License-Identifier: Apache-2.0
#include "verdict.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "html.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

std::string Brief(double value) { return ReadableNumber(value, 3); }

/// "in x" of a local frame, "east" of a geocentric one.
std::array<std::string, 3> AxisPhrases(const ReportSummary& summary) {
  std::array<std::string, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    out[k] = std::string(summary.geocentric ? "" : "in ") + AxisNames(summary)[k];
  }
  return out;
}

std::string Percent(double part) { return fmt::format("{:.0f} %", 100.0 * part); }

const char* Plural(double count) { return count == 1.0 ? "" : "s"; }

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

std::string StatusSentence(const ReportSummary& summary) {
  const std::string rounds = fmt::format("{:.0f} iterations", summary.iterations_1);
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
  return summary.accepted ? fmt::format("The adjustment converged in {} and is accepted.", rounds)
                          : fmt::format(
                                "The adjustment converged in {} but is not accepted, because a "
                                "test failed that was asked to decide (--strict).",
                                rounds);
}

void AddFit(const ReportSummary& summary, Verdict* out) {
  const GlobalTestFigures& test = summary.test;
  if (!test.given()) return;
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
  if (worse) {
    out->sentences.push_back(
        fmt::format("The looks fit worse than their standard deviations promise: residuals are {} "
                    "times as large ({}). {}",
                    Brief(ratio),
                    figures,
                    summary.scaled_by_posterior
                        ? "The standard deviations in this report have been scaled by this factor."
                        : "Either the looks are noisier than stated, or blunders or missing "
                          "corrections are left; until that is mended the standard deviations "
                          "below are too small by about this factor."));
  } else {
    out->sentences.push_back(fmt::format(
        "The looks fit better than their standard deviations promise: residuals are {} times as "
        "large ({}). Either the standard deviations of the looks were stated too large, and so are "
        "those below{}; or the same measurements stand in the block more than once, and those "
        "below "
        "are too small.",
        Brief(ratio),
        figures,
        summary.scaled_by_posterior ? " were, before they were scaled by this factor" : ""));
  }
}

void AddAccuracy(const ResultFolder& result, const AccuracyFigures& accuracy, Verdict* out) {
  if (accuracy.points == 0) {
    out->sentences.push_back("No covariance was computed, so nothing can be said of the accuracy.");
    return;
  }
  const std::array<std::string, 3> axes = AxisPhrases(result.summary);
  const auto weak = static_cast<std::size_t>(accuracy.weakest);
  out->sentences.push_back(
      fmt::format("Half of the {} points are known to {} or better, 95 % to {}; the weakest is {} "
                  "with {} m {} (one sigma).",
                  ReadableCount(static_cast<double>(accuracy.points)),
                  InAxes(accuracy.median_m, axes),
                  InAxes(accuracy.most_m, axes),
                  accuracy.largest_point[weak],
                  Brief(accuracy.largest_m[weak]),
                  axes[weak]));
}

void AddChecks(const ResultFolder& result, Verdict* out) {
  const auto& checks = result.summary.checks;
  if (!checks || checks->points_1 == 0.0) {
    if (result.summary.status == "converged") {
      out->sentences.push_back(
          "There are no check points, so nothing independent confirms this accuracy.");
    }
    return;
  }
  if (!checks->says.empty()) {
    out->sentences.push_back(
        fmt::format("{:.0f} check point{}: {}{}{}",
                    checks->points_1,
                    Plural(checks->points_1),
                    static_cast<char>(std::tolower(static_cast<unsigned char>(checks->says[0]))),
                    checks->says.substr(1),
                    checks->says.ends_with('.') ? "" : "."));
  }
}

void AddLimit(const ResultFolder& result, const AccuracyFigures& accuracy, Verdict* out) {
  if (accuracy.points == 0) return;
  const std::string axis = AxisPhrases(result.summary)[static_cast<std::size_t>(accuracy.weakest)];
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

void AddAttention(const ResultFolder& result, Verdict* out) {
  const ReportSummary& summary = result.summary;
  std::vector<std::string>& list = out->attention;
  if (summary.checks && summary.checks->points_1 > 0.0 && !summary.checks->realistic) {
    list.push_back(
        fmt::format("The errors of the check points are {} times as large as predicted: the "
                    "standard deviations are not realistic.",
                    Brief(summary.checks->error_ratio_1)));
  }
  if (result.points.unsolved_count > 0) {
    const auto count = static_cast<double>(result.points.unsolved_count);
    list.push_back(fmt::format("{} point{} could not be determined and {} left out.",
                               ReadableCount(count),
                               Plural(count),
                               count == 1.0 ? "was" : "were"));
  }
  if (summary.tests && summary.status == "converged") {
    const TestFigures& tests = *summary.tests;
    const double above = tests.above_1[0] + tests.above_1[1] + tests.above_1[2];
    if (above > tests.expected_above_1 + 3.0 * std::sqrt(std::max(1.0, tests.expected_above_1))) {
      list.push_back(
          fmt::format("{} observations stand beyond the critical value, {} are expected by chance: "
                      "look for blunders among the worst looks.",
                      ReadableCount(above),
                      Brief(tests.expected_above_1)));
    }
  }
  if (result.looks.rejected > 0) {
    std::string reasons;
    for (const auto& [reason, count] : result.looks.rejected_by_reason) {
      reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, reason);
    }
    list.push_back(fmt::format("{} of {} looks were left out ({}).",
                               ReadableCount(static_cast<double>(result.looks.rejected)),
                               ReadableCount(static_cast<double>(result.looks.count)),
                               reasons));
  }
  if (result.correlation_count > 0) {
    const auto count = static_cast<double>(result.correlation_count);
    list.push_back(
        fmt::format("{} pair{} of corrections {} correlated above {}: what they do together is "
                    "known better than each alone.",
                    ReadableCount(count),
                    Plural(count),
                    count == 1.0 ? "is" : "are",
                    kHighCorrelation_1));
  }
  if (!summary.warnings.empty()) {
    const auto count = static_cast<double>(summary.warnings.size());
    list.push_back(fmt::format(
        "The run gave {:.0f} warning{}, listed under Counts and settings.", count, Plural(count)));
  }
}

}  // namespace

Verdict JudgeResult(const ResultFolder& result, const AccuracyFigures& accuracy) {
  const ReportSummary& summary = result.summary;
  Verdict out;
  out.sentences.push_back(StatusSentence(summary));
  AddFit(summary, &out);
  AddAccuracy(result, accuracy, &out);
  AddChecks(result, &out);
  AddLimit(result, accuracy, &out);
  AddAttention(result, &out);
  const bool checks_fail = summary.checks && summary.checks->points_1 > 0.0 &&
                           summary.checks->components_1 > 0.0 && !summary.checks->realistic;
  const bool test_fails = summary.test.given() && !summary.test.passed;
  if (summary.status == "predicted") {
    out.state = VerdictState::kNeutral;
    out.word = "Predicted";
  } else if (summary.status == "intersected") {
    out.state = VerdictState::kNeutral;
    out.word = "Intersected";
  } else if (!summary.accepted) {
    out.state = VerdictState::kNotAccepted;
    out.word = summary.status == "not_converged" ? "Not accepted: not converged" : "Not accepted";
  } else if (checks_fail || test_fails || result.points.unsolved_count > 0) {
    out.state = VerdictState::kReservations;
    out.word = "Accepted, with reservations";
  } else {
    out.state = VerdictState::kAccepted;
    out.word = "Accepted";
  }
  return out;
}

}  // namespace sarblock
