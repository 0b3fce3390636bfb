// SPDX-License-Identifier: Apache-2.0
#include "sicd_image.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "model/priors.h"
#include "sicd.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

/// Times from the start of the collection, whichever is the first.
using TimeSpan = std::array<double, 2>;
void Include(double time_s, TimeSpan* span_s) {
  (*span_s)[0] = std::min((*span_s)[0], time_s);
  (*span_s)[1] = std::max((*span_s)[1], time_s);
}

/// Times of closest approach of the first and the last column, and whether those between are evenly
/// spaced.
struct ColumnTimes {
  double first_s = 0.0, last_s = 0.0;
  bool even = true;
};
constexpr double kEven_s = 1e-9;  // 7.5 um of flight
ColumnTimes TimesOf(const SicdImage& image) {
  const auto time_s = [&image](double column) {
    return ValueOf(image.closest_time_s, image.Azimuth_m(column));
  };
  const double last = static_cast<double>(image.columns - 1);
  ColumnTimes times{time_s(0.0), time_s(last)};
  constexpr int kParts = 64;
  for (int k = 0; k <= kParts; ++k) {
    const double part = static_cast<double>(k) / kParts;
    const double even_s = times.first_s + part * (times.last_s - times.first_s);
    if (!(std::abs(time_s(part * last) - even_s) <= kEven_s)) times.even = false;
  }
  return times;
}

// States of the polynomial over the collection and the times, a second beyond both ends: the cubic
// between them is within 0.1 um of the motion of a satellite.
FlightPath PathOfPolynomial(const SicdImage& image, TimeSpan span_s, double shift_s) {
  constexpr double kMargin_s = 1.0, kStep_s = 1.0, kLongest_s = 86400.0;
  Include(0.0, &span_s);
  Include(image.duration_s, &span_s);
  const auto [least_s, most_s] = span_s;
  if (!(most_s - least_s <= kLongest_s)) {
    throw InputError(image.PlaceOf("SICD.Timeline.CollectDuration"),
                     "with the times of the columns spans more than a day");
  }
  const double start_s = least_s - kMargin_s;
  const auto steps = static_cast<std::size_t>(std::ceil((most_s + kMargin_s - start_s) / kStep_s));
  std::vector<StateVector> states;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double time_s = start_s + static_cast<double>(k) * kStep_s;
    const SicdMotion motion = AdjustedMotionOf(image, time_s);
    states.push_back({time_s + shift_s, motion.position_m, motion.velocity_mps});
  }
  try {
    return FlightPath(std::move(states));
  } catch (const InputError& error) {
    throw InputError(image.PlaceOf("SICD.Position.ARPPoly"), error.what());
  }
}

// Id, side, wavelength and epoch; the time of the collection's start from the epoch.
double SetNames(const SicdImage& given, ImagePass* image) {
  Pass& pass = image->pass;
  pass.id = std::filesystem::path(given.file).stem().string();
  pass.side = given.side;
  pass.wavelength_m = given.wavelength_m;
  return SecondsBetween(SetEpoch(image->first_line, &pass), given.start);
}

// The raster of range and zero-Doppler time.
void SetRaster(const SicdImage& given, const ColumnTimes& times, ImagePass* image) {
  const double least_s = std::min(times.first_s, times.last_s);
  const double most_s = std::max(times.first_s, times.last_s);
  image->axes =
      times.last_s > times.first_s ? RasterAxes::kRangeDown : RasterAxes::kRangeDownMirrored;
  image->lines = given.columns;
  image->samples = given.rows;
  image->first_line = AddSeconds(given.start, least_s);
  const double shift_s = SetNames(given, image);
  TimeSpan span_s{least_s, most_s};
  Include(ValueOf(given.closest_time_s, 0.0), &span_s);
  image->pass.path = PathOfPolynomial(given, span_s, shift_s);
  ImageGrid grid;
  grid.first_line_s = least_s + shift_s;
  grid.line_interval_s = (most_s - least_s) / static_cast<double>(given.columns - 1);
  grid.near_range_m = given.ClosestRange_m(0.0);
  grid.range_spacing_m = given.row_spacing_m;
  CheckImageGrid(grid);
  image->pass.image = grid;
  image->span_s = {least_s + shift_s, most_s + shift_s};
  image->middle = {0.5 * (least_s + most_s) + shift_s,
                   given.ClosestRange_m(0.5 * static_cast<double>(given.rows - 1))};
}

