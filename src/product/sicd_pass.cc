// SPDX-License-Identifier: Apache-2.0
#include "sicd_pass.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "sicd_projection.h"

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
    throw InputError(FilePlace{image.file, 0, "SICD.Timeline.CollectDuration"},
                     "with the times of the columns spans more than a day");
  }
  const double start_s = least_s - kMargin_s;
  const auto steps = static_cast<std::size_t>(std::ceil((most_s + kMargin_s - start_s) / kStep_s));
  std::vector<StateVector> states;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double time_s = start_s + static_cast<double>(k) * kStep_s;
    const SicdMotion motion = MotionOf(image, time_s);
    states.push_back({time_s + shift_s, motion.position_m, motion.velocity_mps});
  }
  try {
    return FlightPath(std::move(states));
  } catch (const InputError& error) {
    throw InputError(FilePlace{image.file, 0, "SICD.Position.ARPPoly"}, error.what());
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
      throw InputError(FilePlace{given.file, 0, "SICD.Grid.TimeCOAPoly"},
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
    throw InputError(FilePlace{given.file, 0, "SICD.Grid"},
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
  const FilePlace place{given.file, 0, "SICD.RMA.INCA.TimeCAPoly"};
  if (HasRaster(given)) {
    const ColumnTimes times = TimesOf(given);
    if (!(std::abs(times.last_s - times.first_s) > kEven_s)) {
      throw InputError(place, "gives the same time to all columns");
    }
    SetRaster(given, times, &image);
    return image;
  }
  if (given.kind == SicdKind::kInca &&
      (given.aperture_time_s.empty() || given.rate_scale_1.empty())) {
    throw InputError(place,
                     "is not linear over the columns of the image, for which TimeCOAPoly and "
                     "DRateSFPoly are needed too");
  }
  SetAperture(given, &image);
  return image;
}

}  // namespace sarblock
