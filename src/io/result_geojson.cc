// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "result_tables.h"
#include <nlohmann/json.hpp>

namespace sarblock {
namespace {

constexpr int kVertices = 36;

// Half axes of the 1-sigma error ellipse and the azimuth of the longer one, clockwise from north.
struct ErrorEllipse {
  double major_m = 0.0;
  double minor_m = 0.0;
  double azimuth_rad = 0.0;  // in [0, pi)
};

// Eigenvalues of [[ee, en], [en, nn]] in closed form.
ErrorEllipse EllipseOf(const SymmetricEnu& covariance_m2, double factor) {
  const double ee = factor * covariance_m2[0], nn = factor * covariance_m2[1];
  const double en = factor * covariance_m2[3];
  const double mean = 0.5 * (ee + nn);
  const double radius = std::hypot(0.5 * (nn - ee), en);
  ErrorEllipse ellipse;
  ellipse.major_m = std::sqrt(mean + radius);
  ellipse.minor_m = std::sqrt(std::max(mean - radius, 0.0));
  ellipse.azimuth_rad = 0.5 * std::atan2(2.0 * en, nn - ee);
  if (ellipse.azimuth_rad < 0.0) ellipse.azimuth_rad += std::numbers::pi;
  return ellipse;
}

// Fixed notation: 12 decimals of a degree are 0.1 micrometre, so that small ellipses keep shape.
void AppendDegrees(double value_deg, std::string* text) {
  std::array<char, 48> digits;
  const auto [end, error] = std::to_chars(
      digits.data(), digits.data() + digits.size(), value_deg, std::chars_format::fixed, 12);
  static_cast<void>(error);  // |value| <= 360 fits
  text->append(digits.data(), end);
}

void AppendNumber(const char* key, double value, std::string* text) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  static_cast<void>(error);
  text->append(",\"").append(key).append("\":");
  if (std::isfinite(value)) {
    text->append(digits.data(), end);
  } else {
    text->append("null");
  }
}

std::string JsonText(std::string_view text) {
  return nlohmann::json(std::string(text))
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// Ring of the ellipse in true size about p, in the tangent plane, as longitude and latitude.
// Longitudes stay near that of the centre, so that a ring across 180 degrees is not torn.
void AppendRing(const Frame& frame,
                const Eigen::Vector3d& p_m,
                const Geodetic& centre,
                const ErrorEllipse& ellipse,
                std::string* text) {
  const Eigen::Matrix3d frame_from_enu = frame.EnuFromFrame(p_m).transpose();
  const double sin_azimuth = std::sin(ellipse.azimuth_rad);
  const double cos_azimuth = std::cos(ellipse.azimuth_rad);
  for (int i = 0; i <= kVertices; ++i) {  // counter-clockwise, the first vertex again at the end
    const double angle = -2.0 * std::numbers::pi * (i % kVertices) / kVertices;
    const double along_m = ellipse.major_m * std::cos(angle);
    const double across_m = ellipse.minor_m * std::sin(angle);
    const Eigen::Vector3d offset_enu_m(along_m * sin_azimuth + across_m * cos_azimuth,
                                       along_m * cos_azimuth - across_m * sin_azimuth,
                                       0.0);
    const Geodetic vertex = frame.GeodeticFromFrame(p_m + frame_from_enu * offset_enu_m);
    const double turn = std::remainder(vertex.lon_rad - centre.lon_rad, 2.0 * std::numbers::pi);
    text->append(i == 0 ? "[" : ",[");
    AppendDegrees((centre.lon_rad + turn) * kDegPerRad, text);
    text->append(",");
    AppendDegrees(vertex.lat_rad * kDegPerRad, text);
    text->append("]");
  }
}

void AppendPoint(const ResultView& view, std::size_t i, bool polygons, std::string* text) {
  const PointResults& points = view.result.points;
  const Eigen::Vector3d& p_m = points.position_m[i];
  const Geodetic place = view.block.frame.GeodeticFromFrame(p_m);
  const std::string id = JsonText(view.block.points.ids[i]);
  const auto begin = static_cast<std::uint32_t>(i);
  text->append("{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
  text->append(",\"role\":\"").append(NameOf(view.block.points.role[i]));
  text->append("\",\"status\":\"").append(NameOf(points.status[i])).append("\"");
  text->append(",\"looks\":").append(std::to_string(points.looks[begin]));
  const bool sigmas = !points.covariance_m2.empty() && std::isfinite(points.covariance_m2[i][0]);
  ErrorEllipse ellipse;
  if (sigmas) {
    const SymmetricEnu& c = points.covariance_m2[i];
    ellipse = EllipseOf(c, view.factor);
    AppendNumber("sigma_e_m", std::sqrt(view.factor * c[0]), text);
    AppendNumber("sigma_n_m", std::sqrt(view.factor * c[1]), text);
    AppendNumber("sigma_u_m", std::sqrt(view.factor * c[2]), text);
    AppendNumber("ellipse_major_m", ellipse.major_m, text);
    AppendNumber("ellipse_minor_m", ellipse.minor_m, text);
    AppendNumber("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad, text);
  }
  text->append("},\"geometry\":{\"type\":\"Point\",\"coordinates\":[");
  AppendDegrees(place.lon_rad * kDegPerRad, text);
  text->append(",");
  AppendDegrees(place.lat_rad * kDegPerRad, text);
  text->append(",");
  std::array<char, 64> height;
  const auto [end, error] = std::to_chars(height.data(), height.data() + height.size(), place.h_m);
  static_cast<void>(error);
  text->append(height.data(), end).append("]}}");
  if (!sigmas || !polygons) return;
  text->append(",\n{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
  text->append(",\"ellipse\":\"1 sigma, true size\"");
  AppendNumber("ellipse_major_m", ellipse.major_m, text);
  AppendNumber("ellipse_minor_m", ellipse.minor_m, text);
  AppendNumber("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad, text);
  text->append("},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[");
  AppendRing(view.block.frame, p_m, place, ellipse, text);
  text->append("]]}}");
}

}  // namespace

void WriteGeoJson(const std::filesystem::path& file, const ResultView& view) {
  const PointResults& points = view.result.points;
  const bool polygons = points.status.size() <= view.context.ellipse_limit;
  AtomicFile out(file);
  out.Write("{\"type\":\"FeatureCollection\",\"name\":" + JsonText(view.block.name) +
            ",\"features\":[");
  std::string text;
  bool first = true;
  for (std::size_t i = 0; i < points.status.size(); ++i) {
    if (!IsSolved(points.status[i]) || !points.position_m[i].allFinite()) continue;
    text = first ? "\n" : ",\n";
    first = false;
    AppendPoint(view, i, polygons, &text);
    out.Write(text);
  }
  out.Write("\n]}\n");
  out.Commit();
}

}  // namespace sarblock
