// SPDX-License-Identifier: Apache-2.0
#include "sigma_mistakes.h"

#include <cmath>
#include <string>
#include <utility>

#include "edits.h"
#include "words.h"

namespace sarblock {
namespace {

using Names = std::vector<std::string>;

enum class Measured { kRange, kAzimuth, kBoth };

const char* WordOf(Measured measured) {
  return measured == Measured::kRange     ? "ranges"
         : measured == Measured::kAzimuth ? "azimuths"
                                          : "ranges and azimuths";
}

/// What standard deviations are mistaken by; with one given value also its square root, which a
/// variance that was written as a standard deviation is too large by.
std::vector<KnownNumber> SigmaNumbers(double given) {
  std::vector<KnownNumber> numbers;
  if (given > 0.0 && std::abs(given - 1.0) > 0.05) {
    numbers.push_back({std::sqrt(given), "a variance given as standard deviation"});
  }
  numbers.push_back({100.0, "centimetres for metres, or a hundred"});
  numbers.push_back({0.01, "metres written as centimetres, or a hundred"});
  numbers.push_back({1000.0, "milliseconds for seconds, millimetres for metres"});
  numbers.push_back({0.001, "thousandths"});
  return numbers;
}

/// The value that all looks of some passes have; NaN where they differ.
double CommonSigma(const Block& block, const Names& passes, Measured measured) {
  double common = kNotGiven;
  bool differ = measured == Measured::kBoth;
  ForLooks(block, passes, [&](std::size_t i) {
    const LookSigma sigma = block.SigmaOf(i);
    const double value = measured == Measured::kRange ? sigma.range_m : sigma.azimuth;
    if (std::isnan(common)) common = value;
    differ = differ || value != common;
  });
  return differ ? kNotGiven : common;
}

Hypothesis ScaledSigma(const Block& block, const Names& passes, Measured measured, double factor) {
  Hypothesis out;
  out.kind = MistakeKind::kSigma;
  out.cause = measured == Measured::kRange     ? "sigma.range"
              : measured == Measured::kAzimuth ? "sigma.azimuth"
                                               : "sigma.all";
  out.passes = passes;
  out.undo = [passes, measured](Block* edited, double log_factor) {
    const double by = std::exp(-log_factor);
    const auto scale = [&](double* range, double* azimuth) {
      if (range != nullptr && measured != Measured::kAzimuth) *range *= by;
      if (azimuth != nullptr && measured != Measured::kRange) *azimuth *= by;
    };
    for (const std::uint32_t p : PassesOf(*edited, passes)) {
      LookSigma& sigma = edited->passes[p].sigma;
      scale(&sigma.range_m, &sigma.azimuth);
    }
    Looks& looks = edited->looks;
    ForLooks(*edited, passes, [&](std::size_t i) {
      scale(looks.range_sigma_m.empty() ? nullptr : &looks.range_sigma_m[i],
            looks.azimuth_sigma.empty() ? nullptr : &looks.azimuth_sigma[i]);
    });
  };
  out.free = true;
  out.logarithm = true;
  out.value = std::log(factor);
  out.step = 0.1;
  out.unit = "1";
  out.numbers = SigmaNumbers(CommonSigma(block, passes, measured));
  out.says = [passes, measured](const Size& size) {
    const bool large = size.value > 1.0;
    const double by = large ? size.value : 1.0 / size.value;
    return "the standard deviations of the " + std::string(WordOf(measured)) + " " +
           OfPasses(passes) + " are " + SizeOf(by, size.sigma / size.value * by, "").text +
           " times too " + (large ? "large" : "small");
  };
  out.change = [passes, measured](const Size& size) {
    return "block.toml: [sigma] (or the columns of observations.csv) of the " +
           std::string(WordOf(measured)) + " " + OfPasses(passes) + " divided by " +
           Short(size.value);
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// Square root of v'Pv over the redundancy of the ranges or of the azimuths alone; 0 where they
/// have none, or for both together.
double OwnS0(const SampleResiduals& residuals, Measured measured) {
  if (measured == Measured::kBoth) return 0.0;
  const Eigen::Index column = measured == Measured::kRange ? 0 : 1;
  double square_1 = 0.0, redundancy_1 = 0.0;
  for (Eigen::Index i = 0; i < residuals.whitened_1.rows(); ++i) {
    const double error_1 = residuals.whitened_1(i, column);
    const double part_1 = residuals.redundancy_1(i, column);
    if (!std::isfinite(error_1) || !std::isfinite(part_1)) continue;
    square_1 += error_1 * error_1;
    redundancy_1 += part_1;
  }
  return redundancy_1 > 1.0 ? std::sqrt(square_1 / redundancy_1) : 0.0;
}

}  // namespace

void AddSigmaMistakes(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  const double s0_1 = std::sqrt(facts.before.square_sum_1 / facts.before.redundancy_1);
  if (!(s0_1 > 0.0) || !std::isfinite(s0_1)) return;
  for (const Measured measured : {Measured::kBoth, Measured::kRange, Measured::kAzimuth}) {
    const double own_s0_1 = OwnS0(facts.residuals, measured);
    out->push_back(ScaledSigma(block, {}, measured, 1.0 / (own_s0_1 > 0.0 ? own_s0_1 : s0_1)));
    if (block.passes.size() < 2) continue;
    for (const Pass& pass : block.passes) {
      // A pass whose residuals are the rule is none to ask of.
      double sum_1 = 0.0, count = 0.0;
      ForLooks(block, {pass.id}, [&](std::size_t i) {
        const auto row = facts.residuals.whitened_1.row(static_cast<Eigen::Index>(i));
        const double square_1 = measured == Measured::kRange     ? row[0] * row[0]
                                : measured == Measured::kAzimuth ? row[1] * row[1]
                                                                 : row.squaredNorm();
        if (!std::isfinite(square_1)) return;
        sum_1 += square_1;
        count += measured == Measured::kBoth ? 2.0 : 1.0;
      });
      const double all_1 =
          facts.before.square_sum_1 / (2.0 * static_cast<double>(facts.before.looks));
      const double share_1 = count > 0.0 ? sum_1 / count / all_1 : 1.0;
      if (share_1 < 1.3 && share_1 > 0.3) continue;
      if (share_1 > 1.0 && sum_1 < 0.3 * facts.before.square_sum_1) continue;
      out->push_back(ScaledSigma(block, {pass.id}, measured, 1.0 / std::sqrt(share_1 * all_1)));
    }
  }
}

}  // namespace sarblock
