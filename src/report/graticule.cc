// SPDX-License-Identifier: Apache-2.0
#include "graticule.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "statistics.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr int kSamples = 12;   // a side of a box, to find which degrees it spans
constexpr int kVertices = 48;  // of a line
constexpr double kLines = 3.0;

struct Span {
  double low_deg = kAbsent, high_deg = kAbsent;
  void Add(double angle_deg) {
    low_deg = std::fmin(low_deg, angle_deg);
    high_deg = std::fmax(high_deg, angle_deg);
  }
  /// Round degrees between the lines; 30 where the meridians meet in the box.
  [[nodiscard]] double Step_deg() const {
    const double size_deg = high_deg - low_deg;
    return size_deg > 180.0 ? 30.0 : RoundDown125(std::max(size_deg, 1e-7) / kLines);
  }
};

/// Latitudes and longitudes of a box; these from that of the middle, so that 180 degrees are no
/// border.
struct Degrees {
  Span lat, lon;
};

Degrees DegreesOf(const Frame& frame, const MapPlane& plane, const MapBox& box, double middle_deg) {
  Degrees out;
  for (int i = 0; i <= kSamples; ++i) {
    for (int k = 0; k <= kSamples; ++k) {
      const Geodetic at = frame.GeodeticFromFrame(
          plane.PositionAt({box.low_m[0] + (box.high_m[0] - box.low_m[0]) * i / kSamples,
                            box.low_m[1] + (box.high_m[1] - box.low_m[1]) * k / kSamples}));
      out.lat.Add(at.lat_rad * kDegPerRad);
      out.lon.Add(std::remainder(at.lon_rad * kDegPerRad - middle_deg, 360.0));
    }
  }
  return out;
}

std::string NameOfDegrees(double angle_deg,
                          double step_deg,
                          const char* positive,
                          const char* negative) {
  const int places = std::max(0, -static_cast<int>(std::floor(std::log10(step_deg) + 1e-9)));
  if (std::abs(angle_deg) < 0.5 * step_deg) return "0\xc2\xb0";
  return fmt::format(
      "{:.{}f}\xc2\xb0 {}", std::abs(angle_deg), places, angle_deg > 0.0 ? positive : negative);
}

}  // namespace

void MapBox::Add(const std::array<double, 2>& place_m) {
  for (std::size_t k = 0; k < 2; ++k) {
    low_m[k] = std::fmin(low_m[k], place_m[k]);
    high_m[k] = std::fmax(high_m[k], place_m[k]);
  }
}

MapBox MapBox::Widened(double margin_m) const {
  return {{low_m[0] - margin_m, low_m[1] - margin_m}, {high_m[0] + margin_m, high_m[1] + margin_m}};
}

std::vector<MapChart::Line> GraticuleOf(const Frame& frame,
                                        const MapPlane& plane,
                                        const MapBox& seen,
                                        const MapBox& drawn) {
  std::vector<MapChart::Line> lines;
  if (frame.kind() != FrameKind::kGeocentric) return lines;
  const Geodetic middle = frame.GeodeticFromFrame(plane.origin_m());
  const double middle_deg = middle.lon_rad * kDegPerRad;
  const Degrees whole = DegreesOf(frame, plane, drawn, middle_deg);
  const Span &lat = whole.lat, &lon = whole.lon;
  const Degrees crossed = DegreesOf(frame, plane, seen, middle_deg);
  const auto add = [&](const std::string& name, auto&& geodetic_deg) {
    MapChart::Line line{name, {}};
    for (int v = 0; v <= kVertices; ++v) {
      const std::array<double, 2> at_deg = geodetic_deg(static_cast<double>(v) / kVertices);
      line.places.push_back(plane.Place(
          frame.FrameFromGeodetic({at_deg[0] * kRadPerDeg, at_deg[1] * kRadPerDeg, middle.h_m})));
    }
    lines.push_back(std::move(line));
  };
  const double lat_step = crossed.lat.Step_deg(), lon_step = crossed.lon.Step_deg();
  for (double at = std::ceil(lat.low_deg / lat_step) * lat_step; at <= lat.high_deg;
       at += lat_step) {
    if (std::abs(at) > 89.999) continue;
    add(NameOfDegrees(at, lat_step, "N", "S"), [&](double part) {
      return std::array<double, 2>{at,
                                   middle_deg + lon.low_deg + part * (lon.high_deg - lon.low_deg)};
    });
  }
  const double first = std::ceil((middle_deg + lon.low_deg) / lon_step) * lon_step;
  for (double at = first; at <= middle_deg + lon.high_deg; at += lon_step) {
    const double name_deg = std::remainder(at, 360.0);
    add(NameOfDegrees(name_deg, lon_step, "E", "W"), [&](double part) {
      return std::array<double, 2>{lat.low_deg + part * (lat.high_deg - lat.low_deg), at};
    });
  }
  return lines;
}

}  // namespace sarblock
