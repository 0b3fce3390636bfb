// SPDX-License-Identifier: Apache-2.0
// Images at native Doppler, read as those of zero Doppler.
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mistake.h"
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

}  // namespace sarblock
