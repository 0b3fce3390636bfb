// SPDX-License-Identifier: Apache-2.0
// Times and ranges that are wrong by themselves, and what they hold beyond geometry, left in;
// constants that a score test finds.
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "core/utc.h"
#include "geometry/recorded_states.h"
#include "mistakes.h"
#include "normals/reduced_system.h"
#include "reduction/reduction.h"
#include "sample.h"
#include "selection/quadratic_model.h"

namespace sarblock {
namespace {

using Names = std::vector<std::string>;

/// Numbers that clocks differ by, either sign.
std::vector<KnownNumber> ClockNumbers() {
  std::vector<KnownNumber> numbers;
  for (const double sign : {1.0, -1.0}) {
    numbers.push_back({sign * 1.0, "one leap second"});
    numbers.push_back({sign * 18.0, "GPS and UTC differ by 18 s since 2017"});
    numbers.push_back({sign * 17.0, "GPS and UTC differed by 17 s until 2016"});
    numbers.push_back({sign * 19.0, "TAI and GPS differ by 19 s"});
    numbers.push_back({sign * 37.0, "TAI and UTC differ by 37 s since 2017"});
    numbers.push_back({sign * 60.0, "one minute"});
    numbers.push_back({sign * 3600.0, "one hour"});
    numbers.push_back({sign * 86400.0, "one day"});
  }
  return numbers;
}

/// Times measured and those at which the known points come abeam.
struct Times {
  std::vector<double> measured_s, true_s, late_s;
};

Times TimesOf(const PassPredictions& pass) {
  Times times;
  for (const PredictedLook& predicted : pass.predictions) {
    if (std::isnan(predicted.true_time_s)) continue;
    times.measured_s.push_back(predicted.time_s);
    times.true_s.push_back(predicted.true_time_s);
    times.late_s.push_back(predicted.time_s - predicted.true_time_s);
  }
  return times;
}

/// Standard deviation of an azimuth time of the pass.
double SigmaOfTime(const PassPredictions& pass, const Facts& facts) {
  const LookSigma& sigma = facts.sample.block.passes[pass.pass].sigma;
  const double azimuth = sigma.azimuth > 0.0 ? sigma.azimuth : 1.0;
  if (sigma.azimuth_unit == AzimuthUnit::kHertz && pass.part.looks.size() > 0) {
    return azimuth * pass.part.ApproximateAzimuthUnit_m(0, pass.speed_mps) / pass.speed_mps;
  }
  return sigma.azimuth_unit == AzimuthUnit::kSeconds ? azimuth : azimuth / pass.speed_mps;
}

}  // namespace

Hypothesis ConstantTime(const Names& passes, double late_s, double step_s) {
  Hypothesis out;
  out.kind = MistakeKind::kTime;
  out.cause = "time.constant";
  out.passes = passes;
  out.undo = [passes](Block* block, double late) {
    ForLooks(*block, passes, [&](std::size_t i) { block->looks.time_s[i] -= late; });
  };
  out.free = true;
  out.value = late_s;
  out.step = step_s;
  out.unit = "s";
  out.numbers = ClockNumbers();
  out.says = [passes](const Size& size) {
    return "the times of " + PassWords(passes) + " are " +
           SizeOf(std::abs(size.value), size.sigma, "s").text +
           (size.value > 0.0 ? " late" : " early");
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: time_s " + PassesPhrase(passes) +
           (size.value > 0.0 ? " minus " : " plus ") + InFiles(std::abs(size.value), size.sigma) +
           ", or correction.time " + PassesPhrase(passes);
  };
  return out;
}

namespace {

Hypothesis Reversed(const Names& passes, double sum_s, double step_s) {
  Hypothesis out;
  out.kind = MistakeKind::kTime;
  out.cause = "time.reversed";
  out.passes = passes;
  out.undo = [passes](Block* block, double sum) {
    ForLooks(*block, passes, [&](std::size_t i) {
      block->looks.time_s[i] = sum - block->looks.time_s[i];
    });
  };
  out.free = true;
  out.value = sum_s;
  out.step = step_s;
  out.unit = "s";
  out.says = [passes](const Size&) {
    return "the times of " + PassWords(passes) + " run backward";
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: time_s " + PassesPhrase(passes) + " is " +
           InFiles(size.value, size.sigma) + " minus what it is";
  };
  return out;
}

Hypothesis ScaledTime(const Names& passes, const KnownNumber& factor) {
  Hypothesis out;
  out.kind = MistakeKind::kTime;
  out.cause = "time.scale";
  out.parameters = 0;
  out.passes = passes;
  out.undo = [passes](Block* block, double value) {
    ForLooks(*block, passes, [&](std::size_t i) { block->looks.time_s[i] /= value; });
  };
  out.value = factor.value;
  out.unit = "1";
  out.says = [passes, factor](const Size& size) {
    return "the times of " + PassWords(passes) + " are " + Short(size.value) +
           " times too large (" + factor.text + ")";
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: time_s " + PassesPhrase(passes) + " divided by " +
           InFiles(size.value);
  };
  return out;
}

const std::vector<KnownNumber>& TimeFactors() {
  static const std::vector<KnownNumber> factors{{1e3, "milliseconds for seconds"},
                                                {1e6, "microseconds for seconds"},
                                                {1e-3, "the states are in milliseconds"},
                                                {1.0 / 60.0, "minutes for seconds"},
                                                {1.0 / 86400.0, "days for seconds"}};
  return factors;
}

/// A clock that runs too fast about the time at which it is right, from `rate` on.
Hypothesis DriftingTime(const Names& passes, double rate, double right_s, double step) {
  Hypothesis out;
  out.kind = MistakeKind::kTime;
  out.cause = "time.drift";
  out.parameters = 2;
  out.passes = passes;
  out.undo = [passes, right_s](Block* block, double value) {
    ForLooks(*block, passes, [&](std::size_t i) {
      double& time_s = block->looks.time_s[i];
      time_s = right_s + (time_s - right_s) / (1.0 + value);
    });
  };
  out.free = true;
  out.value = rate;
  out.step = step;
  out.unit = "1";
  const auto in_ppm = [](const Size& size) {
    return SizeOf(1e6 * std::abs(size.value), 1e6 * size.sigma, "ppm").text;
  };
  out.says = [passes, in_ppm](const Size& size) {
    return "the clock of the times of " + PassWords(passes) + " runs " + in_ppm(size) +
           (size.value > 0.0 ? " too fast" : " too slow");
  };
  out.change = [passes, right_s](const Size& size) {
    const std::string right = NumberText(right_s);
    return "observations.csv: " + right + " + (time_s - " + right + ") / " +
           Digits(1.0 + size.value, 8) + " for time_s " + PassesPhrase(passes);
  };
  return out;
}

/// Looks of a pass that lie on its path a day or a week away.
Hypothesis WrappedTime(const std::string& pass) {
  Hypothesis out;
  out.kind = MistakeKind::kTime;
  out.cause = "time.wrap";
  out.parameters = 0;
  out.passes = {pass};
  out.undo = [pass](Block* block, double) {
    ForLooks(*block, {pass}, [&](std::size_t i) {
      double& time_s = block->looks.time_s[i];
      time_s += WrapOf_s(block->passes[block->looks.pass[i]].path, time_s);
    });
  };
  out.says = [pass](const Size&) {
    return "the times of some looks of pass " + pass +
           " are seconds of the day or week that begin again";
  };
  out.change = [pass](const Size&) {
    return "observations.csv: time_s off the path of pass " + pass +
           " plus or minus a day (86400 s) or a week (604800 s), so that it is on it";
  };
  out.screened = true;
  out.order = Hypothesis::kCertain;
  return out;
}

void AddWraps(const Block& block, Hypotheses* out) {
  for (const Pass& pass : block.passes) {
    bool on_path = false, wrapped = false;
    ForLooks(block, {pass.id}, [&](std::size_t i) {
      const double time_s = block.looks.time_s[i];
      on_path = on_path || (time_s >= pass.path.start_s() && time_s <= pass.path.end_s());
      wrapped = wrapped || WrapOf_s(pass.path, time_s) != 0.0;
    });
    if (on_path && wrapped) out->push_back(WrappedTime(pass.id));
  }
}

bool Near(double value, double wanted, double part) {
  return std::abs(value - wanted) < part * std::abs(wanted);
}

void AddOf(const Names& passes, const Times& times, double sigma_s, Hypotheses* out) {
  if (times.late_s.size() < 3) return;
  const Line line = RobustLine(times.true_s, times.measured_s);
  out->push_back(ConstantTime(passes, Median(times.late_s), sigma_s));
  if (Near(line.slope, -1.0, 0.2)) {
    out->push_back(Reversed(passes, line.offset, sigma_s));
  }
  constexpr double kLeastDrift = 1e-4, kMostDrift = 0.2;
  const double drift = line.slope - 1.0;
  if (std::abs(drift) > kLeastDrift && std::abs(drift) < kMostDrift) {
    const auto [first, last] = std::minmax_element(times.true_s.begin(), times.true_s.end());
    out->push_back(DriftingTime(passes, drift, -line.offset / drift, sigma_s / (*last - *first)));
  }
  for (const KnownNumber& factor : TimeFactors()) {
    if (Near(line.slope, factor.value, 0.2)) out->push_back(ScaledTime(passes, factor));
  }
}

}  // namespace

void AddTimeMistakes(const Facts& facts, Hypotheses* out) {
  Times all;
  double sigma_s = 0.0;
  for (const PassPredictions& pass : facts.passes) {
    const Names name{facts.sample.block.passes[pass.pass].id};
    const Times times = TimesOf(pass);
    sigma_s = std::max(sigma_s, SigmaOfTime(pass, facts));
    AddOf(name, times, SigmaOfTime(pass, facts), out);
    const auto append = [](const std::vector<double>& from, std::vector<double>* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    append(times.measured_s, &all.measured_s);
    append(times.true_s, &all.true_s);
    append(times.late_s, &all.late_s);
    if (times.late_s.size() >= 3) continue;
    // Nothing known is seen: what clocks differ by is tried.
    for (const KnownNumber& number : ClockNumbers()) {
      if (std::abs(number.value) > 40.0) continue;
      Hypothesis blind = ConstantTime(name, number.value, SigmaOfTime(pass, facts));
      blind.screened = true;
      out->push_back(std::move(blind));
    }
  }
  if (facts.passes.size() > 1) AddOf({}, all, sigma_s, out);
  AddWraps(facts.sample.block, out);
}

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
      {2.0 / kSpeedOfLight_mps, "two-way travel times in seconds"},
      {3e8 / kSpeedOfLight_mps, "3e8 m/s for the speed of light"}};
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
    const bool near_one = std::abs(size.value - 1.0) < 0.01;
    return "the ranges of " + PassWords(passes) + " are " +
           (near_one ? InFiles(size.value) : Short(size.value)) + " times what they should be (" +
           factor.text + ")";
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: range_m " + PassesPhrase(passes) + " divided by " +
           InFiles(size.value);
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

/// "sqrt(r^2 + 9000^2) of pass A", r what range_m has.
std::string SlantWords(const Ground& ground, const std::string& pass) {
  const std::string antenna = InFiles(ground.antenna_m), radius = InFiles(ground.ground_m);
  const std::string text =
      ground.sphere ? "sqrt(" + antenna + "^2 + " + radius + "^2 - 2 * " + antenna + " * " +
                          radius + " * cos(r / " + radius + "))"
                    : "sqrt(r^2 + " + InFiles(ground.antenna_m - ground.ground_m) + "^2)";
  return text + " of pass " + pass;
}

/// The height of the ground, or its distance from the centre, is estimated as well, from that of
/// the known points on.
Hypothesis GroundRange(const Block& sample, const Names& passes, double step_m) {
  Hypothesis out;
  out.kind = MistakeKind::kRange;
  out.cause = "range.ground";
  out.passes = passes;
  out.undo = [passes](Block* block, double ground_m) {
    std::vector<Ground> ground;
    for (std::uint32_t p = 0; p < block->passes.size(); ++p) {
      ground.push_back(GroundOf(*block, p));
      ground.back().ground_m = ground_m;
    }
    ForLooks(*block, passes, [&](std::size_t i) {
      block->looks.range_m[i] = ground[block->looks.pass[i]].SlantOf(block->looks.range_m[i]);
    });
  };
  out.free = true;
  out.value = GroundOf(sample, 0).ground_m;
  out.step = step_m;
  out.unit = "m";
  const bool sphere = sample.frame.kind() == FrameKind::kGeocentric;
  out.says = [passes, sphere](const Size& size) {
    return "the ranges of " + PassWords(passes) +
           " are ground ranges, not slant ranges (of a ground " + size.text +
           (sphere ? " from the centre)" : " high)");
  };
  std::vector<std::pair<std::string, Ground>> seen;
  for (const std::uint32_t p : PassesOf(sample, passes)) {
    seen.emplace_back(sample.passes[p].id, GroundOf(sample, p));
  }
  out.change = [passes, seen](const Size& size) {
    std::string slant;
    for (const auto& [pass, known] : seen) {
      Ground ground = known;
      ground.ground_m = size.value;
      slant += (slant.empty() ? "" : ", ") + SlantWords(ground, pass);
    }
    return "observations.csv: slant ranges in range_m " + PassesPhrase(passes) +
           " as the product converts them; known points show for ground ranges r " + slant;
  };
  return out;
}

/// Measured over true range, and their differences.
struct Ranges {
  std::vector<double> ratio, longer_m;
};

Ranges RangesOf(const PassPredictions& pass) {
  Ranges ranges;
  for (const PredictedLook& predicted : pass.predictions) {
    if (std::isnan(predicted.true_range_m)) continue;
    ranges.ratio.push_back(predicted.range_m / predicted.true_range_m);
    ranges.longer_m.push_back(predicted.range_m - predicted.true_range_m);
  }
  return ranges;
}

void AddOf(const Block& sample,
           const Names& passes,
           const Ranges& ranges,
           double sigma_m,
           Hypotheses* out) {
  if (ranges.ratio.size() < 3) return;
  out->push_back(RangeBias(passes, Median(ranges.longer_m), sigma_m));
  // Where the known points are no ground of this body their coordinates are wrong.
  constexpr double kNearRadius = 0.1;
  const Ground ground = GroundOf(sample, 0);
  const bool at_ground =
      !ground.sphere || Near(ground.ground_m, sample.frame.ellipsoid().a_m, kNearRadius);
  if (at_ground) out->push_back(GroundRange(sample, passes, sigma_m));
  const double ratio = Median(ranges.ratio);
  for (const KnownNumber& factor : RangeFactors()) {
    if (std::abs(ratio / factor.value - 1.0) < 0.1) {
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
    return "observations.csv: range_m " + PassesPhrase(passes) +
           (size.value > 0.0 ? " minus " : " plus ") + InFiles(std::abs(size.value), size.sigma) +
           ", or correction.range (bias) " + PassesPhrase(passes);
  };
  return out;
}

void AddRangeMistakes(const Facts& facts, Hypotheses* out) {
  Ranges all;
  double sigma_m = 0.0;
  for (const PassPredictions& pass : facts.passes) {
    const Pass& of = facts.sample.block.passes[pass.pass];
    const double sigma_of_m = of.sigma.range_m > 0.0 ? of.sigma.range_m : 1.0;
    sigma_m = std::max(sigma_m, sigma_of_m);
    const Ranges ranges = RangesOf(pass);
    AddOf(facts.sample.block, {of.id}, ranges, sigma_of_m, out);
    if (ranges.ratio.size() < 3) AddBlind({of.id}, out);
    all.ratio.insert(all.ratio.end(), ranges.ratio.begin(), ranges.ratio.end());
    all.longer_m.insert(all.longer_m.end(), ranges.longer_m.begin(), ranges.longer_m.end());
  }
  if (facts.passes.size() < 2) return;
  AddOf(facts.sample.block, {}, all, sigma_m, out);
  if (all.ratio.size() < 3) AddBlind({}, out);
}

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

namespace {

/// Least decrease of v'Pv by a constant (score test) for which it is solved for, and most constants
/// that are.
constexpr double kMinStatistic = 25.0;
constexpr std::size_t kMaxScored = 6;
/// Most passes for which the dense score test of all of them is fast enough.
constexpr std::size_t kMaxPasses = 200;

using Names = std::vector<std::string>;
using ParameterKey = std::pair<std::string, std::string>;  // owner and name

ParameterKey KeyOf(const Parameter& parameter) { return {parameter.owner, parameter.name}; }

/// The constants, each of one pass by itself and of all together.
std::vector<CorrectionGroup> Constants() {
  std::vector<CorrectionGroup> groups;
  for (const bool shared : {false, true}) {
    const std::string all = shared ? "diagnose." : "";
    groups.push_back({all + "range", RangeCorrection{.bias = true}, {}, shared});
    groups.push_back({all + "time", TimeCorrection{}, {}, shared});
    groups.push_back({all + "squint", SquintCorrection{}, {}, shared});
  }
  return groups;
}

Hypothesis HypothesisOf(const Parameter& parameter, const Names& passes, const Facts& facts) {
  const Block& block = facts.sample.block;
  const Pass& pass = block.passes[0];
  const double speed_mps = facts.passes[0].speed_mps;
  const double range_m = block.looks.size() > 0 ? block.looks.range_m[0] : 1.0;
  const double azimuth_m =
      block.looks.size() > 0 ? block.ApproximateAzimuthSigma_m(0, speed_mps) : 1.0;
  switch (parameter.kind) {
    case ParameterKind::kRangeBias:
      return RangeBias(passes, 0.0, pass.sigma.range_m);
    case ParameterKind::kTimeBias:
      return ConstantTime(passes, 0.0, azimuth_m / speed_mps);
    default:
      return SquintBias(passes, 0.0, azimuth_m / range_m);
  }
}

}  // namespace

Hypotheses ScoredMistakes(const Facts& facts, ProgressSink* progress) {
  Hypotheses out;
  const Block& block = facts.sample.block;
  if (!facts.before.solved || block.passes.size() > kMaxPasses) return out;
  try {
    std::vector<CorrectionGroup> groups = facts.corrections.groups;
    for (const CorrectionGroup& constant : Constants()) {
      const bool stands = std::any_of(groups.begin(), groups.end(), [&](const CorrectionGroup& g) {
        return !constant.shared && !g.shared && Overlap(g, constant);
      });
      if (!stands) groups.push_back(constant);
    }
    const std::vector<JointPrior>& priors = facts.corrections.priors;
    AdjustmentProblem base(block, facts.corrections.groups, {}, priors);
    AdjustmentProblem extended(block, groups, {}, priors);
    std::map<ParameterKey, double> value_of;
    for (int i = 0; i < base.layout.size(); ++i) {
      value_of[KeyOf(base.layout.parameters[static_cast<std::size_t>(i)])] =
          facts.before.state.corrections[i];
    }
    BlockState state = facts.before.state;
    state.corrections = Eigen::VectorXd::Zero(extended.layout.size());
    std::vector<int> active, constants;
    for (int i = 0; i < extended.layout.size(); ++i) {
      const auto found =
          value_of.find(KeyOf(extended.layout.parameters[static_cast<std::size_t>(i)]));
      (found == value_of.end() ? constants : active).push_back(i);
      if (found != value_of.end()) state.corrections[i] = found->second;
    }
    for (std::size_t point = 0; point < block.points.size(); ++point) {
      if (!state.Position(point).allFinite()) {
        extended.LeaveOut(point, PointStatus::kUndetermined, "no place");
      }
    }
    UpdateWeights(state, &extended);
    ReducedSystem system(extended);
    system.Form(state, {}, progress);
    QuadraticModel::Data data = DataAt(system, state.corrections, extended.layout.parameters);
    data.redundancy = facts.before.redundancy;
    QuadraticModel model(std::move(data));
    if (!model.Reset(active)) return out;
    std::vector<std::pair<double, int>> scores;
    for (const int column : constants) {
      const double statistic = model.Score({column}).statistic;
      if (statistic > kMinStatistic) scores.emplace_back(-statistic, column);
    }
    std::sort(scores.begin(), scores.end());
    if (scores.size() > kMaxScored) scores.resize(kMaxScored);
    for (const auto& [score, column] : scores) {
      const Parameter& parameter = extended.layout.parameters[static_cast<std::size_t>(column)];
      const bool shared = parameter.owner.rfind("diagnose.", 0) == 0;
      if (shared && block.passes.size() < 2) continue;
      out.push_back(HypothesisOf(parameter, shared ? Names{} : Names{parameter.owner}, facts));
      out.back().screened = true;
      // What a constant takes where all is linear is its statistic.
      const double excess = facts.before.SquareSum() - facts.before.redundancy;
      if (-2.0 * score > excess) out.back().order = Hypothesis::kScored;
      out.back().local = true;
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // a block that cannot be linearised has no scores
    out.clear();
  }
  return out;
}

}  // namespace sarblock