// Times of apertures over the image; the strip is the collection, for they may all be one.
void SetAperture(const SicdImage& given, ImagePass* image) {
  constexpr int kParts = 8;
  image->lines = given.rows;
  image->samples = given.columns;
  image->first_line = given.start;
  const double shift_s = SetNames(given, image);
  const double rows = static_cast<double>(given.rows), columns = static_cast<double>(given.columns);
  TimeSpan span_s{0.0, given.duration_s};
  const auto include = [&](double x_m, double y_m) {
    constexpr double kLongest_s = 86400.0;
    const double time_s = ValueOf(given.aperture_time_s, x_m, y_m);
    if (!(std::abs(time_s) <= kLongest_s)) {
      throw InputError(given.PlaceOf("SICD.Grid.TimeCOAPoly"),
                       "gives times more than a day from the start of the collection");
    }
    Include(time_s, &span_s);
  };
  include(0.0, 0.0);
  for (int j = 0; j <= kParts; ++j) {
    for (int k = 0; k <= kParts; ++k) {
      include(given.Row_m(rows * j / kParts - 0.5), given.Azimuth_m(columns * k / kParts - 0.5));
    }
  }
  image->pass.path = PathOfPolynomial(given, span_s, shift_s);
  image->span_s = {shift_s, given.duration_s + shift_s};
  const auto middle = LookOfPlace(given, 0.5 * (rows - 1.0), 0.5 * (columns - 1.0));
  if (!middle) {
    throw InputError(given.PlaceOf("SICD.Grid"),
                     "gives the middle of the image no range above 0 with a rate below the speed");
  }
  image->middle = {middle->time_s + shift_s, middle->range_m};
  image->aperture = {given, shift_s};
}

}  // namespace

bool HasRaster(const SicdImage& image) {
  return image.kind == SicdKind::kInca && TimesOf(image).even;
}

ImagePass PassOfSicd(const SicdImage& given) {
  ImagePass image{.file = given.file, .ellipsoid = NamedEllipsoid("WGS84")};
  const FilePlace place = given.PlaceOf("SICD.RMA.INCA.TimeCAPoly");
  if (HasRaster(given)) {
    const ColumnTimes times = TimesOf(given);
    if (!(std::abs(times.last_s - times.first_s) > kEven_s)) {
      throw InputError(place, "gives the same time to all columns");
    }
    SetRaster(given, times, &image);
    return image;
  }
  if (given.kind == SicdKind::kInca &&
      (given.aperture_time_s.empty() || given.rate_scale.empty())) {
    throw InputError(place,
                     "is not linear over the columns of the image, for which TimeCOAPoly and "
                     "DRateSFPoly are needed too");
  }
  SetAperture(given, &image);
  return image;
}

namespace {

GridPoint LookAt(const SicdImage& image,
                 const ImageCoordinates& pixel,
                 const Geodetic& place,
                 double start_s,
                 const char* what) {
  GridPoint point;
  point.place = place;
  if (HasRaster(image)) {
    point.time_s = start_s + ValueOf(image.closest_time_s, image.Azimuth_m(pixel.pixel_px));
    point.range_m = image.ClosestRange_m(pixel.line_px);
    return point;
  }
  const auto look = LookOfPlace(image, pixel.line_px, pixel.pixel_px);
  if (!look) {
    throw InputError(
        image.PlaceOf("SICD.Grid"),
        std::string("gives ") + what + " no range above 0 with a rate below the speed");
  }
  point.time_s = start_s + look->time_s;
  point.range_m = look->range_m;
  point.cone = {Cone::Kind::kDoppler, 0.0, -look->range_rate_mps};
  return point;
}

}  // namespace

SicdPoint CentreOfSicd(const SicdImage& image, double start_s) {
  const Frame earth = Frame::Geocentric(NamedEllipsoid("WGS84"));
  return {"SCP",
          LookAt(image,
                 {image.centre_row_px - image.first_row_px,
                  image.centre_column_px - image.first_column_px},
                 earth.GeodeticFromFrame(image.centre_m),
                 start_s,
                 "the scene centre")};
}

std::vector<SicdPoint> CornersOfSicd(const SicdImage& image, double start_s) {
  if (!image.corners) {
    throw InputError(image.PlaceOf("SICD.GeoData.ImageCorners"),
                     "does not place the four corners (ICP, 1:FRFC to 4:LRFC)");
  }
  const double last_row = static_cast<double>(image.rows - 1);
  const double last_column = static_cast<double>(image.columns - 1);
  const std::array<const char*, 4> names{"FRFC", "FRLC", "LRLC", "LRFC"};
  const std::array<ImageCoordinates, 4> pixels{
      {{0.0, 0.0}, {0.0, last_column}, {last_row, last_column}, {last_row, 0.0}}};
  std::vector<SicdPoint> points;
  for (std::size_t k = 0; k < names.size(); ++k) {
    points.push_back(
        {names[k], LookAt(image, pixels[k], (*image.corners)[k], start_s, "a corner")});
  }
  return points;
}

