// SPDX-License-Identifier: Apache-2.0
#include "montecarlo_report.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace sarblock {
namespace {

constexpr double kConfidence_1 = 0.99;

/// Sum and square sum of a figure over the runs.
struct RunSum {
  double sum = 0.0, square = 0.0;
  void Add(double value) {
    sum += value;
    square += value * value;
  }
  /// `least_variance` is what the figure has if the points of a run were independent: few runs may
  /// show less by chance (all points inside).
  [[nodiscard]] RunMean Mean(int runs, double expected, double least_variance) const {
    const double n = runs;
    RunMean out;
    out.expected_1 = expected;
    out.mean_1 = sum / n;
    const double variance = runs > 1 ? (square - sum * out.mean_1) / (n - 1.0) : least_variance;
    out.standard_error_1 = std::sqrt(std::max(variance, least_variance) / n);
    return out;
  }
};

/// The means over the runs, each of which averages its points.
void FillMeans(const MonteCarloDraws& draws, MonteCarloReport* report) {
  std::array<RunSum, 3> ratio, inside;
  RunSum square;
  for (const MonteCarloRun& run : draws.runs) {
    if (!run.converged) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      ratio[i].Add(run.variance_ratio_1[i]);
      inside[i].Add(run.inside_1[i]);
    }
    square.Add(run.square_1);
  }
  const auto count = static_cast<double>(draws.points.size());
  for (std::size_t i = 0; i < 3; ++i) {
    const double p = MonteCarloReport::kLevels[i];
    // Variances of a chi-square of one degree, of three over 3, of a yes or no.
    report->variance_ratio[i] = ratio[i].Mean(report->runs, 1.0, 2.0 / count);
    report->coverage[i] = inside[i].Mean(report->runs, p, p * (1.0 - p) / count);
  }
  report->square_ratio = square.Mean(report->runs, 1.0, 2.0 / 3.0 / count);
}

/// The figures of every point.
void FillPoints(const MonteCarloDraws& draws,
                const std::vector<SymmetricEnu>& covariance_m2,
                MonteCarloReport* report) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kElements{
      {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  const double runs = report->runs;
  const Interval allowed = ChiSquareInterval(kConfidence_1, 3.0 * runs);
  for (const MonteCarloPoint& sums : draws.points) {
    const SymmetricEnu& rigorous_m2 = covariance_m2[sums.point];
    for (std::size_t k = 0; k < 6; ++k) {
      const auto [i, j] = kElements[k];
      const double unit_m2 =
          i == j ? rigorous_m2[i] : std::sqrt(rigorous_m2[i]) * std::sqrt(rigorous_m2[j]);
      report->sample_m2[sums.point][k] = unit_m2 * (sums.product[k].Value() / runs);
    }
    const double square = sums.square.Value();
    if (!allowed.Contains(square)) ++report->points_outside;
    report->square_1[sums.point] = square / (3.0 * runs);
    for (std::size_t i = 0; i < 3; ++i) report->inside[i][sums.point] = sums.inside[i];
  }
}

std::string SentenceOf(const MonteCarloReport& report) {
  const RunMean& ratio = report.square_ratio;
  const bool agrees = ratio.Agrees() && std::all_of(report.coverage.begin(),
                                                    report.coverage.end(),
                                                    [](const RunMean& c) { return c.Agrees(); });
  const char* verdict = agrees                ? "the stated covariance is realistic"
                        : ratio.lower() > 1.0 ? "the stated covariance is too small"
                        : ratio.upper() < 1.0 ? "the stated covariance is too large"
                                              : "the errors are not as normal as stated";
  std::array<char, 400> text;
  std::snprintf(text.data(),
                text.size(),
                "%s: over %d runs the squared errors of %zu points are %.3f times what it says "
                "(99 %% confidence %.3f to %.3f), and its 50, 90 and 99 %% ellipsoids hold %.1f, "
                "%.1f and %.1f %% of them",
                verdict,
                report.runs,
                report.points,
                ratio.mean_1,
                ratio.lower(),
                ratio.upper(),
                100.0 * report.coverage[0].mean_1,
                100.0 * report.coverage[1].mean_1,
                100.0 * report.coverage[2].mean_1);
  return text.data();
}

}  // namespace

MonteCarloReport ReportMonteCarlo(const MonteCarloDraws& draws,
                                  std::uint64_t seed,
                                  const std::vector<SymmetricEnu>& covariance_m2) {
  MonteCarloReport report;
  report.seed = seed;
  report.points = draws.points.size();
  for (const MonteCarloRun& run : draws.runs) ++(run.converged ? report.runs : report.failed);
  report.sample_m2.assign(covariance_m2.size(), {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN});
  report.square_1.assign(covariance_m2.size(), kNaN);
  for (auto& inside : report.inside) inside.assign(covariance_m2.size(), 0);
  if (report.runs > 0 && report.points > 0) {
    FillPoints(draws, covariance_m2, &report);
    FillMeans(draws, &report);
  }
  report.sentence = report.runs > 0 ? SentenceOf(report) : "no run converged: nothing is shown";
  return report;
}

}  // namespace sarblock
