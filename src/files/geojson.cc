// SPDX-License-Identifier: Apache-2.0
#include "geojson.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/text.h"
#include "quality/covariance.h"
#include "tables/table.h"
#include <nlohmann/json.hpp>

namespace sarblock::files {
namespace {

// Fixed notation: 12 decimals of a degree are 0.1 micrometre, so that small ellipses keep shape.
void AppendDegrees(double value_deg, std::string* text) {
  std::array<char, 48> digits;
  const auto [end, error] = std::to_chars(
      digits.data(), digits.data() + digits.size(), value_deg, std::chars_format::fixed, 12);
  static_cast<void>(error);  // |value| <= 540 fits
  text->append(digits.data(), end);
}

void AppendProperty(const char* key, double value, std::string* text) {
  text->append(",\"").append(key).append("\":");
  if (std::isfinite(value)) {
    AppendNumber(value, text);
  } else {
    text->append("null");
  }
}

std::string JsonText(std::string_view text) {
  return nlohmann::json(std::string(text))
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void AppendPlace(const Geodetic& place, std::string* text) {
  AppendDegrees(place.lon_rad * kDegPerRad, text);
  text->append(",");
  AppendDegrees(place.lat_rad * kDegPerRad, text);
}

/// The features as text, each with a comma and a new line before it.
class Features {
 public:
  explicit Features(const GeoJsonContent& content) : content_(content) {
    if (content.confidence) scale_ = EllipseScale(*content.confidence);
    ellipse_text_ = content.confidence
                        ? NumberText(100.0 * *content.confidence) + " percent, true size"
                        : "1 sigma, true size";
  }

  void Point(std::size_t i, std::string* text) const {
    const PointResults& points = content_.points;
    const Eigen::Vector3d& p_m = points.position_m[i];
    if (!IsSolved(points.status[i]) || !p_m.allFinite()) return;
    const Geodetic place = content_.frame.GeodeticFromFrame(p_m);
    const std::string id = JsonText(content_.ids[i]);
    text->append(",\n{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
    text->append(",\"role\":\"").append(NameOf(content_.role[i]));
    text->append("\",\"status\":\"").append(NameOf(points.status[i])).append("\"");
    text->append(",\"looks\":").append(std::to_string(points.looks[i]));
    const bool sigmas = !points.covariance_m2.empty() && std::isfinite(points.covariance_m2[i][0]);
    ErrorEllipse ellipse;
    if (sigmas) {
      const SymmetricEnu& c = points.covariance_m2[i];
      ellipse = EllipseOf(c, scale_);
      AppendProperty("sigma_e_m", std::sqrt(c[0]), text);
      AppendProperty("sigma_n_m", std::sqrt(c[1]), text);
      AppendProperty("sigma_u_m", std::sqrt(c[2]), text);
      AppendEllipse(ellipse, text);
    }
    Check(i, text);
    text->append("},\"geometry\":{\"type\":\"Point\",\"coordinates\":[");
    AppendPlace(place, text);
    text->append(",");
    AppendNumber(place.h_m, text);
    text->append("]}}");
    if (sigmas && content_.polygons) Polygon(id, p_m, ellipse, text);
  }

  void Path(const std::string& id, const FlightPath& path, std::string* text) const {
    text->append(",\n{\"type\":\"Feature\",\"properties\":{\"pass\":").append(JsonText(id));
    AppendProperty("start_s", path.start_s(), text);
    AppendProperty("end_s", path.end_s(), text);
    text->append("},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[");
    const char* separator = "[";
    for (const StateVector& state : path.states()) {
      const Geodetic place = content_.frame.GeodeticFromFrame(state.position_m);
      text->append(separator);
      AppendPlace(place, text);
      text->append(",");
      AppendNumber(place.h_m, text);
      text->append("]");
      separator = ",[";
    }
    text->append("]}}");
  }

 private:
  static void AppendEllipse(const ErrorEllipse& ellipse, std::string* text) {
    AppendProperty("ellipse_major_m", ellipse.major_m, text);
    AppendProperty("ellipse_minor_m", ellipse.minor_m, text);
    AppendProperty("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad, text);
  }
  // `checks` are sorted by point.
  void Check(std::size_t i, std::string* text) const {
    if (content_.checks == nullptr) return;
    const CheckResult* check = FindCheck(*content_.checks, static_cast<std::uint32_t>(i));
    if (check == nullptr) return;
    AppendProperty("error_e_m", check->error_enu_m.x(), text);
    AppendProperty("error_n_m", check->error_enu_m.y(), text);
    AppendProperty("error_u_m", check->error_enu_m.z(), text);
  }
  void Polygon(const std::string& id,
               const Eigen::Vector3d& p_m,
               const ErrorEllipse& ellipse,
               std::string* text) const {
    text->append(",\n{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
    text->append(",\"ellipse\":\"").append(ellipse_text_).append("\"");
    AppendEllipse(ellipse, text);
    text->append("},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[");
    const auto ring = EllipseRing(content_.frame, p_m, ellipse);
    for (const Geodetic& corner : ring) {
      text->append("[");
      AppendPlace(corner, text);
      text->append("],");
    }
    text->append("[");
    AppendPlace(ring[0], text);
    text->append("]]]}}");
  }

  const GeoJsonContent& content_;
  double scale_ = 1.0;
  std::string ellipse_text_;
};

}  // namespace

const CheckResult* FindCheck(const std::vector<CheckResult>& checks, std::uint32_t point) {
  const auto found = std::lower_bound(
      checks.begin(), checks.end(), point, [](const CheckResult& check, std::uint32_t wanted) {
        return check.point < wanted;
      });
  return found == checks.end() || found->point != point ? nullptr : &*found;
}

namespace {

constexpr std::size_t kPointsAtOnce = 2048;  // with polygons some megabytes

}  // namespace

void WriteGeoJson(const std::filesystem::path& file, const GeoJsonContent& content) {
  const Features features(content);
  AtomicFile out(file);
  out.Write("{\"type\":\"FeatureCollection\",\"generator\":\"sarblock\",\"name\":" +
            JsonText(content.name) + ",\"features\":[");
  bool first = true;
  const auto write = [&](std::string* text) {  // the first feature has no comma before it
    out.Write(std::string_view(*text).substr(first && !text->empty() ? 1 : 0));
    first &= text->empty();
    text->clear();
  };
  MakeInOrder<std::string>(
      content.points.status.size(),
      kPointsAtOnce,
      [&](std::size_t begin, std::size_t end, std::string* text) {
        for (std::size_t i = begin; i < end; ++i) features.Point(i, text);
      },
      write);
  std::string text;
  for (const auto& [id, path] : content.paths) {
    features.Path(id, *path, &text);
    write(&text);
  }
  out.Write("\n]}\n");
  out.Commit();
}

}  // namespace sarblock::files
