// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/intersection.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <hdf5.h>

namespace sarblock::test {

/// An RSLC of NISAR without pixels, made from a closed form: the antenna goes round a circle in
/// earth-fixed axes and looks to the left at height surfaces of the ellipsoid. Seconds count from
/// 2022-10-16T23:59:00 UTC; the orbit's own times from an hour before.
struct NisarFile {
  std::string product = "RSLC";  ///< or SLC
  std::string look = "Left";
  double orbit_step_s = 10.0;
  bool grid = true;
  bool repeated_row = false;  ///< the second row of the grid has the time of the first
  bool variable_text = false;
  bool compressed = false;  ///< chunks of the grid, deflated

  static constexpr double kFirstLine_s = 50.25, kLineInterval_s = 0.01;
  static constexpr double kNearRange_m = 850123.5, kPixel_m = 5.25;
  static constexpr double kCentre_hz = 1.2575e9;
  static constexpr std::size_t kLines = 1500, kSamples = 2000;
  static constexpr std::array<double, 2> kHeights_m{-100.5, 1500.25};
  static constexpr std::array<double, 3> kRows_s{49.75, 57.5, 65.5};
  static constexpr std::array<double, 2> kColumns_m{849000.0, 860500.0};

  [[nodiscard]] static Eigen::Vector3d Position_m(double seconds) {
    const double angle = 0.5 + kRate * seconds;
    return kRadius_m * Eigen::Vector3d(std::cos(angle), 0.04, std::sin(angle));
  }
  [[nodiscard]] static Eigen::Vector3d Velocity_mps(double seconds) {
    const double angle = 0.5 + kRate * seconds;
    return kRadius_m * kRate * Eigen::Vector3d(-std::sin(angle), 0.0, std::cos(angle));
  }
  /// The place that is seen at a time and range on a height surface of WGS84.
  [[nodiscard]] static Eigen::Vector3d Ground_m(double seconds, double range_m, double height_m) {
    FixedPathLook observation;
    observation.antenna_m = Position_m(seconds);
    observation.velocity_mps = Velocity_mps(seconds);
    observation.range_m = range_m;
    observation.acceleration_mps2 = Eigen::Vector3d::Zero();
    observation.side = +1;
    return IntersectWithHeight(observation, Frame::Geocentric(NamedEllipsoid("WGS84")), height_m)
        .position_m;
  }

  void Write(const std::filesystem::path& path) const {
    file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const std::string root = "/science/LSAR/" + product;
    Text("/science/LSAR/identification/lookDirection", look);
    const std::string swaths = root + "/swaths", orbit = root + "/metadata/orbit";
    std::vector<double> lines, samples, times, positions, velocities;
    for (std::size_t i = 0; i < kLines; ++i) {
      lines.push_back(kFirstLine_s + static_cast<double>(i) * kLineInterval_s);
    }
    for (std::size_t i = 0; i < kSamples; ++i) {
      samples.push_back(kNearRange_m + static_cast<double>(i) * kPixel_m);
    }
    for (double s = 0.0; s <= 120.0; s += orbit_step_s) {
      times.push_back(s + 3600.0);
      for (const double x : Position_m(s)) positions.push_back(x);
      for (const double v : Velocity_mps(s)) velocities.push_back(v);
    }
    Times(swaths + "/zeroDopplerTime", lines, "2022-10-16 23:59:00");
    Numbers(swaths + "/frequencyA/slantRange", {samples.size()}, samples);
    Numbers(swaths + "/frequencyA/processedCenterFrequency", {}, {kCentre_hz});
    Times(orbit + "/time", times, "2022-10-16T22:59:00.000000000");
    Numbers(orbit + "/position", {times.size(), 3}, positions);
    Numbers(orbit + "/velocity", {times.size(), 3}, velocities);
    Text(orbit + "/orbitType", "Synthetic");
    if (grid) WriteGrid(root + "/metadata/geolocationGrid");
    H5Fclose(file_);
  }

