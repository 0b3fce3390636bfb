// SPDX-License-Identifier: Apache-2.0
#include "cone_mistakes.h"

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

Hypothesis WrongSide(const Names& passes) {
  Hypothesis out;
  out.kind = MistakeKind::kCone;
  out.cause = "side";
  out.passes = passes;
  out.parameters = 0;
  out.undo = [passes](Block* block, double) {
    for (const std::uint32_t p : PassesOf(*block, passes)) {
      LookSide& side = block->passes[p].side;
      side = side == LookSide::kLeft ? LookSide::kRight : LookSide::kLeft;
    }
  };
  out.says = [passes](const Size&) {
    return PassWords(passes) + (passes.size() == 1 ? " looks" : " look") +
           " to the other side of the flight than block.toml says";
  };
  out.change = [passes](const Size&) {
    return "block.toml: the other value of `look` " + OfPasses(passes);
  };
  return out;
}

Hypothesis ScaledCone(const Names& passes, const char* column, const KnownNumber& factor) {
  Hypothesis out;
  out.kind = MistakeKind::kCone;
  out.cause = factor.value < 0.0 ? "cone.sign" : "cone.unit";
  out.parameters = 0;
  out.passes = passes;
  out.undo = [passes](Block* block, double value) {
    if (block->looks.cone.empty()) return;
    ForLooks(*block, passes, [&](std::size_t i) { block->looks.cone[i] /= value; });
  };
  out.value = factor.value;
  out.unit = "1";
  const std::string name = column;
  out.says = [passes, factor, name](const Size&) {
    return "the values of " + name + " " + OfPasses(passes) + " " + factor.text;
  };
  out.change = [passes, factor, name](const Size&) {
    return "observations.csv: " + name + " " + OfPasses(passes) + " divided by " +
           Short(factor.value);
  };
  return out;
}

Hypothesis Wavelength(const Names& passes, const KnownNumber& factor) {
  Hypothesis out;
  out.kind = MistakeKind::kCone;
  out.cause = "cone.wavelength";
  out.parameters = 0;
  out.passes = passes;
  out.undo = [passes](Block* block, double value) {
    for (const std::uint32_t p : PassesOf(*block, passes)) block->passes[p].wavelength_m /= value;
  };
  out.value = factor.value;
  out.unit = "1";
  out.says = [passes, factor](const Size& size) {
    return "the wavelength " + OfPasses(passes) + " is " + Short(size.value) +
           " times too large (" + factor.text + ")";
  };
  out.change = [passes](const Size& size) {
    return "block.toml: wavelength_m " + OfPasses(passes) + " divided by " + Short(size.value);
  };
  return out;
}

/// Sines of the squints at which known points are seen and that the looks give.
struct Squints {
  std::vector<double> seen_1, given_1, ratio_1, off_rad;
  bool doppler = false, given = false;
};

Squints SquintsOf(const PassSightings& pass) {
  Squints out;
  const Looks& looks = pass.part.looks;
  for (const Sighting& sighting : pass.sightings) {
    if (std::isnan(sighting.ahead_sine_1)) continue;
    double given_1 = 0.0;
    if (!looks.cone.empty()) {
      const double cone = looks.cone[sighting.look];
      const bool doppler = (looks.flags[sighting.look] & Looks::kDoppler) != 0;
      out.doppler = out.doppler || doppler;
      out.given = out.given || cone != 0.0;
      given_1 =
          doppler ? 0.5 * pass.part.passes[0].wavelength_m * cone / pass.speed_mps : std::sin(cone);
    }
    out.seen_1.push_back(sighting.ahead_sine_1);
    out.given_1.push_back(given_1);
    if (sighting.ahead_sine_1 != 0.0) out.ratio_1.push_back(given_1 / sighting.ahead_sine_1);
    out.off_rad.push_back(std::asin(std::clamp(given_1, -1.0, 1.0)) -
                          std::asin(sighting.ahead_sine_1));
  }
  return out;
}

void AddOf(const Names& passes, const Squints& squints, Hypotheses* out) {
  if (squints.given) {
    const char* column = squints.doppler ? "doppler_hz" : "squint_deg";
    out->push_back(ScaledCone(passes, column, {-1.0, "have the wrong sign"}));
    if (squints.doppler) {
      out->push_back(Wavelength(passes, {100.0, "centimetres for metres"}));
      out->push_back(Wavelength(passes, {1000.0, "millimetres for metres"}));
    } else {
      out->push_back(ScaledCone(passes, column, {kRadPerDeg, "are radians, not degrees"}));
    }
  }
  if (squints.doppler || squints.off_rad.size() < 3) return;
  out->push_back(SquintBias(passes, Median(squints.off_rad), 1e-6));
}

}  // namespace

Hypothesis SquintBias(const std::vector<std::string>& passes, double value_rad, double step_rad) {
  Hypothesis out;
  out.kind = MistakeKind::kCone;
  out.cause = "cone.squint";
  out.passes = passes;
  out.undo = [passes](Block* block, double value) {
    Looks& looks = block->looks;
    if (looks.cone.empty()) looks.cone.assign(looks.size(), 0.0);
    ForLooks(*block, passes, [&](std::size_t i) {
      if ((looks.flags[i] & Looks::kDoppler) != 0) return;
      looks.cone[i] -= value;
    });
  };
  out.free = true;
  out.value = value_rad;
  out.step = step_rad;
  out.unit = "rad";
  out.says = [passes](const Size& size) {
    const Size degrees = SizeOf(-kDegPerRad * size.value, kDegPerRad * size.sigma, "deg");
    return PassWords(passes) + (passes.size() == 1 ? " looks" : " look") + " with a squint of " +
           degrees.text + " that squint_deg leaves out";
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: squint_deg " + OfPasses(passes) +
           (size.value > 0.0 ? " minus " : " plus ") + Short(std::abs(kDegPerRad * size.value)) +
           ", or correction.squint " + OfPasses(passes);
  };
  return out;
}

void AddConeMistakes(const Facts& facts, Hypotheses* out) {
  Names turned;
  Squints all;
  for (const PassSightings& pass : facts.passes) {
    const std::string& id = facts.sample.block.passes[pass.pass].id;
    const auto wrong = std::count_if(pass.sightings.begin(),
                                     pass.sightings.end(),
                                     [](const Sighting& s) { return !s.on_its_side; });
    if (2 * static_cast<std::size_t>(wrong) > pass.sightings.size()) turned.push_back(id);
    if (pass.sightings.empty()) {
      out->push_back(WrongSide({id}));
      out->back().screened = true;
    }
    const Squints squints = SquintsOf(pass);
    AddOf({id}, squints, out);
    all.off_rad.insert(all.off_rad.end(), squints.off_rad.begin(), squints.off_rad.end());
    all.doppler = all.doppler || squints.doppler;
    all.given = all.given || squints.given;
  }
  if (!turned.empty()) {
    out->push_back(WrongSide(turned));
    out->back().screened = true;
    out->back().order_1 = Hypothesis::kTold_1;
  }
  if (facts.passes.size() > 1) AddOf({}, all, out);
}

}  // namespace sarblock
