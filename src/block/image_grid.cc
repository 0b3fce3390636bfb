// SPDX-License-Identifier: Apache-2.0
#include "sarblock/block/image_grid.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace sarblock {
namespace {

struct Slope {
  double range_m = 0.0;
  double per_ground = 0.0;  ///< dR/dg
};

// Horner's rule for the polynomial and its derivative.
Slope Evaluate(const GroundRangePolynomial& polynomial, double ground_m) {
  const double u_m = ground_m - polynomial.origin_m;
  Slope slope;
  for (auto c = polynomial.coefficients.rbegin(); c != polynomial.coefficients.rend(); ++c) {
    slope.per_ground = slope.per_ground * u_m + slope.range_m;
    slope.range_m = slope.range_m * u_m + *c;
  }
  return slope;
}

// R(g, t): linear in time between neighbours.
Slope GroundToSlant(const std::vector<GroundRangePolynomial>& all, double ground_m, double time_s) {
  const auto after = std::upper_bound(
      all.begin(), all.end(), time_s, [](double wanted_s, const GroundRangePolynomial& entry) {
        return wanted_s < entry.time_s;
      });
  if (after == all.begin()) return Evaluate(all.front(), ground_m);
  if (after == all.end()) return Evaluate(all.back(), ground_m);
  const auto before = after - 1;
  const double part = (time_s - before->time_s) / (after->time_s - before->time_s);
  const Slope a = Evaluate(*before, ground_m), b = Evaluate(*after, ground_m);
  return {a.range_m + part * (b.range_m - a.range_m),
          a.per_ground + part * (b.per_ground - a.per_ground)};
}

std::optional<double> GroundFromSlant(const ImageGrid& grid, const RadarCoordinates& radar) {
  constexpr int kSteps = 50;
  constexpr double kCloseEnough_m = 1e-6;  // one more step then reaches the rounding
  double ground_m = grid.near_range_m;
  for (int step = 0; step < kSteps; ++step) {
    const Slope at = GroundToSlant(grid.ground_range, ground_m, radar.time_s);
    if (!(at.per_ground > 0.0)) return std::nullopt;
    const double change_m = (radar.range_m - at.range_m) / at.per_ground;
    ground_m += change_m;
    if (!std::isfinite(ground_m)) return std::nullopt;
    if (std::abs(change_m) > kCloseEnough_m) continue;
    const Slope end = GroundToSlant(grid.ground_range, ground_m, radar.time_s);
    return end.per_ground > 0.0 ? std::optional<double>(ground_m) : std::nullopt;
  }
  return std::nullopt;
}

double TimeOfLine(const ImageGrid& grid, double line_px) {
  if (grid.burst_start_s.empty()) return grid.first_line_s + line_px * grid.line_interval_s;
  const auto size = static_cast<double>(grid.lines_per_burst);
  const auto last = static_cast<double>(grid.burst_start_s.size() - 1);
  const double burst = std::clamp(std::floor(line_px / size), 0.0, last);
  return grid.burst_start_s[static_cast<std::size_t>(burst)] +
         (line_px - burst * size) * grid.line_interval_s;
}

std::optional<double> LineOfTime(const ImageGrid& grid, double time_s) {
  if (grid.burst_start_s.empty()) return (time_s - grid.first_line_s) / grid.line_interval_s;
  const auto size = static_cast<double>(grid.lines_per_burst);
  const double middle_px = (size - 1.0) / 2.0;
  std::size_t best = 0;
  double best_px = (time_s - grid.burst_start_s[0]) / grid.line_interval_s;
  for (std::size_t b = 1; b < grid.burst_start_s.size(); ++b) {
    const double local_px = (time_s - grid.burst_start_s[b]) / grid.line_interval_s;
    if (std::abs(local_px - middle_px) < std::abs(best_px - middle_px)) {
      best = b;
      best_px = local_px;
    }
  }
  const bool before = best_px < 0.0 && best > 0;
  const bool after = best_px >= size && best + 1 < grid.burst_start_s.size();
  if (before || after) return std::nullopt;
  return best_px + static_cast<double>(best) * size;
}

void RequirePositive(double value, const char* key) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InputError(key, "must be a number above 0, got " + std::to_string(value));
  }
}

