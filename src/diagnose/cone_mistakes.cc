// SPDX-License-Identifier: Apache-2.0
// Look sides and cones: images at native Doppler, read as those of zero Doppler, and squints or
// Dopplers that are wrong otherwise.
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mistakes.h"
#include "sample.h"

namespace sarblock {

Hypothesis NativeDoppler(const std::vector<std::string>& passes,
                         const std::function<double(double per_m)>& constant_rad,
                         double slope_rad_per_m,
                         double step_rad_per_m) {
  Hypothesis out;
  out.kind = MistakeKind::kCone;
  out.cause = "cone.native";
  out.passes = passes;
  out.parameters = 2;
  out.undo = [passes, constant_rad](Block* block, double per_m) {
    const double at_zero_rad = constant_rad(per_m);
    Looks& looks = block->looks;
    if (looks.cone.empty()) looks.cone.assign(looks.size(), 0.0);
    ForLooks(*block, passes, [&](std::size_t i) {
      if ((looks.flags[i] & Looks::kDoppler) != 0) return;
      looks.cone[i] -= at_zero_rad + per_m * looks.range_m[i];
    });
  };
  out.free = true;
  out.value = slope_rad_per_m;
  out.step = step_rad_per_m;
  out.unit = "rad/m";
  out.says = [passes](const Size& size) {
    const double per_km = -1e3 * kDegPerRad;
    return PassWords(passes) + (passes.size() == 1 ? " looks" : " look") +
           " with a squint that changes by " +
           SizeOf(per_km * size.value, std::abs(per_km) * size.sigma, "deg").text +
           " in a kilometre of range and that squint_deg leaves out (native Doppler, read as that "
           "of an image of zero Doppler)";
  };
  out.change = [passes, constant_rad](const Size& size) {
    const std::string of = PassesPhrase(passes);
    return "observations.csv: squint_deg or doppler_hz " + of +
           " from the Doppler centroid of the image; known points show squint_deg " + of +
           " plus " + InFiles(-kDegPerRad * constant_rad(size.value)) + " + " +
           InFiles(-kDegPerRad * size.value) + " * range_m";
  };
  return out;
}

std::optional<Hypothesis> NativeBeside(const Facts& facts,
                                       const Hypothesis& squint,
                                       const Solved& solved) {
  if (squint.cause != "cone.squint" || squint.passes.size() != 1 || !solved.fit.solved) return {};
  Block block = facts.sample.block;
  squint.undo(&block, solved.value);
  const SampleResiduals residuals = ResidualsOf(block, facts.corrections, solved.fit);
  // Weighted line of the squints that the residuals of azimuth ask for.
  double weight = 0.0, range_m = 0.0, squint_rad = 0.0, square = 0.0, product = 0.0;
  std::vector<double> ranges_m;
  const auto for_looks = [&](const auto& add) {
    ForLooks(block, squint.passes, [&](std::size_t i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double v = residuals.whitened_errors(row, 1), r = residuals.redundancy(row, 1);
      const auto motion = block.passes[block.looks.pass[i]].path.At(block.looks.time_s[i]);
      if (!std::isfinite(v) || !(r > 0.0) || !motion) return;
      const double sigma_rad =
          block.ApproximateAzimuthSigma_m(i, motion->velocity_mps.norm()) / block.looks.range_m[i];
      add(block.looks.range_m[i], sigma_rad * v / r, r / (sigma_rad * sigma_rad));
    });
  };
  for_looks([&](double at_m, double error_rad, double of_look) {
    weight += of_look;
    range_m += of_look * at_m;
    squint_rad += of_look * error_rad;
    ranges_m.push_back(at_m);
  });
  constexpr std::size_t kFewest = 5;
  if (ranges_m.size() < kFewest) return {};
  range_m /= weight;
  squint_rad /= weight;
  for_looks([&](double at_m, double error_rad, double of_look) {
    square += of_look * (at_m - range_m) * (at_m - range_m);
    product += of_look * (at_m - range_m) * (error_rad - squint_rad);
  });
  if (!(square > 0.0)) return {};
  // Three sigma: beside a constant that leaves noise alone a smaller slope is noise.
  constexpr double kMinSlope = 9.0, kNoise = 1.2;
  const bool noise = solved.fit.lost == 0 && solved.fit.square_sum < kNoise * solved.fit.redundancy;
  if (noise && !(product * product > kMinSlope * square)) return {};
  // About their mean range slope and constant are independent.
  const double constant_rad = solved.value;
  Hypothesis out = NativeDoppler(
      squint.passes,
      [constant_rad, range_m](double per_m) { return constant_rad - per_m * range_m; },
      -product / square,  // a look ahead is measured early
      1.0 / std::sqrt(square));
  out.screened = true;
  out.local = true;
  return out;
}

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
    return "block.toml: the other value of `look` " + PassesPhrase(passes);
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
    return "the values of " + name + " " + PassesPhrase(passes) + " " + factor.text;
  };
  out.change = [passes, factor, name](const Size&) {
    return "observations.csv: " + name + " " + PassesPhrase(passes) + " divided by " +
           InFiles(factor.value);
  };
  return out;
}

