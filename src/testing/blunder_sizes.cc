// SPDX-License-Identifier: Apache-2.0
#include "blunder_sizes.h"

#include <cmath>

#include "quality_summary.h"
#include "reliability.h"

namespace sarblock {

BlunderSizes::BlunderSizes(const Block& block,
                           const AdjustOptions& options,
                           const AdjustResult& result,
                           double factor_1)
    : block_(block),
      result_(result),
      delta0_1_(result.quality.empty() && result.control_quality.empty()
                    ? kNotGiven
                    : ReliabilityOf(options, result).delta0_1),
      scale_1_(std::sqrt(factor_1)),
      sigma_factor_1_(block.passes.size(), {1.0, 1.0}) {
  if (result.variance_components) {
    sigma_factor_1_ = SigmaFactors(result.variance_components->components, block.passes.size());
  }
}

std::array<BlunderSize, 2> BlunderSizes::OfLook(std::uint64_t look, std::size_t point) const {
  const LookQuality& quality = result_.quality;
  const std::array<double, 2>& factor_1 = sigma_factor_1_[block_.looks.pass[look]];
  std::array<BlunderSize, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto redundancy_1 = static_cast<double>(quality.redundancy_1[k][look]);
    if (std::isnan(redundancy_1)) continue;
    const double given_m = k == 0 ? block_.SigmaOf(look).range_m
                                  : AzimuthSigma_m(block_, look, result_.points.position_m[point]);
    out[k].sigma_m = factor_1[k] * given_m;
    out[k].detectable_m = MinimalDetectable(delta0_1_, scale_1_ * out[k].sigma_m, redundancy_1);
    out[k].influence_m = Influence_m(
        delta0_1_, scale_1_ * static_cast<double>(quality.shift_m[k][look]), redundancy_1);
  }
  return out;
}

BlunderSize BlunderSizes::OfControl(const ControlQuality& control) const {
  const KnownPosition& known = *block_.points.FindKnown(control.point);
  BlunderSize out;
  out.sigma_m = std::sqrt(known.covariance_enu_m2(control.component, control.component));
  out.detectable_m = MinimalDetectable(delta0_1_, scale_1_ * out.sigma_m, control.redundancy_1);
  out.influence_m = Influence_m(delta0_1_, scale_1_ * control.shift_m, control.redundancy_1);
  return out;
}

}  // namespace sarblock
