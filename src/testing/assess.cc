// SPDX-License-Identifier: Apache-2.0
#include "assess.h"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>

#include "prior_quality.h"
#include "quality_summary.h"
#include "reliability.h"

namespace sarblock {
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
