// SPDX-License-Identifier: Apache-2.0
// What real ranges and times hold beyond geometry, left in.
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/utc.h"
#include "mistake.h"
#include "mistakes.h"
#include "reduction/look_reduction.h"
#include "reduction/reduction.h"
#include "sample.h"

namespace sarblock {
namespace {

/// Cosine of the incidence of a look on an ellipsoid, from its range and the antenna alone.
double CosIncidence(const Block& block, std::size_t look) {
  const FlightPath& path = block.passes[block.looks.pass[look]].path;
  const auto antenna = path.At(block.looks.time_s[look]);
  const double range_m = block.looks.range_m[look];
  if (!antenna || !(range_m > 0.0)) return 1.0;
  const double distance_m = antenna->position_m.norm();
  const double ground_m = block.frame.AtHeight(antenna->position_m, 0.0).norm();
  const double cosine = (distance_m * distance_m - range_m * range_m - ground_m * ground_m) /
                        (2.0 * range_m * ground_m);
  constexpr double kGrazing = 0.05;
  return std::clamp(cosine, kGrazing, 1.0);
}

/// The delay of the troposphere at the zenith of the ground, from the mean one on.
Hypothesis ZenithDelayLeftIn(double step_m) {
  Hypothesis out;
  out.kind = MistakeKind::kRange;
  out.cause = "range.troposphere";
  out.undo = [](Block* block, double zenith_m) {
    ForLooks(*block, {}, [&](std::size_t i) {
      block->looks.range_m[i] -= zenith_m * SlantFactor(CosIncidence(*block, i));
    });
  };
  out.free = true;
  out.value = 2.4;
  out.step = step_m;
  out.unit = "m";
  out.says = [](const Size& size) {
    return "the ranges of all passes hold a delay that grows with the incidence, as that of the "
           "troposphere does: " +
           size.text + " at the zenith, where the mean atmosphere has 2.4 m at sea level";
  };
  out.change = [](const Size&) {
    return std::string(
        "block.toml: [reduction] troposphere = \"standard\", or a correction "
        "troposphere");
  };
  return out;
}

/// Times of a processor that takes an echo to be received where it was sent: late by half the
/// travel time, R/c, less a constant, which is found; of part -1 where that is taken off twice.
Hypothesis BistaticTimes(double middle_m, double part) {
  Hypothesis out;
  out.kind = MistakeKind::kTime;
  out.cause = "time.bistatic";
  out.undo = [middle_m, part](Block* block, double late_s) {
    ForLooks(*block, {}, [&](std::size_t i) {
      block->looks.time_s[i] -=
          late_s + part * (block->looks.range_m[i] - middle_m) / kSpeedOfLight_mps;
    });
  };
  out.free = true;
  out.value = 0.0;
  out.step = 1e-5;
  out.unit = "s";
  out.says = [part, middle_m](const Size& size) {
    return std::string("the times of all passes ") + (part > 0.0 ? "grow" : "fall") +
           " with range by half of the travel time, as where echoes are taken to be received where "
           "they were sent" +
           (part > 0.0 ? "" : ", corrected with the wrong sign or twice") + ", and are " +
           SizeOf(std::abs(size.value), size.sigma, "s").text +
           (size.value > 0.0 ? " late" : " early") + " at " + InFiles(middle_m) + " m";
  };
  out.change = [part, middle_m](const Size& size) {
    return std::string("observations.csv: as time_shift_s ") + InFiles(size.value, size.sigma) +
           (part > 0.0 ? " + " : " - ") + "(range_m - " + InFiles(middle_m) + ") / 299792458";
  };
  return out;
}

/// Displacement of the middle of the block by the tide when each pass saw it, frame axes.
std::optional<std::map<std::string, Eigen::Vector3d>> TidesOf(const Block& block) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const Eigen::Vector3d& p_m : block.points.given_m) {
    if (!p_m.allFinite()) continue;
    sum_m += p_m;
    count += 1.0;
  }
  if (count == 0.0) return std::nullopt;
  std::map<std::string, Eigen::Vector3d> tides_m;
  for (const Pass& pass : block.passes) {
    const auto epoch = ParseUtc(pass.epoch_utc);
    if (!epoch) return std::nullopt;
    const UtcTime middle = AddSeconds(*epoch, 0.5 * (pass.start_s + pass.end_s));
    tides_m[pass.id] = SolidEarthTide_m(TidalBodiesAt(middle), sum_m / count);
  }
  return tides_m;
}

/// A displaced point is seen as one that stays is seen from a path displaced the other way.
Hypothesis TideLeftIn(const std::map<std::string, Eigen::Vector3d>& tides_m) {
  Hypothesis out;
  out.kind = MistakeKind::kPath;
  out.cause = "control.tide";
  out.parameters = 0;
  out.undo = [tides_m](Block* block, double) {
    for (std::size_t i = 0; i < block->passes.size(); ++i) {
      const Eigen::Vector3d& by_m = tides_m.at(block->passes[i].id);
      EditPathAsRead([&](StateVector* state) { state->position_m -= by_m; }, i, block);
    }
  };
  double largest_m = 0.0;
  for (const auto& [pass, tide_m] : tides_m) largest_m = std::max(largest_m, tide_m.norm());
  out.says = [largest_m](const Size&) {
    return "the points were displaced by the solid Earth tide when they were seen, by up to " +
           Short(largest_m) + " m";
  };
  out.change = [](const Size&) { return std::string("block.toml: [reduction] tide = \"solid\""); };
  return out;
}

}  // namespace

void AddDelayMistakes(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  const std::size_t before = out->size();
  const auto possible = [&](const ReductionModels& models) {
    return !FindProblem(block, std::vector(block.passes.size(), models));
  };
  ReductionModels air, tide;
  air.troposphere = TroposphereModel::kStandard;
  tide.solid_tide = true;
  std::vector<double> ranges_m;
  constexpr double kOrbit_m = 100e3;
  for (std::size_t i = 0; i < block.looks.size(); ++i) ranges_m.push_back(block.looks.range_m[i]);
  if (block.frame.kind() != FrameKind::kGeocentric || ranges_m.empty() ||
      !(Median(ranges_m) > kOrbit_m)) {
    return;
  }
  const double range_sigma_m = std::max(1e-3, block.passes.front().sigma.range_m);
  if (possible(air)) out->push_back(ZenithDelayLeftIn(range_sigma_m));
  for (const double part : {1.0, -1.0}) {
    out->push_back(BistaticTimes(Median(ranges_m), part));
  }
  if (possible(tide)) {
    if (const auto tides_m = TidesOf(block)) out->push_back(TideLeftIn(*tides_m));
  }
  for (std::size_t k = before; k < out->size(); ++k) {
    (*out)[k].screened = true;
    (*out)[k].order = Hypothesis::kScored;
  }
}

}  // namespace sarblock
