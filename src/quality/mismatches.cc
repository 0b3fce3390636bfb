// SPDX-License-Identifier: Apache-2.0
#include "mismatches.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "assess.h"
#include "core/text.h"
#include "shifted_group.h"
#include "solve/solve_block.h"

namespace sarblock {
namespace {

/// Chance, over all passes and components, that scattered blunders are taken for a mismatch.
constexpr double kChance = 1e-4;
/// Looks whose residuals are compared.
constexpr std::size_t kMinLooks = 4;
/// An error of this many standard deviations of its residual is found by any search.
constexpr double kSurelyFound = 8.0;

/// Residuals of one component of a pass's lost looks.
struct Sample {
  std::size_t count = 0;
  double sum = 0.0, square = 0.0;

  void Add(double value) {
    ++count;
    sum += value;
    square += value * value;
  }
  [[nodiscard]] double Mean() const { return sum / static_cast<double>(count); }
  [[nodiscard]] double MeanSquare() const { return square / static_cast<double>(count); }
  /// Standard deviation of the mean.
  [[nodiscard]] double Sigma() const {
    const auto n = static_cast<double>(count);
    return std::sqrt(std::max(0.0, MeanSquare() - Mean() * Mean()) / (n - 1.0));
  }
  /// Whether the mean differs from zero by more than chance (Student's t; P(|T| > t) by the F
  /// distribution with one degree of freedom above).
  [[nodiscard]] bool Differs(double chance) const {
    if (count < kMinLooks || Mean() == 0.0) return false;
    const double t = Mean() / Sigma();
    if (std::isinf(t)) return true;  // all equal
    return FisherTailProbability(t * t, 1.0, static_cast<double>(count) - 1.0) < chance;
  }
};

/// What the lost looks of one pass have in common.
struct Mismatch {
  std::uint32_t pass = 0;
  std::size_t lost = 0;   ///< looks of the pass that were left out
  std::size_t given = 0;  ///< looks of the pass at points of two looks and more
  /// Range and azimuth: the mean residual of the looks left out and its standard deviation [m],
  /// where the residuals agree in it; otherwise NaN.
  std::array<double, 2> shift_m{kNotGiven, kNotGiven};
  std::array<double, 2> shift_sigma_m{kNotGiven, kNotGiven};
  /// The same in pixels and lines, where the pass has a raster; otherwise NaN.
  std::array<double, 2> shift_px{kNotGiven, kNotGiven};
  /// Points at which a look of this pass would hardly show the same error.
  std::size_t unchecked = 0;
  bool is_group = false;  ///< no shift of another pass explains as much (shifted_group.h)
  [[nodiscard]] bool alike() const { return !std::isnan(shift_m[0]) || !std::isnan(shift_m[1]); }
};

bool IsLost(RejectReason reason) {
  return reason == RejectReason::kRobust || reason == RejectReason::kBlunder ||
         reason == RejectReason::kSuspect;
}

/// Looks of a point that take part.
std::size_t CountUsed(const AdjustmentProblem& problem, std::size_t point) {
  return static_cast<std::size_t>(problem.CountLooks(point));
}

/// Whether an error of these sizes [m] in range and azimuth of a look of the point surely shows.
bool Shows(const AdjustmentProblem& problem,
           const BlunderSizes& sizes,
           const AdjustResult& result,
           const std::array<double, 2>& error_m,
           std::size_t point,
           std::size_t look) {
  if (result.quality.empty()) return CountUsed(problem, point) > 2;
  const std::array<BlunderSize, 2> size = sizes.LookSizes(look, point);
  double square = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto redundancy = static_cast<double>(result.quality.redundancy[k][look]);
    if (std::isnan(redundancy) || !(size[k].sigma_m > 0.0)) continue;
    square += redundancy * std::pow(error_m[k] / size[k].sigma_m, 2);
  }
  return square > kSurelyFound * kSurelyFound;
}

/// Points at which a look of the pass may hold the same error: kept ones that would hardly show it,
/// and points whose look of this pass was left out for one of only two others, where theirs may be
/// the wrong ones, unless the looks left out were compared with those of the other passes.
std::size_t CountUnchecked(const AdjustmentProblem& problem,
                           const BlunderSizes& sizes,
                           const AdjustResult& result,
                           const Mismatch& mismatch,
                           const std::array<double, 2>& error_m) {
  const Looks& looks = problem.block.looks;
  std::size_t unchecked = 0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    bool open = false;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (looks.pass[i] != mismatch.pass) continue;
      if (problem.look_used[i] != 0) {
        open = open || !Shows(problem, sizes, result, error_m, point, i);
      } else if (mismatch.alike() && !mismatch.is_group && IsLost(result.looks.reason[i])) {
        open = open || (CountUsed(problem, point) <= 2 && problem.control_of[point] < 0);
      }
    }
    unchecked += open ? 1U : 0U;
  }
  return unchecked;
}