/// Dopplers in another unit, such as parts of the pulse rate, or of another wavelength.
Hypothesis DopplerFactor(const Names& passes, double factor) {
  Hypothesis out;
  out.kind = MistakeKind::kCone;
  out.cause = "cone.factor";
  out.passes = passes;
  out.undo = [passes](Block* block, double value) {
    ForLooks(*block, passes, [&](std::size_t i) { block->looks.cone[i] /= value; });
  };
  out.free = true;
  out.value = factor;
  out.step = 1e-3 * factor;
  out.unit = "1";
  out.says = [passes](const Size& size) {
    return "doppler_hz " + PassesPhrase(passes) + " are " + size.text +
           " times what known points show (another unit, such as parts of the pulse rate, or "
           "wavelength_m by that factor)";
  };
  out.change = [passes](const Size& size) {
    return "observations.csv: doppler_hz " + PassesPhrase(passes) + " divided by " +
           InFiles(size.value, size.sigma);
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
    return "the wavelength " + PassesPhrase(passes) + " is " + Short(size.value) +
           " times too large (" + factor.text + ")";
  };
  out.change = [passes](const Size& size) {
    return "block.toml: wavelength_m " + PassesPhrase(passes) + " divided by " +
           InFiles(size.value);
  };
  return out;
}

/// Sines of the squints at which known points are seen and that the looks give.
struct Squints {
  std::vector<double> ratio, range_m, off_rad;
  bool doppler = false, given = false;
};

Squints SquintsOf(const PassPredictions& pass) {
  Squints out;
  const Looks& looks = pass.part.looks;
  for (const PredictedLook& predicted : pass.predictions) {
    if (std::isnan(predicted.ahead_sine)) continue;
    double given_sine = 0.0;
    if (!looks.cone.empty()) {
      const double cone = looks.cone[predicted.look];
      const bool doppler = (looks.flags[predicted.look] & Looks::kDoppler) != 0;
      out.doppler = out.doppler || doppler;
      out.given = out.given || cone != 0.0;
      given_sine =
          doppler ? 0.5 * pass.part.passes[0].wavelength_m * cone / pass.speed_mps : std::sin(cone);
    }
    if (predicted.ahead_sine != 0.0) out.ratio.push_back(given_sine / predicted.ahead_sine);
    out.range_m.push_back(predicted.range_m);
    out.off_rad.push_back(std::asin(std::clamp(given_sine, -1.0, 1.0)) -
                          std::asin(predicted.ahead_sine));
  }
  return out;
}

/// The constant part of native Doppler at known points.
std::function<double(double)> ConstantOf(const Squints& squints) {
  return [squints](double per_m) {
    std::vector<double> left_rad;
    for (std::size_t k = 0; k < squints.off_rad.size(); ++k) {
      left_rad.push_back(squints.off_rad[k] - per_m * squints.range_m[k]);
    }
    return Median(std::move(left_rad));
  };
}

/// How clearly known points show native Doppler: their distance from the line beside its change
/// from near to far.
struct NativeShown {
  double unclear = 0.0;
  Hypothesis hypothesis;
};

