// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "mistakes.h"
#include "sample.h"

namespace sarblock {
namespace {

/// Chance that residuals which are noise show a pattern, all tests of a block together.
constexpr double kPatternLevel = 1e-3;
/// Looks of a pass from which on it is tested.
constexpr std::size_t kFewestLooks = 12;
/// Fourth moment from which on tails are heavy: that of Student's t with nine degrees of freedom.
constexpr double kHeavyTails = 4.2;
/// Median size of a standard normal error, and the part of it that most errors have at least.
constexpr double kMedianOfNormal = 0.6745, kPartOfMedian = 0.4;
/// v'Pv over redundancy of all but the worst points below which these alone are as large as is
/// said: a factor of five, which heavy tails do not make.
constexpr double kSmallWithoutWorst = 0.04;
/// Part of its own error that a residual has to show to be looked at.
constexpr double kShownPart = 0.02;

/// A residual of a look: v in units of its standard deviation times the square root of its
/// redundancy, its weight in a sum of errors, and where it was measured.
struct Residual {
  double v = 0.0, r = 0.0;
  double sigma_m = 0.0;
  double time_s = 0.0, range_m = 0.0;
  [[nodiscard]] double w() const { return v / std::sqrt(r); }
};

struct Found {
  double statistic = 0.0;  ///< standard normal without a pattern
  std::string text;
};

/// sum x v over its standard deviation, x less its weighted mean, and the slope of v/r on x.
struct Trend {
  double statistic = 0.0, slope = 0.0;
};

template <typename Place>
Trend TrendOn(const std::vector<Residual>& residuals, const Place& place) {
  double weight = 0.0, mean = 0.0;
  for (const Residual& r : residuals) {
    weight += r.r;
    mean += r.r * place(r);
  }
  mean /= weight;
  double product = 0.0, square = 0.0;
  for (const Residual& r : residuals) {
    const double x = place(r) - mean;
    product += x * r.v;
    square += x * x * r.r;
  }
  if (!(square > 0.0)) return {};
  return {product / std::sqrt(square), product / square};
}

double MeanSigma_m(const std::vector<Residual>& residuals) {
  double sum = 0.0;
  for (const Residual& r : residuals) sum += r.sigma_m;
  return sum / static_cast<double>(residuals.size());
}

template <typename Place>
double ExtentOf(const std::vector<Residual>& residuals, const Place& place) {
  double least = place(residuals.front()), most = least;
  for (const Residual& r : residuals) {
    least = std::min(least, place(r));
    most = std::max(most, place(r));
  }
  return most - least;
}

std::string Metres(double value_m) { return Digits(std::abs(value_m), 2) + " m"; }

/// Tests of one component of a pass, and what they say of all passes.
constexpr std::size_t kTestsOfPass = 5, kOfNeighbours = 4;
constexpr std::array<const char*, kTestsOfPass> kCommon = {
    "have one sign",
    "have a trend with range",
    "have a trend along the strips",
    "bend along the strips",
    "that follow each other in time are alike: their errors are correlated along the strips"};

/// All tests of one component of one pass.
std::vector<Found> TestsOfPass(std::vector<Residual> residuals, const std::string& who) {
  std::vector<Found> out;
  if (residuals.size() < kFewestLooks) return out;
  std::sort(residuals.begin(), residuals.end(), [](const Residual& a, const Residual& b) {
    return a.time_s < b.time_s;
  });
  const double sigma_m = MeanSigma_m(residuals);
  const auto range = [](const Residual& r) { return r.range_m; };
  const auto time = [](const Residual& r) { return r.time_s; };
  double sum = 0.0, weight = 0.0, neighbours = 0.0, pairs = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    sum += residuals[i].v;
    weight += residuals[i].r;
    if (i == 0) continue;
    // Of a point that both see no error is alike in two looks of one pass.
    neighbours +=
        std::clamp(residuals[i - 1].w(), -3.0, 3.0) * std::clamp(residuals[i].w(), -3.0, 3.0);
    pairs += 1.0;
  }
  out.push_back({sum / std::sqrt(weight),
                 "residuals of the " + who + " have one sign, " + Metres(sigma_m * sum / weight) +
                     " in the mean"});
  const Trend by_range = TrendOn(residuals, range);
  out.push_back(
      {by_range.statistic,
       "residuals of the " + who + (by_range.slope > 0.0 ? " rise" : " fall") + " with range, " +
           Metres(sigma_m * by_range.slope * ExtentOf(residuals, range)) + " from near to far"});
  const Trend by_time = TrendOn(residuals, time);
  out.push_back({by_time.statistic,
                 "residuals of the " + who + (by_time.slope > 0.0 ? " rise" : " fall") +
                     " along the strip, " +
                     Metres(sigma_m * by_time.slope * ExtentOf(residuals, time)) +
                     " from its start to its end"});
  const double middle_s = 0.5 * (residuals.front().time_s + residuals.back().time_s);
  const double half_s = 0.5 * (residuals.back().time_s - residuals.front().time_s);
  const auto square = [&](const Residual& r) {
    const double t = (r.time_s - middle_s) / half_s;
    return t * t;
  };
  const Trend by_square = TrendOn(residuals, square);
  out.push_back({by_square.statistic,
                 "residuals of the " + who + " bend along the strip, " +
                     Metres(sigma_m * by_square.slope) + " from its middle to its ends"});
  // Corrections follow the mean and the trend of a pass and leave neighbours unlike.
  out.push_back({neighbours / std::sqrt(pairs),
                 "residuals of the " + who +
                     " that follow each other in time are alike: their "
                     "errors are correlated along the strip"});
  return out;
}

/// One of the tests of all passes together: what all have in common is no matter of one.
struct Pooled {
  double sum = 0.0;
  int passes = 0;
  void Add(double statistic) {
    sum += statistic;
    ++passes;
  }
  [[nodiscard]] double statistic() const { return sum / std::sqrt(std::max(1, passes)); }
};

/// Normal errors have a fourth moment of 3. Tails do not make errors `much_larger` than stated
/// while most of them are as large as is said now.
Found TestOfTails(const std::vector<double>& tests, bool much_larger, const char* who) {
  double fourth = 0.0, second = 0.0;
  for (const double w : tests) {
    second += w * w;
    fourth += w * w * w * w;
  }
  const auto n = static_cast<double>(tests.size());
  const double moment = n * fourth / (second * second);
  std::vector<double> sizes(tests);
  for (double& size : sizes) size = std::abs(size);
  const bool of_most = much_larger && Median(std::move(sizes)) > kPartOfMedian * kMedianOfNormal;
  // All residuals of a point with two looks are one.
  const double shown = moment > kHeavyTails && !of_most ? moment - 3.0 : 0.0;
  return {shown / std::sqrt(48.0 / n),
          std::string("errors of the ") + who + " have heavy tails, a fourth moment of " +
              Digits(moment, 3) + " where noise has 3: blunders, or robust = \"huber\""};
}

}  // namespace

