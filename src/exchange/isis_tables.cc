// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>

#include "export.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

// The three header rows of jigsaw's tables, with its column names and units.
constexpr const char* kResidualHeader =
    ",,,x image,y image,Measured,Measured,sample,line,Residual Vector\n"
    "Point,Image,Image,coordinate,coordinate,Sample,Line,residual,residual,Magnitude\n"
    "Label,Filename,Serial "
    "Number,(mm),(mm),(pixels),(pixels),(pixels),(pixels),(pixels),Rejected\n";
constexpr const char* kPointHeader =
    ",,,,,3-d,3-d,3-d,Sigma,Sigma,Sigma,Correction,Correction,Correction,Coordinate,Coordinate,"
    "Coordinate\n"
    "Point,Point,Accepted,Rejected,Residual,Latitude,Longitude,Radius,Latitude,Longitude,Radius,"
    "Latitude,Longitude,Radius,X,Y,Z\n"
    "Label,Status,Measures,Measures,RMS,(dd),(dd),(km),(m),(m),(m),(m),(m),(m),(km),(km),(km)\n";

std::string Cell(std::string_view text) {
  if (text.find_first_of(",\"") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

// A number, or an empty cell for NaN.
std::string Cell(double value) {
  return std::isnan(value) ? std::string() : fmt::format("{}", value);
}

// Image coordinates and residuals of a look as jigsaw has them: the middle of the first pixel is
// sample 1, line 1, and a residual is measured minus computed.
struct Measure {
  double sample = kNotGiven;
  double line = kNotGiven;
  double sample_residual = kNotGiven;
  double line_residual = kNotGiven;
  [[nodiscard]] double magnitude() const { return std::hypot(sample_residual, line_residual); }
};

Measure MeasureOf(const files::ResultLooks& looks, std::size_t i) {
  Measure measure;
  if (!looks.line_px.empty()) measure.line = looks.line_px[i] + 1.0;
  if (!looks.pixel_px.empty()) measure.sample = looks.pixel_px[i] + 1.0;
  if (!looks.line_residual_px.empty()) measure.line_residual = -looks.line_residual_px[i];
  if (!looks.pixel_residual_px.empty()) measure.sample_residual = -looks.pixel_residual_px[i];
  return measure;
}

void WriteResiduals(const std::filesystem::path& file, const ExportView& view) {
  AtomicFile out(file);
  out.Write(kResidualHeader);
  const files::ResultFile& result = view.result;
  for (std::size_t i = 0; i < result.looks.size(); ++i) {
    const Measure measure = MeasureOf(result.looks, i);
    const std::string pass = Cell(result.passes[result.looks.pass[i]].id);
    out.Write(fmt::format("{},{},{},,,{},{},{},{},{}{}\n",
                          Cell(result.points.ids[result.looks.point[i]]),
                          pass,
                          pass,
                          Cell(measure.sample),
                          Cell(measure.line),
                          Cell(measure.sample_residual),
                          Cell(measure.line_residual),
                          Cell(measure.magnitude()),
                          result.looks.rejected[i] != 0 ? ",*" : ""));
  }
  out.Commit();
}

// Looks of a point: kept, rejected, and the sum of the squared magnitudes of those kept.
struct LookCount {
  std::size_t accepted = 0;
  std::size_t rejected = 0;
  std::size_t measured = 0;
  double square_sum_px2 = 0.0;
};

std::vector<LookCount> CountLooks(const files::ResultFile& result) {
  std::vector<LookCount> counts(result.points.size());
  for (std::size_t i = 0; i < result.looks.size(); ++i) {
    LookCount& count = counts[result.looks.point[i]];
    if (result.looks.rejected[i] != 0) {
      ++count.rejected;
      continue;
    }
    ++count.accepted;
    const double magnitude = MeasureOf(result.looks, i).magnitude();
    if (std::isnan(magnitude)) continue;
    ++count.measured;
    count.square_sum_px2 += magnitude * magnitude;
  }
  return counts;
}

// Adjusted minus given position of control points, east, north, up; NaN where a component is free.
std::map<std::uint32_t, Eigen::Vector3d> ControlCorrections(const files::ResultFile& result) {
  std::map<std::uint32_t, Eigen::Vector3d> corrections;
  for (const files::ResultControl& control : result.control) {
    const auto [at, unused] =
        corrections.try_emplace(control.point, Eigen::Vector3d::Constant(kNotGiven));
    at->second[control.component] = control.residual_m;
  }
  return corrections;
}

// Planetocentric place, and the rotation of east, north, up of the ellipsoid to latitude, longitude
// and radius: by the angle between the vertical and the radius, 0 on a sphere.
class Planetocentric {
 public:
  Planetocentric(const Frame& frame, const Eigen::Vector3d& p_m)
      : lat_rad_(std::atan2(p_m.z(), std::hypot(p_m.x(), p_m.y()))),
        lon_rad_(std::atan2(p_m.y(), p_m.x())),
        tilt_rad_(frame.ellipsoid().flattening == 0.0
                      ? 0.0
                      : frame.GeodeticFromFrame(p_m).lat_rad - lat_rad_) {
    if (lon_rad_ < 0.0) lon_rad_ += 2.0 * std::numbers::pi;
  }
  [[nodiscard]] double lat_deg() const { return lat_rad_ * kDegPerRad; }
  [[nodiscard]] double lon_deg() const { return lon_rad_ * kDegPerRad; }

  [[nodiscard]] Eigen::Vector3d FromEnu(const Eigen::Vector3d& enu_m) const {
    if (tilt_rad_ == 0.0) return {enu_m.y(), enu_m.x(), enu_m.z()};
    const double cosine = std::cos(tilt_rad_), sine = std::sin(tilt_rad_);
    return {
        cosine * enu_m.y() + sine * enu_m.z(), enu_m.x(), cosine * enu_m.z() - sine * enu_m.y()};
  }
  [[nodiscard]] Eigen::Vector3d SigmasOf(const SymmetricEnu& c) const {
    const double cosine = std::cos(tilt_rad_), sine = std::sin(tilt_rad_);
    const double lat_m2 = cosine * cosine * c[1] + 2.0 * cosine * sine * c[5] + sine * sine * c[2];
    const double radius_m2 =
        sine * sine * c[1] - 2.0 * cosine * sine * c[5] + cosine * cosine * c[2];
    return {std::sqrt(lat_m2), std::sqrt(c[0]), std::sqrt(radius_m2)};
  }

 private:
  double lat_rad_, lon_rad_, tilt_rad_;
};

void WritePoints(const std::filesystem::path& file, const ExportView& view) {
  AtomicFile out(file);
  out.Write(kPointHeader);
  const files::ResultFile& result = view.result;
  const std::vector<LookCount> counts = CountLooks(result);
  const auto corrections = ControlCorrections(result);
  for (const std::uint32_t point : view.points) {
    const LookCount& count = counts[point];
    const Eigen::Vector3d& p_m = view.Position_m(point);
    const Planetocentric place(result.frame, p_m);
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNotGiven);
    const Eigen::Vector3d sigma_m =
        view.HasCovariance(point) ? place.SigmasOf(view.Covariance_m2(point)) : none;
    const auto found = corrections.find(point);
    const Eigen::Vector3d correction_m =
        found == corrections.end() ? none : place.FromEnu(found->second);
    const bool control = result.points.role[point] == PointRole::kControl;
    out.Write(fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
        Cell(result.points.ids[point]),
        control ? "CONSTRAINED" : "FREE",
        count.accepted,
        count.rejected,
        count.measured == 0
            ? std::string()
            : Cell(std::sqrt(count.square_sum_px2 / static_cast<double>(count.measured))),
        place.lat_deg(),
        place.lon_deg(),
        1e-3 * p_m.norm(),
        Cell(sigma_m[0]),
        Cell(sigma_m[1]),
        Cell(sigma_m[2]),
        Cell(correction_m[0]),
        Cell(correction_m[1]),
        Cell(correction_m[2]),
        1e-3 * p_m.x(),
        1e-3 * p_m.y(),
        1e-3 * p_m.z()));
  }
  out.Commit();
}

}  // namespace

void WriteIsisTables(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report) {
  MakeFolder(folder);
  WriteResiduals(folder / "residuals.csv", view);
  WritePoints(folder / "bundleout_points.csv", view);
  report->files = {folder / "residuals.csv", folder / "bundleout_points.csv"};
  if (view.result.looks.line_px.empty()) {
    report->warnings.push_back(
        "no pass has an image ([pass.image] of block.toml): samples, lines and their residuals are "
        "empty cells");
  }
}

}  // namespace sarblock