namespace {

// Seconds from the start of the collection.
double CentreTime_s(const SicdImage& sicd) {
  return sicd.aperture_time_s.empty() ? ValueOf(sicd.closest_time_s, 0.0)
                                      : ValueOf(sicd.aperture_time_s, 0.0, 0.0);
}

// Unit vectors of the axes of PosVelErr as columns, earth-fixed.
Eigen::Matrix3d AxesAt(const SicdImage& sicd, SicdErrorStatistics::Axes axes) {
  using Axes = SicdErrorStatistics::Axes;
  if (axes == Axes::kEcf) return Eigen::Matrix3d::Identity();
  const SicdMotion motion = MotionOf(sicd, CentreTime_s(sicd));
  const double rotation_rad_per_s = axes == Axes::kRicEci ? FindBody("WGS84")->rotation : 0.0;
  return RicAxes(motion.position_m, motion.velocity_mps, rotation_rad_per_s);
}

void AddPath(const SicdImage& sicd,
             const ImagePass& image,
             const SicdErrorStatistics::PositionAndVelocity& path,
             SicdPriors* out) {
  const double shift_s = SecondsBetween(WholeSecond(image.first_line), sicd.start);
  const auto [start_s, end_s] = *image.span_s;
  const double half_s = 0.5 * (end_s - start_s);
  const double since_centre_s = 0.5 * (start_s + end_s) - (CentreTime_s(sicd) + shift_s);
  const bool drift = path.sigma[3] > 0.0 || path.sigma[4] > 0.0 || path.sigma[5] > 0.0;
  const Eigen::Matrix3d axes = AxesAt(sicd, path.axes);
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(drift ? 6 : 3, 6);
  t.topLeftCorner<3, 3>() = axes;
  if (drift) {
    t.topRightCorner<3, 3>() = since_centre_s * axes;
    t.bottomRightCorner<3, 3>() = half_s * axes;
  }
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> sigma(path.sigma.data());
  const Eigen::MatrixXd given = sigma.asDiagonal() * path.correlation * sigma.asDiagonal();
  JointPrior prior;
  prior.name = image.pass.id;
  prior.passes = {image.pass.id};
  for (int degree = 0; degree <= (drift ? 1 : 0); ++degree) {
    for (const char* axis : {"x", "y", "z"}) {
      prior.parameters.push_back(fmt::format("position.{}.{}", axis, degree));
    }
  }
  const Eigen::MatrixXd turned = t * given * t.transpose();
  const Eigen::MatrixXd covariance = 0.5 * (turned + turned.transpose());
  prior.covariance = covariance;
  if (const auto problem = FindCovarianceProblem(prior.parameters, covariance)) {
    out->warnings.push_back(
        fmt::format("{}: SICD.ErrorStatistics.Components.PosVelErr is no prior of the path, which "
                    "counts as exact: {}",
                    sicd.file,
                    *problem));
    return;
  }
  PositionCorrection position;
  position.degree = drift ? 1 : 0;
  position.axes = PositionCorrection::Axes::kFrame;
  out->corrections.push_back({"position", position, {image.pass.id}, false});
  out->priors.push_back(std::move(prior));
  out->says += fmt::format(
      "path {:.3g}, {:.3g}, {:.3g} m{}",
      path.sigma[0],
      path.sigma[1],
      path.sigma[2],
      drift ? fmt::format(
                  " and {:.3g}, {:.3g}, {:.3g} m/s", path.sigma[3], path.sigma[4], path.sigma[5])
            : std::string());
}

void AppendPhrase(const std::string& text, std::string* says) {
  *says += (says->empty() ? "" : ", ") + text;
}

}  // namespace

SicdPriors PriorsOfSicd(const SicdImage& sicd, const ImagePass& image) {
  SicdPriors out;
  if (!sicd.errors) {
    out.says = "no ErrorStatistics: its path and its ranges count as exact but for noise";
    return out;
  }
  if (sicd.offsets) {
    out.says =
        "no priors: its ErrorStatistics are those of the path before its "
        "AdjustableParameterOffsets, which are applied; path and ranges count as exact but for "
        "noise";
    return out;
  }
  const SicdErrorStatistics& errors = *sicd.errors;
  if (errors.path) AddPath(sicd, image, *errors.path, &out);
  const std::vector<std::string> passes{image.pass.id};
  if (errors.range_bias_m.value_or(0.0) > 0.0) {
    RangeCorrection range;
    range.bias = true;
    range.bias_prior_sigma_m = *errors.range_bias_m;
    out.corrections.push_back({"range", range, passes, false});
    AppendPhrase(fmt::format("range bias {:.3g} m", *errors.range_bias_m), &out.says);
  }
  if (errors.zenith_delay_m.value_or(0.0) > 0.0) {
    TroposphereCorrection air;
    air.zenith_prior_sigma_m = *errors.zenith_delay_m;
    out.corrections.push_back({"troposphere", air, passes, false});
    AppendPhrase(fmt::format("zenith delay {:.3g} m", *errors.zenith_delay_m), &out.says);
  }
  out.says = out.says.empty()
                 ? "ErrorStatistics gives no prior: its path and its ranges count as exact but for "
                   "noise"
                 : "priors of ErrorStatistics: " + out.says;
  if (!errors.not_used.empty()) {
    std::string names;
    for (const std::string& name : errors.not_used) names += (names.empty() ? "" : ", ") + name;
    out.says += "; not used: " + names;
  }
  return out;
}

}  // namespace sarblock
