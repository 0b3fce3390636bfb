// SPDX-License-Identifier: Apache-2.0
#include "time_mistakes.h"

#include <cmath>
#include <string>
#include <utility>

#include "edits.h"
#include "words.h"

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

Times TimesOf(const PassSightings& pass) {
  Times times;
  for (const Sighting& sighting : pass.sightings) {
    if (std::isnan(sighting.true_time_s)) continue;
    times.measured_s.push_back(sighting.time_s);
    times.true_s.push_back(sighting.true_time_s);
    times.late_s.push_back(sighting.time_s - sighting.true_time_s);
  }
  return times;
}

/// Standard deviation of an azimuth time of the pass.
double SigmaOfTime(const PassSightings& pass, const Facts& facts) {
  const LookSigma& sigma = facts.sample.block.passes[pass.pass].sigma;
  const double azimuth = sigma.azimuth > 0.0 ? sigma.azimuth : 1.0;
  if (sigma.azimuth_unit == AzimuthUnit::kHertz && pass.part.looks.size() > 0) {
    return azimuth * pass.part.RoughAzimuthUnit_m(0, pass.speed_mps) / pass.speed_mps;
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
    return "observations.csv: time_s " + OfPasses(passes) +
           (size.value > 0.0 ? " minus " : " plus ") + Short(std::abs(size.value)) +
           ", or correction.time " + OfPasses(passes);
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
    return "observations.csv: time_s " + OfPasses(passes) + " is " + size.text +
           " minus what it is";
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
    return "observations.csv: time_s " + OfPasses(passes) + " divided by " + Short(size.value);
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

bool Near(double value, double wanted, double part_1) {
  return std::abs(value - wanted) < part_1 * std::abs(wanted);
}

void AddOf(const Names& passes, const Times& times, double sigma_s, Hypotheses* out) {
  if (times.late_s.size() < 3) return;
  const Line line = RobustLine(times.true_s, times.measured_s);
  out->push_back(ConstantTime(passes, Median(times.late_s), sigma_s));
  if (Near(line.slope, -1.0, 0.2)) {
    out->push_back(Reversed(passes, line.offset, sigma_s));
  }
  for (const KnownNumber& factor : TimeFactors()) {
    if (Near(line.slope, factor.value, 0.2)) out->push_back(ScaledTime(passes, factor));
  }
}

}  // namespace

void AddTimeMistakes(const Facts& facts, Hypotheses* out) {
  Times all;
  double sigma_s = 0.0;
  for (const PassSightings& pass : facts.passes) {
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
}

}  // namespace sarblock