void AddOf(const Names& passes,
           const Squints& squints,
           std::vector<NativeShown>* native,
           Hypotheses* out) {
  if (squints.given) {
    const char* column = squints.doppler ? "doppler_hz" : "squint_deg";
    out->push_back(ScaledCone(passes, column, {-1.0, "have the wrong sign"}));
    if (squints.doppler) {
      constexpr double kFarFromOne = 0.01;
      const double factor = squints.ratio.size() < 3 ? 1.0 : Median(squints.ratio);
      if (factor > 0.0 && std::abs(factor - 1.0) > kFarFromOne) {
        out->push_back(DopplerFactor(passes, factor));
      }
      out->push_back(Wavelength(passes, {100.0, "centimetres for metres"}));
      out->push_back(Wavelength(passes, {1000.0, "millimetres for metres"}));
    } else {
      out->push_back(ScaledCone(passes, column, {kRadPerDeg, "are radians, not degrees"}));
    }
  }
  if (squints.doppler || squints.off_rad.size() < 3) return;
  constexpr double kSquintStep_rad = 1e-6;
  out->push_back(SquintBias(passes, Median(squints.off_rad), kSquintStep_rad));
  constexpr std::size_t kFewest = 5;
  if (squints.off_rad.size() < kFewest) return;
  const Line line = RobustLine(squints.range_m, squints.off_rad);
  const auto [nearest, farthest] =
      std::minmax_element(squints.range_m.begin(), squints.range_m.end());
  if (!(*farthest > *nearest)) return;
  const double across_m = *farthest - *nearest;
  native->push_back(
      {line.spread / (std::abs(line.slope) * across_m),
       NativeDoppler(passes, ConstantOf(squints), line.slope, kSquintStep_rad / across_m)});
}

/// Errors of the flights hide from the screening that a squint changes: those whose points show it
/// most clearly are solved without it.
void AddNative(std::vector<NativeShown> native, Hypotheses* out) {
  constexpr std::size_t kMost = 3;
  constexpr double kClear = 0.2;
  std::stable_sort(native.begin(), native.end(), [](const NativeShown& a, const NativeShown& b) {
    return a.unclear < b.unclear;
  });
  for (std::size_t i = 0; i < native.size(); ++i) {
    Hypothesis& hypothesis = native[i].hypothesis;
    hypothesis.screened = hypothesis.local = i < kMost && native[i].unclear < kClear;
    out->push_back(std::move(hypothesis));
  }
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
    return "observations.csv: squint_deg " + PassesPhrase(passes) +
           (size.value > 0.0 ? " minus " : " plus ") +
           InFiles(std::abs(kDegPerRad * size.value), kDegPerRad * size.sigma) +
           ", or correction.squint " + PassesPhrase(passes);
  };
  return out;
}

void AddConeMistakes(const Facts& facts, Hypotheses* out) {
  Names turned;
  Squints all;
  std::vector<NativeShown> native;
  for (const PassPredictions& pass : facts.passes) {
    const std::string& id = facts.sample.block.passes[pass.pass].id;
    const auto wrong = std::count_if(pass.predictions.begin(),
                                     pass.predictions.end(),
                                     [](const PredictedLook& s) { return !s.on_its_side; });
    if (2 * static_cast<std::size_t>(wrong) > pass.predictions.size()) turned.push_back(id);
    if (pass.predictions.empty()) {
      out->push_back(WrongSide({id}));
      out->back().screened = true;
    }
    const Squints squints = SquintsOf(pass);
    AddOf({id}, squints, &native, out);
    all.off_rad.insert(all.off_rad.end(), squints.off_rad.begin(), squints.off_rad.end());
    all.range_m.insert(all.range_m.end(), squints.range_m.begin(), squints.range_m.end());
    all.ratio.insert(all.ratio.end(), squints.ratio.begin(), squints.ratio.end());
    all.doppler = all.doppler || squints.doppler;
    all.given = all.given || squints.given;
  }
  if (!turned.empty()) {
    out->push_back(WrongSide(turned));
    out->back().screened = true;
    out->back().order = Hypothesis::kReported;
  }
  if (facts.passes.size() > 1) AddOf({}, all, &native, out);
  AddNative(std::move(native), out);
}

}  // namespace sarblock
