// SPDX-License-Identifier: Apache-2.0
#include "geojson.h"

#include "sarblock/io/atomic_file.h"

#include <array>
#include <charconv>
#include <cmath>

#include "core/units.h"
#include "covariance/error_ellipse.h"
#include "number.h"
#include <nlohmann/json.hpp>

namespace sarblock {
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

class Writer {
 public:
  Writer(const std::filesystem::path& file, const GeoJsonContent& content)
      : content_(content), out_(file) {
    if (content.confidence_1) scale_1_ = EllipseScale(*content.confidence_1);
    ellipse_text_ = content.confidence_1
                        ? NumberText(100.0 * *content.confidence_1) + " percent, true size"
                        : "1 sigma, true size";
    out_.Write("{\"type\":\"FeatureCollection\",\"generator\":\"sarblock\",\"name\":" +
               JsonText(content.name) + ",\"features\":[");
  }

  void Point(std::size_t i) {
    const PointResults& points = content_.points;
    const Eigen::Vector3d& p_m = points.position_m[i];
    if (!IsSolved(points.status[i]) || !p_m.allFinite()) return;
    const Geodetic place = content_.frame.GeodeticFromFrame(p_m);
    const std::string id = JsonText(content_.ids[i]);
    Begin();
    text_.append("{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
    text_.append(",\"role\":\"").append(NameOf(content_.role[i]));
    text_.append("\",\"status\":\"").append(NameOf(points.status[i])).append("\"");
    text_.append(",\"looks\":").append(std::to_string(points.looks[i]));
    const bool sigmas = !points.covariance_m2.empty() && std::isfinite(points.covariance_m2[i][0]);
    ErrorEllipse ellipse;
    if (sigmas) {
      const SymmetricEnu& c = points.covariance_m2[i];
      const double factor_1 = content_.covariance_factor_1;
      ellipse = EllipseOf(c, scale_1_ * std::sqrt(factor_1));
      AppendProperty("sigma_e_m", std::sqrt(factor_1 * c[0]), &text_);
      AppendProperty("sigma_n_m", std::sqrt(factor_1 * c[1]), &text_);
      AppendProperty("sigma_u_m", std::sqrt(factor_1 * c[2]), &text_);
      AppendEllipse(ellipse);
    }
    Check(i);
    text_.append("},\"geometry\":{\"type\":\"Point\",\"coordinates\":[");
    AppendPlace(place, &text_);
    text_.append(",");
    AppendNumber(place.h_m, &text_);
    text_.append("]}}");
    if (sigmas && content_.polygons) Polygon(id, p_m, ellipse);
    out_.Write(text_);
  }

  void Path(const std::string& id, const FlightPath& path) {
    Begin();
    text_.append("{\"type\":\"Feature\",\"properties\":{\"pass\":").append(JsonText(id));
    AppendProperty("start_s", path.start_s(), &text_);
    AppendProperty("end_s", path.end_s(), &text_);
    text_.append("},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[");
    const char* separator = "[";
    for (const StateVector& state : path.states()) {
      const Geodetic place = content_.frame.GeodeticFromFrame(state.position_m);
      text_.append(separator);
      AppendPlace(place, &text_);
      text_.append(",");
      AppendNumber(place.h_m, &text_);
      text_.append("]");
      separator = ",[";
    }
    text_.append("]}}");
    out_.Write(text_);
  }

  void Finish() {
    out_.Write("\n]}\n");
    out_.Commit();
  }

 private:
  void Begin() {
    text_ = first_ ? "\n" : ",\n";
    first_ = false;
  }
  void AppendEllipse(const ErrorEllipse& ellipse) {
    AppendProperty("ellipse_major_m", ellipse.major_m, &text_);
    AppendProperty("ellipse_minor_m", ellipse.minor_m, &text_);
    AppendProperty("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad, &text_);
  }
  // `checks` are sorted by point, as points come.
  void Check(std::size_t i) {
    if (content_.checks == nullptr) return;
    const std::vector<CheckResult>& checks = *content_.checks;
    while (check_ < checks.size() && checks[check_].point < i) ++check_;
    if (check_ == checks.size() || checks[check_].point != i) return;
    AppendProperty("error_e_m", checks[check_].error_enu_m.x(), &text_);
    AppendProperty("error_n_m", checks[check_].error_enu_m.y(), &text_);
    AppendProperty("error_u_m", checks[check_].error_enu_m.z(), &text_);
  }
  void Polygon(const std::string& id, const Eigen::Vector3d& p_m, const ErrorEllipse& ellipse) {
    text_.append(",\n{\"type\":\"Feature\",\"properties\":{\"point\":").append(id);
    text_.append(",\"ellipse\":\"").append(ellipse_text_).append("\"");
    AppendEllipse(ellipse);
    text_.append("},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[");
    const auto ring = EllipseRing(content_.frame, p_m, ellipse);
    for (const Geodetic& corner : ring) {
      text_.append("[");
      AppendPlace(corner, &text_);
      text_.append("],");
    }
    text_.append("[");
    AppendPlace(ring[0], &text_);
    text_.append("]]]}}");
  }

  const GeoJsonContent& content_;
  AtomicFile out_;
  double scale_1_ = 1.0;
  std::string ellipse_text_;
  std::string text_;
  bool first_ = true;
  std::size_t check_ = 0;
};

}  // namespace

void WriteGeoJson(const std::filesystem::path& file, const GeoJsonContent& content) {
  Writer writer(file, content);
  for (std::size_t i = 0; i < content.points.status.size(); ++i) writer.Point(i);
  for (const auto& [id, path] : content.paths) writer.Path(id, *path);
  writer.Finish();
}

}  // namespace sarblock
