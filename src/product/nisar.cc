// SPDX-License-Identifier: Apache-2.0
#include "product/nisar.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.h"
#include "orbit_path.h"
#include "tables/hdf5_file.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostLines = 10'000'000;  // and samples
constexpr std::size_t kMostStates = 10'000;
constexpr std::size_t kMostGridPoints = std::size_t{1} << 25;

/// The group of the image, with its band.
struct Root {
  std::string band;
  std::string path;  // "/science/LSAR/RSLC"
};
Root FindRoot(const Hdf5Values& file) {
  for (const char* band : {"LSAR", "SSAR"}) {
    for (const char* product : {"RSLC", "SLC"}) {
      std::string path = std::string("/science/") + band + "/" + product;
      if (file.Has(path)) return {band, std::move(path)};
    }
  }
  file.Fail("/science/LSAR/RSLC",
            "is missing: an RSLC of NISAR is needed; products in map geometry have no times and "
            "ranges");
}

/// Seconds from an epoch that the attribute "units" gives.
struct Times {
  UtcTime epoch;
  std::vector<double> seconds_s;
  [[nodiscard]] UtcTime At(std::size_t i) const { return AddSeconds(epoch, seconds_s[i]); }
};
Times ReadTimes(const Hdf5Values& file, const std::string& path, std::size_t most) {
  constexpr std::string_view kSince = "seconds since ";
  std::string units = file.TextAttribute(path, "units");
  std::optional<UtcTime> epoch;
  if (units.starts_with(kSince)) {
    std::string text = units.substr(kSince.size());
    if (text.size() > 10 && text[10] == ' ') text[10] = 'T';
    epoch = ParseUtc(text);
  }
  if (!epoch) {
    file.Fail(path + " (units)",
              Quoted(units) + " is not allowed, 'seconds since ' and a UTC time from 1972 on is");
  }
  constexpr double kMost_s = 1e9;
  Times times{*epoch, file.Numbers(path, 1, most).values};
  for (const double seconds_s : times.seconds_s) {
    if (std::abs(seconds_s) > kMost_s) {
      file.Fail(path, NumberText(seconds_s) + " s are no time of an image");
    }
  }
  return times;
}

/// First value and step of values that must be evenly spaced.
struct Axis {
  double first = 0.0, step = 0.0;
};
Axis EvenAxis(const Hdf5Values& file, const std::string& path, const std::vector<double>& values) {
  if (values.size() < 2) file.Fail(path, "has one value, two or more are needed");
  const Axis axis{values.front(),
                  (values.back() - values.front()) / static_cast<double>(values.size() - 1)};
  if (!(axis.step > 0.0)) file.Fail(path, "must increase");
  constexpr double kUneven = 0.01;  // of a step: times of seconds in a day are good to 1e-11 s
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double off = values[i] - (axis.first + static_cast<double>(i) * axis.step);
    if (std::abs(off) > kUneven * axis.step) {
      file.Fail(path + "[" + std::to_string(i) + "]",
                NumberText(values[i]) + " is not evenly spaced: " + NumberText(axis.step) +
                    " from one to the next is");
    }
  }
  return axis;
}

double Positive(const Hdf5Values& file, const std::string& path) {
  const double value = file.Number(path);
  if (const char* problem = ProblemOfPositive(value)) file.Fail(path, NumberText(value) + problem);
  return value;
}

LookSide ReadSide(const Hdf5Values& file, const std::string& path) {
  const std::string given = file.Text(path);
  std::string text = given;
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (text != "left" && text != "right") {
    file.Fail(path, Quoted(given) + " is not allowed, left or right is");
  }
  return text == "left" ? LookSide::kLeft : LookSide::kRight;
}

void RequireSize(const Hdf5Values& file,
                 const std::string& path,
                 const Hdf5Array& array,
                 const std::vector<std::size_t>& size) {
  if (array.size == size) return;
  const auto text = [](const std::vector<std::size_t>& lengths) {
    std::string list;
    for (const std::size_t length : lengths) {
      list += (list.empty() ? "" : " x ") + std::to_string(length);
    }
    return list;
  };
  file.Fail(path, "is " + text(array.size) + ", " + text(size) + " is needed");
}

