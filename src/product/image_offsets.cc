// SPDX-License-Identifier: Apache-2.0
#include "image_offsets.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "core/median.h"
#include "geometry/cone_time.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

// Standard deviation of the median of normally distributed values, from their absolute deviations.
double SigmaOfMedian(std::vector<double> values, double median) {
  for (double& value : values) value = std::abs(value - median);
  const auto count = static_cast<double>(values.size());
  return 1.4826 * 1.2533 * Median(std::move(values)) / std::sqrt(count);
}

std::optional<ImageCoordinates> Projected(const Pass& pass, const Eigen::Vector3d& p_m) {
  const auto time_s = FindConeTime(pass.path, p_m, Cone{}, pass.path.start_s(), pass.path.end_s());
  if (!time_s) return std::nullopt;
  const auto motion = pass.path.At(*time_s);
  if (!motion) return std::nullopt;
  return ImageFromRadar(*pass.image, {*time_s, (p_m - motion->position_m).norm()});
}

struct Mistake {
  double line_px, sample_px;
  const char* name;
};
constexpr Mistake kMistakes[] = {{0.5, 0.5, "half a pixel in line and sample"},
                                 {-0.5, -0.5, "half a pixel in line and sample"},
                                 {0.5, 0.0, "half a line"},
                                 {-0.5, 0.0, "half a line"},
                                 {0.0, 0.5, "half a sample"},
                                 {0.0, -0.5, "half a sample"},
                                 {1.0, 0.0, "one line"},
                                 {-1.0, 0.0, "one line"}};

}  // namespace

void MeasureOffsets(ImportedNetwork* imported) {
  const Block& block = imported->block;
  std::vector<std::vector<double>> lines_px(block.passes.size()), samples_px(block.passes.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    const Eigen::Vector3d& p_m = block.points.given_m[point];
    if (!p_m.allFinite()) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.rejected(i)) continue;
      const Pass& pass = block.passes[block.looks.pass[i]];
      const auto given = Projected(pass, p_m);
      const auto measured =
          ImageFromRadar(*pass.image, {block.looks.time_s[i], block.looks.range_m[i]});
      if (!given || !measured) continue;
      lines_px[block.looks.pass[i]].push_back(measured->line_px - given->line_px);
      samples_px[block.looks.pass[i]].push_back(measured->pixel_px - given->pixel_px);
    }
  }
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    ImportedImage& image = imported->images[pass];
    image.offset_looks = lines_px[pass].size();
    if (image.offset_looks == 0) continue;
    image.line_offset_px = Median(lines_px[pass]);
    image.sample_offset_px = Median(samples_px[pass]);
    image.line_offset_sigma_px = SigmaOfMedian(std::move(lines_px[pass]), image.line_offset_px);
    image.sample_offset_sigma_px =
        SigmaOfMedian(std::move(samples_px[pass]), image.sample_offset_px);
  }
}

std::vector<std::string> NameOffsets(const ImportedNetwork& imported,
                                     const std::array<double, 2>& pixel_origin_px) {
  constexpr double kNear_px = 0.15;
  constexpr std::size_t kFewestLooks = 5;
  const auto near = [](double value_px, double sigma_px, double mistake_px) {
    return std::abs(value_px - mistake_px) < kNear_px && 3.0 * sigma_px < kNear_px;
  };
  std::vector<std::string> remarks;
  for (const Mistake& mistake : kMistakes) {
    std::string passes;
    for (const ImportedImage& image : imported.images) {
      if (image.offset_looks >= kFewestLooks &&
          near(image.line_offset_px, image.line_offset_sigma_px, mistake.line_px) &&
          near(image.sample_offset_px, image.sample_offset_sigma_px, mistake.sample_px)) {
        passes += (passes.empty() ? "" : ", ") + image.pass;
      }
    }
    if (passes.empty()) continue;
    remarks.push_back(fmt::format(
        "{}: measures lie {} {} where the given positions of the points are. If the network counts "
        "pixels from another origin or was measured with other start times, --pixel-origin "
        "{:g},{:g} takes it up",
        passes,
        mistake.name,
        mistake.line_px + mistake.sample_px > 0.0 ? "after" : "before",
        pixel_origin_px[0] + mistake.line_px,
        pixel_origin_px[1] + mistake.sample_px));
  }
  return remarks;
}

}  // namespace sarblock