std::string FindPattern(const Block& block,
                        const std::vector<std::uint32_t>& suspects,
                        const SampleResiduals& residuals,
                        bool much_larger) {
  // Points that are in the sample because they are the worst of all are no part of a distribution.
  std::vector<std::uint8_t> chosen(block.looks.size(), 0);
  for (const std::uint32_t point : suspects) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      chosen[i] = 1;
    }
  }
  std::vector<Found> tests;
  for (const Eigen::Index component : {0, 1}) {
    std::vector<std::vector<Residual>> of_pass(block.passes.size());
    std::vector<double> all;
    for (std::size_t i = 0; i < block.looks.size(); ++i) {
      const double v = residuals.whitened_errors(static_cast<Eigen::Index>(i), component);
      const double r = residuals.redundancy(static_cast<Eigen::Index>(i), component);
      if (chosen[i] != 0 || !std::isfinite(v) || !(r > kShownPart)) continue;
      const std::uint32_t pass = block.looks.pass[i];
      const double sigma_m =
          component == 0 ? block.SigmaOf(i).range_m
                         : block.ApproximateAzimuthSigma_m(
                               i, block.passes[pass].path.states().front().velocity_mps.norm());
      of_pass[pass].push_back({v, r, sigma_m, block.looks.time_s[i], block.looks.range_m[i]});
      all.push_back(v / std::sqrt(r));
    }
    const char* word = component == 0 ? "ranges" : "azimuths";
    std::array<Pooled, kTestsOfPass> pooled;
    for (std::size_t pass = 0; pass < of_pass.size(); ++pass) {
      std::vector<Found> found =
          TestsOfPass(std::move(of_pass[pass]), word + (" of " + block.passes[pass].id));
      for (std::size_t k = 0; k < found.size(); ++k) {
        pooled[k].Add(found[k].statistic);
        if (k == kOfNeighbours) found[k].statistic = std::max(0.0, found[k].statistic);
        tests.push_back(std::move(found[k]));
      }
    }
    for (std::size_t k = 0; k < kTestsOfPass; ++k) {
      const double statistic = pooled[k].statistic();
      tests.push_back({k == kOfNeighbours ? std::max(0.0, statistic) : statistic,
                       std::string("residuals of the ") + word + " of all passes " + kCommon[k]});
    }
    if (all.size() >= kFewestLooks) tests.push_back(TestOfTails(all, much_larger, word));
    double square = 0.0;
    for (const double w : all) square += w * w;
    const bool small = square < kSmallWithoutWorst * static_cast<double>(all.size());
    if (!suspects.empty() && all.size() >= kFewestLooks && small) {
      return std::string("errors of the ") + word + " of a few points are much larger than all " +
             "others: blunders";
    }
  }
  if (tests.empty()) return "";
  const double limit =
      NormalQuantile(1.0 - 0.5 * kPatternLevel / static_cast<double>(tests.size()));
  const Found* most = nullptr;
  for (const Found& found : tests) {
    if (!(std::abs(found.statistic) > limit)) continue;
    if (most == nullptr || std::abs(found.statistic) > std::abs(most->statistic)) {
      most = &found;
    }
  }
  return most == nullptr ? "" : most->text;
}

}  // namespace sarblock
