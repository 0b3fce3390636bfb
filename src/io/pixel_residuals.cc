// SPDX-License-Identifier: Apache-2.0
#include "pixel_residuals.h"

#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
namespace {

// e_d as a time over the line interval. The nominal path serves: a correction of 10 m changes the
// rate by a hundred-thousandth.
double LineResidual(const Block& block,
                    std::size_t look,
                    const Eigen::Vector3d& p_m,
                    double azimuth_residual_m) {
  const Pass& pass = block.passes[block.looks.pass[look]];
  const auto motion = pass.path.At(block.looks.time_s[look]);
  if (!motion) return kNotGiven;
  const double rate_mps = EvaluateCone(*motion, p_m, block.ConeOf(look)).rate_mps;
  return azimuth_residual_m / -rate_mps / pass.image->line_interval_s;
}

}  // namespace

PixelResiduals::PixelResiduals(const ResultView& view) : view_(view) {
  present_ = std::any_of(view.block.passes.begin(), view.block.passes.end(), [](const Pass& pass) {
    return pass.image.has_value();
  });
}

void PixelResiduals::Write(std::size_t look, std::size_t point, TableWriter* out) const {
  if (!present_) return;
  const Block& block = view_.block;
  const LookResults& looks = view_.result.looks;
  const Pass& pass = block.passes[block.looks.pass[look]];
  if (!pass.image) {
    out->Empty(4);
    return;
  }
  const RadarCoordinates radar{block.looks.time_s[look], block.looks.range_m[look]};
  const auto image = ImageFromRadar(*pass.image, radar);
  out->Number(image ? image->line_px : kNotGiven).Number(image ? image->pixel_px : kNotGiven);
  if (looks.range_residual_m.empty() || std::isnan(looks.range_residual_m[look])) {
    out->Empty(2);
    return;
  }
  out->Number(LineResidual(
      block, look, view_.result.points.position_m[point], looks.azimuth_residual_m[look]));
  const auto pixel_m = SlantRangePerPixel_m(*pass.image, radar);
  out->Number(pixel_m ? looks.range_residual_m[look] / *pixel_m : kNotGiven);
}

}  // namespace sarblock
