// SPDX-License-Identifier: Apache-2.0
#include "image_offsets.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <fmt/core.h>

namespace sarblock {
namespace {

// Standard deviation of the median of normally distributed values, from their absolute deviations.
double SigmaOfMedian(std::vector<double> values, double median) {
  for (double& value : values) value = std::abs(value - median);
  const auto count = static_cast<double>(values.size());
  return 1.4826 * 1.2533 * Median(std::move(values)) / std::sqrt(count);
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

std::optional<ImageCoordinates> PlaceInImage(const Pass& pass, const Eigen::Vector3d& p_m) {
  const auto time_s = FindConeTime(pass.path, p_m, Cone{}, pass.path.start_s(), pass.path.end_s());
  if (!time_s) return std::nullopt;
  const auto motion = pass.path.At(*time_s);
  if (!motion) return std::nullopt;
  return ImageFromRadar(*pass.image, {*time_s, (p_m - motion->position_m).norm()});
}

void OffsetCollector::Add(std::size_t index,
                          const Pass& pass,
                          const RadarCoordinates& measured,
                          const Eigen::Vector3d& p_m) {
  const auto given_px = PlaceInImage(pass, p_m);
  const auto measured_px = ImageFromRadar(*pass.image, measured);
  if (given_px && measured_px) Add(index, *measured_px, *given_px);
}

void OffsetCollector::Add(std::size_t index,
                          const ImageCoordinates& measured_px,
                          const ImageCoordinates& given_px) {
  if (index >= lines_px_.size()) {
    lines_px_.resize(index + 1);
    samples_px_.resize(index + 1);
  }
  lines_px_[index].push_back(measured_px.line_px - given_px.line_px);
  samples_px_[index].push_back(measured_px.pixel_px - given_px.pixel_px);
}

std::vector<PixelOffset> OffsetCollector::Offsets(std::size_t passes) const {
  std::vector<PixelOffset> offsets(passes);
  for (std::size_t i = 0; i < lines_px_.size(); ++i) {
    PixelOffset& offset = offsets[i];
    offset.looks = lines_px_[i].size();
    if (offset.looks == 0) continue;
    offset.line_px = Median(lines_px_[i]);
    offset.sample_px = Median(samples_px_[i]);
    offset.line_sigma_px = SigmaOfMedian(lines_px_[i], offset.line_px);
    offset.sample_sigma_px = SigmaOfMedian(samples_px_[i], offset.sample_px);
  }
  return offsets;
}

std::vector<std::string> NameOffsets(const Block& block,
                                     const std::vector<PixelOffset>& offsets,
                                     const std::array<double, 2>& pixel_origin_px,
                                     const std::string& measured_by,
                                     const std::string& option) {
  constexpr double kNear_px = 0.15;
  constexpr std::size_t kFewestLooks = 5;
  const auto near = [](double value_px, double sigma_px, double mistake_px) {
    return std::abs(value_px - mistake_px) < kNear_px && 3.0 * sigma_px < kNear_px;
  };
  std::vector<std::string> remarks;
  for (const Mistake& mistake : kMistakes) {
    std::string passes;
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const PixelOffset& offset = offsets[i];
      if (offset.looks >= kFewestLooks &&
          near(offset.line_px, offset.line_sigma_px, mistake.line_px) &&
          near(offset.sample_px, offset.sample_sigma_px, mistake.sample_px)) {
        passes += (passes.empty() ? "" : ", ") + block.passes[i].id;
      }
    }
    if (passes.empty()) continue;
    remarks.push_back(fmt::format(
        "{}: measures lie {} {} where the given positions of the points are. If {} counts "
        "pixels from another origin or was measured with other start times, {} "
        "{:g},{:g} takes it up",
        passes,
        mistake.name,
        mistake.line_px + mistake.sample_px > 0.0 ? "after" : "before",
        measured_by,
        option,
        pixel_origin_px[0] + mistake.line_px,
        pixel_origin_px[1] + mistake.sample_px));
  }
  return remarks;
}

}  // namespace sarblock
