// SPDX-License-Identifier: Apache-2.0
#include "range_mistakes.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "edits.h"
#include "words.h"

namespace sarblock {
namespace {

using Names = std::vector<std::string>;

/// Ranges written over one-way ranges in metres.
const std::vector<KnownNumber>& RangeFactors() {
  static const std::vector<KnownNumber> factors{
      {2.0, "the way there and back"},
      {0.5, "half of a one-way range"},
      {1e-3, "kilometres for metres"},
      {1e3, "millimetres for metres"},
      {2e6 / kSpeedOfLight_mps, "two-way travel times in microseconds"},
      {1e6 / kSpeedOfLight_mps, "one-way travel times in microseconds"},
      {2e3 / kSpeedOfLight_mps, "two-way travel times in milliseconds"},
      {2.0 / kSpeedOfLight_mps, "two-way travel times in seconds"}};
  return factors;
}

Hypothesis ScaledRange(const Names& passes, const KnownNumber& factor) {
  Hypothesis out;
  out.kind = MistakeKind::kRange;
  out.cause = "range.scale";
  out.parameters = 0;
  out.passes = passes;
  out.undo = [passes](Block* block, double value) {
    ForLooks(*block, passes, [&](std::size_t i) { block->looks.range_m[i] /= value; });
  };
  out.value = factor.value;
  out.unit = "1";
  out.says = [passes, factor](const Size& size) {
    return "the ranges of " + PassWords(passes) + " are " + Short(size.value) +
           " times what they should be (" + factor.text + ")";
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: range_m " + OfPasses(passes) + " divided by " + Short(size.value);
  };
  return out;
}

/// How a pass sees the ground: to turn ground ranges into slant ranges.
struct Ground {
  bool sphere = false;
  double antenna_m = 0.0, ground_m = 0.0;  ///< heights, or radii on a sphere

  [[nodiscard]] double SlantOf(double ground_range_m) const {
    if (!sphere) return std::hypot(ground_range_m, antenna_m - ground_m);
    const double angle_rad = ground_range_m / ground_m;
    return std::sqrt(std::max(0.0,
                              antenna_m * antenna_m + ground_m * ground_m -
                                  2.0 * antenna_m * ground_m * std::cos(angle_rad)));
  }
};

/// Above the middle of the known points of the block.
Ground GroundOf(const Block& block, std::uint32_t pass) {
  const bool sphere = block.frame.kind() == FrameKind::kGeocentric;
  const auto height = [&](const Eigen::Vector3d& p_m) { return sphere ? p_m.norm() : p_m.z(); };
  std::vector<double> ground_m;
  for (const KnownPosition& known : block.points.known) {
    const Eigen::Vector3d& p_m = block.points.given_m[known.point];
    if (p_m.allFinite()) ground_m.push_back(height(p_m));
  }
  const std::vector<StateVector>& states = block.passes[pass].path.states();
  Ground out;
  out.sphere = sphere;
  out.antenna_m = height(states[states.size() / 2].position_m);
  out.ground_m =
      ground_m.empty() ? (sphere ? block.frame.ellipsoid().a_m : 0.0) : Median(std::move(ground_m));
  return out;
}

Hypothesis GroundRange(const Names& passes) {
  Hypothesis out;
  out.kind = MistakeKind::kRange;
  out.cause = "range.ground";
  out.parameters = 0;
  out.passes = passes;
  out.undo = [passes](Block* block, double) {
    std::vector<Ground> ground;
    for (std::uint32_t p = 0; p < block->passes.size(); ++p) ground.push_back(GroundOf(*block, p));
    ForLooks(*block, passes, [&](std::size_t i) {
      block->looks.range_m[i] = ground[block->looks.pass[i]].SlantOf(block->looks.range_m[i]);
    });
  };
  out.says = [passes](const Size&) {
    return "the ranges of " + PassWords(passes) + " are ground ranges, not slant ranges";
  };
  out.change = [passes](const Size&) {
    return "observations.csv: slant ranges in range_m " + OfPasses(passes);
  };
  return out;
}

/// Measured over true range, and their differences.
struct Ranges {
  std::vector<double> ratio_1, longer_m;
};

Ranges RangesOf(const PassSightings& pass) {
  Ranges ranges;
  for (const Sighting& sighting : pass.sightings) {
    if (std::isnan(sighting.true_range_m)) continue;
    ranges.ratio_1.push_back(sighting.range_m / sighting.true_range_m);
    ranges.longer_m.push_back(sighting.range_m - sighting.true_range_m);
  }
  return ranges;
}

void AddOf(const Names& passes, const Ranges& ranges, double sigma_m, Hypotheses* out) {
  if (ranges.ratio_1.size() < 3) return;
  out->push_back(RangeBias(passes, Median(ranges.longer_m), sigma_m));
  out->push_back(GroundRange(passes));
  const double ratio_1 = Median(ranges.ratio_1);
  for (const KnownNumber& factor : RangeFactors()) {
    if (std::abs(ratio_1 / factor.value - 1.0) < 0.1) {
      out->push_back(ScaledRange(passes, factor));
    }
  }
}

void AddBlind(const Names& passes, Hypotheses* out) {
  for (const KnownNumber& factor : {RangeFactors()[0], RangeFactors()[2]}) {
    Hypothesis blind = ScaledRange(passes, factor);
    blind.screened = true;
    out->push_back(std::move(blind));
  }
}

}  // namespace

Hypothesis RangeBias(const std::vector<std::string>& passes, double longer_m, double step_m) {
  Hypothesis out;
  out.kind = MistakeKind::kRange;
  out.cause = "range.bias";
  out.passes = passes;
  out.undo = [passes](Block* block, double longer) {
    ForLooks(*block, passes, [&](std::size_t i) { block->looks.range_m[i] -= longer; });
  };
  out.free = true;
  out.value = longer_m;
  out.step = step_m;
  out.unit = "m";
  out.says = [passes](const Size& size) {
    return "the ranges of " + PassWords(passes) + " are " +
           SizeOf(std::abs(size.value), size.sigma, "m").text +
           (size.value > 0.0 ? " too long" : " too short");
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: range_m " + OfPasses(passes) +
           (size.value > 0.0 ? " minus " : " plus ") + Short(std::abs(size.value)) +
           ", or correction.range (bias) " + OfPasses(passes);
  };
  return out;
}

void AddRangeMistakes(const Facts& facts, Hypotheses* out) {
  Ranges all;
  double sigma_m = 0.0;
  for (const PassSightings& pass : facts.passes) {
    const Pass& of = facts.sample.block.passes[pass.pass];
    const double sigma_of_m = of.sigma.range_m > 0.0 ? of.sigma.range_m : 1.0;
    sigma_m = std::max(sigma_m, sigma_of_m);
    const Ranges ranges = RangesOf(pass);
    AddOf({of.id}, ranges, sigma_of_m, out);
    if (ranges.ratio_1.size() < 3) AddBlind({of.id}, out);
    all.ratio_1.insert(all.ratio_1.end(), ranges.ratio_1.begin(), ranges.ratio_1.end());
    all.longer_m.insert(all.longer_m.end(), ranges.longer_m.begin(), ranges.longer_m.end());
  }
  if (facts.passes.size() < 2) return;
  AddOf({}, all, sigma_m, out);
  if (all.ratio_1.size() < 3) AddBlind({}, out);
}

}  // namespace sarblock
