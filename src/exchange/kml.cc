// SPDX-License-Identifier: Apache-2.0
#include "kml.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <array>
#include <cmath>
#include <iterator>

#include "core/text.h"
#include "files/geojson.h"
#include "quality/covariance.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

struct RoleStyle {
  PointRole role;
  const char* folder;
  const char* colour;  // alpha, blue, green, red
  double scale;
};
constexpr std::array<RoleStyle, 3> kStyles{
    {{PointRole::kControl, "Control points", "ff2020e0", 1.0},
     {PointRole::kCheck, "Check points", "ff20b020", 0.9},
     {PointRole::kTie, "Tie points", "ffe0a020", 0.6}}};

class KmlWriter {
 public:
  KmlWriter(const std::filesystem::path& file, const ExportView& view) : view_(view), out_(file) {}

  void Head() {
    std::string hint;  // Google Earth shows the bodies it knows
    const std::string& body = view_.result.frame.ellipsoid().name;
    if (body == "Moon" || body == "Mars") hint = body == "Moon" ? "target=moon" : "target=mars";
    Add("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- written by sarblock -->\n");
    Add("<kml xmlns=\"http://www.opengis.net/kml/2.2\"{}>\n<Document>\n<name>{}</name>\n",
        hint.empty() ? "" : " hint=\"" + hint + "\"",
        XmlText(view_.result.summary.block));
    for (const RoleStyle& style : kStyles) {
      Add("<Style id=\"{0}\"><IconStyle><color>{1}</color><scale>{2}</scale></IconStyle>"
          "<LabelStyle><scale>{2}</scale></LabelStyle></Style>\n",
          NameOf(style.role),
          style.colour,
          style.scale);
    }
    Add("<Style id=\"ellipse\"><LineStyle><color>ff00a5ff</color><width>1.5</width></LineStyle>"
        "<PolyStyle><color>4000a5ff</color></PolyStyle></Style>\n"
        "<Style id=\"path\"><LineStyle><color>ffff8000</color><width>2</width></LineStyle>"
        "</Style>\n");
  }

  void Points(const RoleStyle& style) {
    Add("<Folder><name>{}</name>\n", style.folder);
    const ResultPoints& points = view_.result.points;
    for (const std::uint32_t point : view_.points) {
      if (points.role[point] != style.role) continue;
      Add("<Placemark><name>{}</name><styleUrl>#{}</styleUrl><ExtendedData>",
          XmlText(points.ids[point]),
          NameOf(style.role));
      Add("<Data name=\"role\"><value>{}</value></Data>", NameOf(style.role));
      Add("<Data name=\"status\"><value>{}</value></Data>", NameOf(points.results.status[point]));
      Add("<Data name=\"looks\"><value>{}</value></Data>", points.results.looks[point]);
      if (view_.HasCovariance(point)) {
        const SymmetricEnu& c = view_.Covariance_m2(point);
        Datum("sigma_e_m", std::sqrt(c[0]));
        Datum("sigma_n_m", std::sqrt(c[1]));
        Datum("sigma_u_m", std::sqrt(c[2]));
        const ErrorEllipse ellipse = EllipseOf(c, view_.ellipse_scale_1);
        Datum("ellipse_major_m", ellipse.major_m);
        Datum("ellipse_minor_m", ellipse.minor_m);
        Datum("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad);
      }
      if (const CheckResult* check = FindCheck(points.checks, point)) {
        Datum("error_e_m", check->error_enu_m.x());
        Datum("error_n_m", check->error_enu_m.y());
        Datum("error_u_m", check->error_enu_m.z());
      }
      Add("</ExtendedData><Point><coordinates>");
      Place(view_.result.frame.GeodeticFromFrame(view_.Position_m(point)));
      Add("</coordinates></Point></Placemark>\n");
      Flush();
    }
    Add("</Folder>\n");
  }

  std::size_t Ellipses() {
    if (!view_.options.ellipses) return 0;
    std::size_t count = 0;
    Add("<Folder><name>Error ellipses</name><description>{}</description>\n",
        view_.options.confidence_1
            ? fmt::format("{} percent, true size", 100.0 * *view_.options.confidence_1)
            : std::string("1 sigma, true size"));
    for (const std::uint32_t point : view_.points) {
      if (!view_.HasCovariance(point)) continue;
      const auto ring = EllipseRing(view_.result.frame,
                                    view_.Position_m(point),
                                    EllipseOf(view_.Covariance_m2(point), view_.ellipse_scale_1));
      Add("<Placemark><name>{}</name><styleUrl>#ellipse</styleUrl><Polygon><outerBoundaryIs>"
          "<LinearRing><coordinates>",
          XmlText(view_.result.points.ids[point]));
      for (const Geodetic& corner : ring) {
        Place({corner.lat_rad, corner.lon_rad, 0.0});
        text_ += ' ';
      }
      Place({ring[0].lat_rad, ring[0].lon_rad, 0.0});
      Add("</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>\n");
      ++count;
      Flush();
    }
    Add("</Folder>\n");
    return count;
  }

  void Paths() {
    Add("<Folder><name>Flight paths</name>\n");
    for (const ResultPass& pass : view_.result.passes) {
      Add("<Placemark><name>{}</name><styleUrl>#path</styleUrl><LineString>"
          "<altitudeMode>absolute</altitudeMode><coordinates>",
          XmlText(pass.id));
      for (const StateVector& state : pass.path.states()) {
        if (&state != &pass.path.states().front()) text_ += ' ';
        Place(view_.result.frame.GeodeticFromFrame(state.position_m));
      }
      Add("</coordinates></LineString></Placemark>\n");
      Flush();
    }
    Add("</Folder>\n");
  }

  void Finish() {
    Add("</Document>\n</kml>\n");
    Flush();
    out_.Commit();
  }

 private:
  template <typename... Values>
  void Add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }
  void Datum(const char* name, double value) {
    if (!std::isnan(value)) Add("<Data name=\"{}\"><value>{}</value></Data>", name, value);
  }
  void Place(const Geodetic& place) {
    Add("{:.12f},{:.12f},{}", place.lon_rad * kDegPerRad, place.lat_rad * kDegPerRad, place.h_m);
  }
  void Flush() {
    out_.Write(text_);
    text_.clear();
  }

  const ExportView& view_;
  AtomicFile out_;
  std::string text_;
};

}  // namespace

void WriteKml(const std::filesystem::path& file, const ExportView& view, ExportReport* report) {
  KmlWriter writer(file, view);
  writer.Head();
  for (const RoleStyle& style : kStyles) writer.Points(style);
  report->ellipses = writer.Ellipses();
  writer.Paths();
  writer.Finish();
  report->paths = view.result.passes.size();
  report->files.push_back(file);
}

}  // namespace sarblock