 private:
  static constexpr double kRadius_m = 7121234.5;
  static constexpr double kRate = 1.0508e-3;  // [rad/s]

  void WriteGrid(const std::string& path) const {
    const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
    constexpr double kDegrees = 57.29577951308232;
    std::vector<double> x, y, rows(kRows_s.begin(), kRows_s.end());
    for (const double height_m : kHeights_m) {
      for (const double time_s : kRows_s) {
        for (const double range_m : kColumns_m) {
          const Geodetic place = frame.GeodeticFromFrame(Ground_m(time_s, range_m, height_m));
          x.push_back(place.lon_rad * kDegrees);
          y.push_back(place.lat_rad * kDegrees);
        }
      }
    }
    if (repeated_row) rows[1] = rows[0];
    const std::vector<hsize_t> size{kHeights_m.size(), kRows_s.size(), kColumns_m.size()};
    Numbers(path + "/coordinateX", size, x);
    Numbers(path + "/coordinateY", size, y);
    Times(path + "/zeroDopplerTime", rows, "2022-10-16T23:59:00");
    Numbers(path + "/slantRange", {2}, {kColumns_m[0], kColumns_m[1]});
    Numbers(path + "/heightAboveEllipsoid", {2}, {kHeights_m[0], kHeights_m[1]});
    Numbers(path + "/epsg", {}, {4326.0});
  }

  [[nodiscard]] static hid_t WithGroups() {
    const hid_t creation = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(creation, 1);
    return creation;
  }

  void Numbers(const std::string& path,
               const std::vector<hsize_t>& size,
               const std::vector<double>& values) const {
    const hid_t links = WithGroups(), creation = H5Pcreate(H5P_DATASET_CREATE);
    if (compressed && size.size() == 3) {
      H5Pset_chunk(creation, 3, size.data());
      H5Pset_deflate(creation, 4);
    }
    const hid_t space = size.empty()
                            ? H5Screate(H5S_SCALAR)
                            : H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t dataset =
        H5Dcreate2(file_, path.c_str(), H5T_IEEE_F64LE, space, links, creation, H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(dataset);
    H5Sclose(space);
    H5Pclose(creation);
    H5Pclose(links);
  }

  void Times(const std::string& path,
             const std::vector<double>& values,
             const std::string& epoch) const {
    Numbers(path, {values.size()}, values);
    const std::string text = "seconds since " + epoch;
    const hid_t dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    const hid_t type = TextType(text), space = H5Screate(H5S_SCALAR);
    const hid_t units = H5Acreate2(dataset, "units", type, space, H5P_DEFAULT, H5P_DEFAULT);
    const char* const pointer = text.c_str();
    H5Awrite(units, type, variable_text ? static_cast<const void*>(&pointer) : pointer);
    H5Aclose(units);
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(dataset);
  }

  void Text(const std::string& path, const std::string& text) const {
    const hid_t links = WithGroups(), type = TextType(text), space = H5Screate(H5S_SCALAR);
    const hid_t dataset =
        H5Dcreate2(file_, path.c_str(), type, space, links, H5P_DEFAULT, H5P_DEFAULT);
    const char* const pointer = text.c_str();
    H5Dwrite(dataset,
             type,
             H5S_ALL,
             H5S_ALL,
             H5P_DEFAULT,
             variable_text ? static_cast<const void*>(&pointer) : pointer);
    H5Dclose(dataset);
    H5Sclose(space);
    H5Tclose(type);
    H5Pclose(links);
  }

  [[nodiscard]] hid_t TextType(const std::string& text) const {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, variable_text ? H5T_VARIABLE : text.size());
    if (!variable_text) H5Tset_strpad(type, H5T_STR_NULLPAD);
    return type;
  }

  mutable hid_t file_ = -1;
};

}  // namespace sarblock::test