std::string Describe(const Block& block, const Mismatch& mismatch) {
  static constexpr std::array<const char*, 2> kComponent{"range", "azimuth"};
  std::string text = "pass " + block.passes[mismatch.pass].id + ": " +
                     std::to_string(mismatch.lost) + " of " + std::to_string(mismatch.given) +
                     " looks were left out as blunders";
  if (!mismatch.alike()) return text + ", a larger part than of the other passes";
  text += ", off alike";
  const char* next = " by ";
  for (std::size_t k = 0; k < 2; ++k) {
    if (std::isnan(mismatch.shift_m[k])) continue;
    text += next + ValueWithSigma(mismatch.shift_m[k], mismatch.shift_sigma_m[k]) + " m in " +
            kComponent[k];
    if (!std::isnan(mismatch.shift_px[k])) {
      text += " (" + Digits(mismatch.shift_px[k], 3) + (k == 0 ? " pixels)" : " lines)");
    }
    next = " and ";
  }
  if (mismatch.is_group) text += ", which no shift of another pass explains as well";
  return text + " (a repeated pattern matched with the next one, or an error of the pass)";
}

/// The pass of which a group of looks was left out as a whole.
std::optional<std::size_t> PassOfGroup(const Block& block, const AdjustResult& result) {
  if (!result.snooping) return std::nullopt;
  for (const BlunderFinding& finding : result.snooping->findings) {
    if (finding.note == kOffLikeOthers) return block.looks.pass[finding.looks.front()];
  }
  return std::nullopt;
}

/// The pass that lost most first.
std::vector<Mismatch> FindMismatches(const AdjustmentProblem& problem,
                                     const AdjustOptions& options,
                                     const AdjustResult& result) {
  const Block& block = problem.block;
  const std::size_t passes = block.passes.size();
  std::vector<std::array<Sample, 2>> samples(passes);
  std::vector<std::size_t> lost(passes, 0);
  std::vector<std::array<std::size_t, 2>> example(passes);  // a look that was lost, and its point
  const std::vector<std::uint64_t>& offsets = block.looks.offsets;
  for (std::size_t i = 0, point = 0; i < block.looks.size(); ++i) {
    while (i >= offsets[point + 1]) ++point;
    if (!IsLost(result.looks.reason[i])) continue;
    const std::size_t pass = block.looks.pass[i];
    ++lost[pass];
    example[pass] = {i, point};
    const double range_m = result.looks.range_residual_m[i];
    const double azimuth_m = result.looks.azimuth_residual_m[i];
    if (!std::isfinite(range_m) || !std::isfinite(azimuth_m)) continue;
    samples[pass][0].Add(range_m);
    samples[pass][1].Add(azimuth_m);
  }
  const std::vector<PassLooks> by_pass = CountPassLooks(block, problem.look_used);
  const std::optional<std::size_t> loses_more = PassThatLosesMore(by_pass, kChance);
  const double chance = kChance / (2.0 * static_cast<double>(std::max<std::size_t>(1, passes)));
  const BlunderSizes sizes(block, options, result, 1.0);
  const std::optional<std::size_t> group_of = PassOfGroup(block, result);
  std::vector<Mismatch> out;
  for (std::size_t pass = 0; pass < passes; ++pass) {
    Mismatch mismatch;
    mismatch.pass = static_cast<std::uint32_t>(pass);
    mismatch.lost = lost[pass];
    mismatch.given = by_pass[pass].all.kept + by_pass[pass].all.lost;
    mismatch.is_group = group_of == pass;
    std::array<double, 2> error_m{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Sample& sample = samples[pass][k];
      if (!sample.Differs(chance)) continue;
      mismatch.shift_m[k] = sample.Mean();
      mismatch.shift_sigma_m[k] = sample.Sigma();
      error_m[k] = std::abs(sample.Mean());
    }
    if (!mismatch.alike()) {
      if (loses_more != pass || samples[pass][0].count == 0) continue;
      for (std::size_t k = 0; k < 2; ++k) error_m[k] = std::sqrt(samples[pass][k].MeanSquare());
    }
    const auto [look, point] = example[pass];
    mismatch.shift_px = InRaster(block, look, result.points.position_m[point], mismatch.shift_m);
    mismatch.unchecked = CountUnchecked(problem, sizes, result, mismatch, error_m);
    out.push_back(mismatch);
  }
  std::stable_sort(
      out.begin(), out.end(), [](const Mismatch& a, const Mismatch& b) { return a.lost > b.lost; });
  return out;
}