void ReadOrbit(const Hdf5Values& file, const std::string& path, NisarProduct* product) {
  const Times times = ReadTimes(file, path + "/time", kMostStates);
  const std::vector<std::size_t> size{times.seconds_s.size(), 3};
  const Hdf5Array positions = file.Numbers(path + "/position", 2, 3 * kMostStates);
  const Hdf5Array velocities = file.Numbers(path + "/velocity", 2, 3 * kMostStates);
  RequireSize(file, path + "/position", positions, size);
  RequireSize(file, path + "/velocity", velocities, size);
  if (size[0] < 2) file.Fail(path + "/time", "has one state, a path needs two or more");
  for (std::size_t i = 0; i < size[0]; ++i) {
    const OrbitState state{times.At(i),
                           Eigen::Vector3d::Map(positions.values.data() + 3 * i),
                           Eigen::Vector3d::Map(velocities.values.data() + 3 * i)};
    const auto problem =
        ProblemOfState(product->orbit.empty() ? nullptr : &product->orbit.back(), state);
    if (problem) file.Fail(fmt::format("{}: state {}", path, i + 1), *problem);
    product->orbit.push_back(state);
  }
  if (file.Has(path + "/orbitType")) product->orbit_type = file.Text(path + "/orbitType");
}

void ReadSwath(const Hdf5Values& file, const std::string& swaths, NisarProduct* product) {
  const std::string frequency = swaths + "/" + product->frequency;
  const std::string lines = swaths + "/zeroDopplerTime", ranges = frequency + "/slantRange";
  if (!file.Has(frequency)) file.Fail(frequency, "is missing; --frequency takes the other one");
  const Times times = ReadTimes(file, lines, kMostLines);
  const Axis time_s = EvenAxis(file, lines, times.seconds_s);
  product->lines = times.seconds_s.size();
  product->first_line = AddSeconds(times.epoch, time_s.first);
  product->last_line = times.At(product->lines - 1);
  product->line_interval_s = time_s.step;
  const std::vector<double> ranges_m = file.Numbers(ranges, 1, kMostLines).values;
  const Axis range_m = EvenAxis(file, ranges, ranges_m);
  if (!(range_m.first > 0.0) || ranges_m.back() > kLargestNumber) {
    file.Fail(ranges, NumberText(range_m.first) + " m is no slant range");
  }
  product->samples = ranges_m.size();
  product->near_range_m = range_m.first;
  product->range_spacing_m = range_m.step;
  product->wavelength_m =
      kSpeedOfLight_mps / Positive(file, frequency + "/processedCenterFrequency");
}

void ReadGrid(const Hdf5Values& file, const std::string& path, NisarGrid* grid) {
  if (!file.Has(path)) return;
  constexpr double kGeographic = 4326.0;
  if (file.Number(path + "/epsg") != kGeographic) {
    file.Fail(path + "/epsg", "is not allowed, 4326 (longitude and latitude of WGS84) is");
  }
  const Times times = ReadTimes(file, path + "/zeroDopplerTime", kMostGridPoints);
  for (std::size_t i = 0; i < times.seconds_s.size(); ++i) grid->time.push_back(times.At(i));
  grid->height_m = file.Numbers(path + "/heightAboveEllipsoid", 1, kMostGridPoints).values;
  grid->slant_range_m = file.Numbers(path + "/slantRange", 1, kMostGridPoints).values;
  for (const double range_m : grid->slant_range_m) {
    if (!(range_m > 0.0) || range_m > kLargestNumber) {
      file.Fail(path + "/slantRange", NumberText(range_m) + " m is no slant range");
    }
  }
  constexpr double kHighest_m = 20e3;
  for (const double height_m : grid->height_m) {
    if (std::abs(height_m) > kHighest_m) {
      file.Fail(path + "/heightAboveEllipsoid",
                NumberText(height_m) + " is not between -20 and 20 km");
    }
  }
  const std::vector<std::size_t> size{
      grid->height_m.size(), grid->time.size(), grid->slant_range_m.size()};
  const auto read = [&](const char* name, double most_deg, std::vector<double>* into) {
    const std::string dataset = path + "/" + name;
    Hdf5Array array = file.Numbers(dataset, 3, kMostGridPoints);
    RequireSize(file, dataset, array, size);
    for (const double value_deg : array.values) {
      if (std::abs(value_deg) > most_deg) {
        file.Fail(
            dataset,
            fmt::format(
                "{} is not between -{} and {} degrees", NumberText(value_deg), most_deg, most_deg));
      }
    }
    *into = std::move(array.values);
  };
  read("coordinateX", 360.0, &grid->longitude_deg);
  read("coordinateY", 90.0, &grid->latitude_deg);
}

}  // namespace

NisarProduct ReadNisar(const std::string& name, NisarFrequency frequency) {
  const Hdf5Values file(name);
  const Root root = FindRoot(file);
  NisarProduct product;
  product.file = name;
  product.band = root.band;
  product.frequency = frequency == NisarFrequency::kA ? "frequencyA" : "frequencyB";
  product.side = ReadSide(file, "/science/" + root.band + "/identification/lookDirection");
  ReadSwath(file, root.path + "/swaths", &product);
  ReadOrbit(file, root.path + "/metadata/orbit", &product);
  ReadGrid(file, root.path + "/metadata/geolocationGrid", &product.grid);
  return product;
}

}  // namespace sarblock