void RequireFinite(double value, const std::string& key) {
  if (!std::isfinite(value)) throw InputError(key, "is not finite, a finite number is needed");
}

void CheckGroundRange(const ImageGrid& grid) {
  const bool ground = grid.presentation == Presentation::kGround;
  if (ground == grid.ground_range.empty()) {
    throw InputError("ground_range",
                     ground ? "is missing, a ground presentation needs its polynomial"
                            : "belongs to presentation = \"ground\"");
  }
  for (std::size_t i = 0; i < grid.ground_range.size(); ++i) {
    const GroundRangePolynomial& polynomial = grid.ground_range[i];
    const std::string key = "ground_range[" + std::to_string(i) + "]";
    if (polynomial.coefficients.size() < 2) {
      throw InputError(
          key + ".coefficients",
          std::to_string(polynomial.coefficients.size()) + " given, two or more are needed");
    }
    for (const double c : polynomial.coefficients) RequireFinite(c, key + ".coefficients");
    RequireFinite(polynomial.origin_m, key + ".origin_m");
    RequireFinite(polynomial.time_s, key + ".time_s");
    if (i > 0 && !(polynomial.time_s > grid.ground_range[i - 1].time_s)) {
      throw InputError(key + ".time_s", "must be later than that of the polynomial before");
    }
  }
}

}  // namespace

void CheckImageGrid(const ImageGrid& grid) {
  RequireFinite(grid.first_line_s, "first_line_s");
  RequirePositive(grid.line_interval_s, "line_interval_s");
  RequirePositive(grid.range_spacing_m, "range_spacing_m");
  RequireFinite(grid.near_range_m, "near_range_m");
  if (grid.presentation == Presentation::kSlant) RequirePositive(grid.near_range_m, "near_range_m");
  CheckGroundRange(grid);
  if (grid.burst_start_s.empty() != (grid.lines_per_burst == 0)) {
    throw InputError("lines_per_burst", "burst_start_s and lines_per_burst belong together");
  }
  for (std::size_t b = 0; b < grid.burst_start_s.size(); ++b) {
    RequireFinite(grid.burst_start_s[b], "burst_start_s");
    if (b > 0 && !(grid.burst_start_s[b] > grid.burst_start_s[b - 1])) {
      throw InputError("burst_start_s", "times must increase");
    }
  }
}

std::optional<RadarCoordinates> RadarFromImage(const ImageGrid& grid,
                                               const ImageCoordinates& image) {
  RadarCoordinates radar{TimeOfLine(grid, image.line_px),
                         grid.near_range_m + image.pixel_px * grid.range_spacing_m};
  if (grid.presentation == Presentation::kGround) {
    const Slope at = GroundToSlant(grid.ground_range, radar.range_m, radar.time_s);
    if (!(at.per_ground > 0.0)) return std::nullopt;
    radar.range_m = at.range_m;
  }
  if (!(radar.range_m > 0.0) || !std::isfinite(radar.range_m) || !std::isfinite(radar.time_s)) {
    return std::nullopt;
  }
  return radar;
}

std::optional<ImageCoordinates> ImageFromRadar(const ImageGrid& grid,
                                               const RadarCoordinates& radar) {
  if (!(radar.range_m > 0.0) || !std::isfinite(radar.time_s)) return std::nullopt;
  const auto line_px = LineOfTime(grid, radar.time_s);
  const bool ground = grid.presentation == Presentation::kGround;
  const auto across_m =
      ground ? GroundFromSlant(grid, radar) : std::optional<double>(radar.range_m);
  if (!line_px || !across_m) return std::nullopt;
  return ImageCoordinates{*line_px, (*across_m - grid.near_range_m) / grid.range_spacing_m};
}

std::optional<double> SlantRangePerPixel_m(const ImageGrid& grid, const RadarCoordinates& radar) {
  if (grid.presentation == Presentation::kSlant) return grid.range_spacing_m;
  const auto ground_m = GroundFromSlant(grid, radar);
  if (!ground_m) return std::nullopt;
  const Slope at = GroundToSlant(grid.ground_range, *ground_m, radar.time_s);
  return at.per_ground * grid.range_spacing_m;
}

}  // namespace sarblock