/// Where blunders were found at points of three looks and more, looks that nothing checks hold as
/// many: says how many are to be expected. Counted are those that are no noise.
void WarnOfUncheckedBlunders(const AdjustmentProblem& problem,
                             const AdjustOptions& options,
                             AdjustResult* result) {
  const Looks& looks = problem.block.looks;
  const std::vector<PassLooks> by_pass = CountPassLooks(problem.block, problem.look_used);
  const BlunderSizes sizes(problem.block, options, *result, 1.0);
  std::array<Sample, 2> sizes_m;
  std::vector<double> found(problem.block.passes.size(), 0.0);
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (!IsLost(result->looks.reason[i])) continue;
      const double range_m = result->looks.range_residual_m[i];
      const double azimuth_m = result->looks.azimuth_residual_m[i];
      const double sigma_m = AzimuthSigma_m(problem.block, i, result->points.position_m[point]);
      const double square = std::pow(range_m / problem.block.SigmaOf(i).range_m, 2) +
                            std::pow(azimuth_m / sigma_m, 2);
      if (!(square > kSurelyFound * kSurelyFound)) continue;
      sizes_m[0].Add(range_m);
      sizes_m[1].Add(azimuth_m);
      found[looks.pass[i]] += 1.0;
    }
  }
  if (sizes_m[0].count < kMinLooks) return;
  const std::array<double, 2> error_m{std::sqrt(sizes_m[0].MeanSquare()),
                                      std::sqrt(sizes_m[1].MeanSquare())};
  for (std::size_t pass = 0; pass < found.size(); ++pass) {
    const LookCounts& looks_of_pass = by_pass[pass].deciding;
    found[pass] /= std::max(1.0, static_cast<double>(looks_of_pass.kept + looks_of_pass.lost));
  }
  double expected = 0.0;
  std::size_t open_points = 0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    double open = 0.0;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0 || Shows(problem, sizes, *result, error_m, point, i)) continue;
      open += found[looks.pass[i]];
    }
    expected += std::min(open, 1.0);
    open_points += open > 0.0 ? 1U : 0U;
  }
  if (expected < 1.0) return;
  Warn(result,
       "some " + Digits(expected, 2) + " of " + std::to_string(open_points) +
           " points may hold a blunder that nothing shows: they have too few looks to check each "
           "other, and as many of their looks are expected to be wrong as were left out "
           "elsewhere");
}

}  // namespace

void ReportMismatches(const AdjustmentProblem& problem,
                      const AdjustOptions& options,
                      AdjustResult* result) {
  if (result->looks.range_residual_m.empty() || result->looks.reason.empty()) return;
  for (const Mismatch& mismatch : FindMismatches(problem, options, *result)) {
    const std::string text = Describe(problem.block, mismatch);
    if (mismatch.unchecked == 0) {
      Warn(result, text);
      continue;
    }
    Refuse(result,
           text + "; at " + std::to_string(mismatch.unchecked) +
               (mismatch.unchecked == 1 ? " point" : " points") +
               " no other look would show that its look is wrong too");
  }
  WarnOfUncheckedBlunders(problem, options, result);
}

}  // namespace sarblock
