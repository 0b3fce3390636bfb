// SPDX-License-Identifier: Apache-2.0
#include "headline.h"

#include <algorithm>
#include <cmath>

#include "advice.h"
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

/// What the global test says where it failed: by how much, and what that means for the figures.
std::string FitClause(const ResultSummary& summary) {
  if (!summary.chi_square || summary.chi_square->passed) return "";
  const ResultTest& test = *summary.chi_square;
  const bool worse = test.sigma0_squared * test.redundancy > test.upper;
  return fmt::format("; residuals are {} times as large as stated, {}",
                     Brief(std::sqrt(test.sigma0_squared)),
                     summary.sigma_scaled_by_posterior
                         ? "by which the standard deviations of this report are scaled"
                     : worse ? "and the standard deviations too small by about this factor"
                             : "and the standard deviations may be too large");
}

/// What check points say of an accepted accuracy. Where they contradict, a reason says it.
std::string CheckClause(const ResultSummary& summary) {
  if (!summary.checks || summary.checks->points == 0) {
    return "; without check points nothing independent confirms the accuracy";
  }
  if (!summary.checks->realistic) return "";
  return fmt::format("; {} check point{} agree{} with the predicted accuracy",
                     summary.checks->points,
                     Plural(summary.checks->points),
                     summary.checks->points == 1 ? "s" : "");
}

std::string StatusSentence(const ResultSummary& summary) {
  const std::string rounds =
      fmt::format("{} iteration{}", summary.iterations, Plural(summary.iterations));
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
      return fmt::format("The adjustment converged in {} and every test is passed{}.",
                         rounds,
                         CheckClause(summary));
    case Verdict::kTestsFailed:
      return fmt::format("The adjustment converged in {}, but tests failed{}{}.",
                         rounds,
                         FitClause(summary),
                         CheckClause(summary));
    case Verdict::kNotAccepted:
      return fmt::format(
          "The adjustment converged in {} to a solution whose standard deviations mean nothing.",
          rounds);
  }
  return "";
}

void AddAccuracy(const ResultFolder& result, const AccuracyFigures& accuracy, Headline* out) {
  if (accuracy.points == 0) {
    out->sentences.push_back("No covariance was computed, so nothing can be said of the accuracy.");
    return;
  }
  const std::array<std::string, 3> axes = AxisPhrases(result.file.frame);
  if (accuracy.free_points == 0) {
    out->sentences.push_back(
        fmt::format("Control or a single look decides every point, so the standard deviations (in "
                    "the median {}) say nothing of the block.",
                    InAxes(accuracy.median_m, axes)));
    return;
  }
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
  AddAccuracy(result, accuracy, &out);
  // Of a solution that is not accepted nothing follows but its reasons.
  if (summary.verdict != Verdict::kNotAccepted || summary.status == "predicted") {
    Advice advice = AdviceOf(accuracy, result.file.frame);
    out.would_help = advice.would_help;
    if (!advice.sentence.empty()) out.sentences.push_back(std::move(advice.sentence));
  }
  AddAttention(result, &out);
  if (summary.status == "predicted") {
    out.state = HeadlineState::kNeutral;
    out.word = "Predicted";
    return out;
  }
  const bool intersected = summary.status == "intersected";
  switch (summary.verdict) {
    case Verdict::kAccepted:
      out.state = HeadlineState::kAccepted;
      out.word = intersected ? "Intersected, accepted" : "Accepted";
      break;
    case Verdict::kTestsFailed:
      out.state = HeadlineState::kTestsFailed;
      out.word = intersected ? "Intersected, tests failed" : "Converged, tests failed";
      break;
    case Verdict::kNotAccepted:
      out.state = HeadlineState::kNotAccepted;
      out.word = intersected                         ? "Intersected, not accepted"
                 : summary.status == "not_converged" ? "Not accepted: not converged"
                                                     : "Not accepted";
      break;
  }
  return out;
}

}  // namespace sarblock
