// SPDX-License-Identifier: Apache-2.0
#include "products/synthetic_annotation.h"

#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace sarblock::test {
namespace {

constexpr double kRadius_m = 7071234.5;
constexpr double kRate = 1.0618e-3;  // [rad/s]
constexpr double kLight_mps = 299792458.0;
constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string Number(double value) { return fmt::format("{:.15e}", value); }

std::string Vector(const std::string& name, const Eigen::Vector3d& v) {
  std::string text;
  for (int k = 0; k < 3; ++k)
    text += Element(std::string(1, "xyz"[k]), fmt::format("{:.9f}", v[k]));
  return Element(name, "\n" + text);
}

}  // namespace

std::string Element(const std::string& name,
                    const std::string& text,
                    const std::string& attributes) {
  return "<" + name + (attributes.empty() ? "" : " ") + attributes + ">" + text + "</" + name +
         ">\n";
}

Eigen::Vector3d SyntheticAnnotation::Position_m(double seconds) const {
  const double angle = 0.5 + kRate * seconds;
  return kRadius_m * Eigen::Vector3d(std::cos(angle), 0.04, std::sin(angle));
}

Eigen::Vector3d SyntheticAnnotation::Velocity_mps(double seconds) const {
  const double angle = 0.5 + kRate * seconds;
  return kRadius_m * kRate * Eigen::Vector3d(-std::sin(angle), 0.0, std::cos(angle));
}

double SyntheticAnnotation::SlantRange_m(double line, double pixel) const {
  if (!ground) return kNearRange_m + pixel * kPixel_m;
  const double part = std::clamp(line * kLineInterval_s / 20.0, 0.0, 1.0);
  const double g = 10.0 * pixel;
  const auto range = [g](const std::array<double, 3>& c) { return c[0] + g * (c[1] + g * c[2]); };
  return (1.0 - part) * range(kGroundRange[0]) + part * range(kGroundRange[1]);
}

std::string SyntheticAnnotation::TimeText(double seconds) const {
  const double end_s = leap_second ? 61.0 : 60.0;  // of the last minute of the day
  const char* day = leap_second ? "2016-12-31" : "2022-10-16";
  const char* next = leap_second ? "2017-01-01" : "2022-10-17";
  if (seconds < 0.0) return fmt::format("{}T23:58:{:09.6f}", day, seconds + 60.0);
  if (seconds < end_s) return fmt::format("{}T23:59:{:09.6f}", day, seconds);
  const double late_s = seconds - end_s;
  const int minute = static_cast<int>(late_s / 60.0);
  return fmt::format("{}T00:{:02d}:{:09.6f}", next, minute, late_s - 60.0 * minute);
}

double SyntheticAnnotation::LineTime_s(int line) const {
  const bool second = bursts && line >= 1100;
  return (second ? 9.0 : 0.0) + (second ? line - 1100 : line) * kLineInterval_s;
}

std::string SyntheticAnnotation::Xml() const {
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<product>\n";
  text += Element(
      "adsHeader",
      "\n" + Element("missionId", "S1A") + Element("polarisation", "VV") + Element("swath", swath));
  std::string orbit;
  for (double s = 0.0; s <= 120.0; s += 10.0) {
    const Eigen::Vector3d error_mps(velocity_error_mps, 0.0, 0.0);
    orbit += Element("orbit",
                     "\n" + Element("time", TimeText(s)) + Element("frame", "Earth Fixed") +
                         Vector("position", Position_m(s)) +
                         Vector("velocity", Velocity_mps(s) + error_mps));
  }
  const std::string polynomial_time =
      Element("azimuthTime", TimeText(first_line_s)) + Element("t0", "5.6e-3");
  const std::string pulses =
      Element("downlinkInformationList",
              "\n" + Element("downlinkInformation",
                             "\n" + Element("swath", swath) +
                                 Element("azimuthTime", TimeText(first_line_s)) +
                                 Element("downlinkValues",
                                         "\n" + Element("pri", Number(kPri_s)) +
                                             Element("rank", std::to_string(kRank)) +
                                             Element("txPulseRampRate",
                                                     Number(kChirpRate_hz_per_s))))) +
      Element("azimuthFmRateList",
              "\n" + Element("azimuthFmRate",
                             "\n" + polynomial_time +
                                 Element("azimuthFmRatePolynomial", Number(kFmRate_hz_per_s))));
  text += Element("generalAnnotation",
                  "\n" +
                      Element("productInformation",
                              "\n" +
                                  (timing ? Element("azimuthSteeringRate",
                                                    Number(bursts ? kSteering_deg_per_s : 0.0))
                                          : "") +
                                  Element("projection", ground ? "Ground Range" : "Slant Range") +
                                  Element("rangeSamplingRate", Number(kLight_mps / 2 / kPixel_m)) +
                                  Element("radarFrequency", Number(5.405e9))) +
                      (timing ? pulses : "") + Element("orbitList", "\n" + orbit));
  text +=
      Element("imageAnnotation",
              "\n" +
                  Element("imageInformation",
                          "\n" + Element("productFirstLineUtcTime", TimeText(first_line_s)) +
                              Element("productLastLineUtcTime", TimeText(first_line_s + 20.0)) +
                              Element("slantRangeTime", Number(2.0 * kNearRange_m / kLight_mps)) +
                              (size ? Element("numberOfLines", bursts ? "2200" : "2001") +
                                          Element("numberOfSamples", "1001")
                                    : "") +
                              Element("rangePixelSpacing", Number(10.0)) +
                              Element("azimuthTimeInterval", Number(kLineInterval_s))) +
                  Element("processingInformation", "\n" + Element("orbitSource", "Synthetic")));
  if (timing) {
    text += Element(
        "dopplerCentroid",
        "\n" + Element("dcEstimateList",
                       "\n" + Element("dcEstimate",
                                      "\n" + polynomial_time +
                                          Element("dataDcPolynomial", Number(kCentroid_hz)))));
  }
  if (bursts) {
    std::string list;
    for (const double start_s : {0.0, 9.0}) {
      std::string valid[2];
      for (int line = 0; line < 1100; ++line) {
        const bool none = line < 5 || line >= 1095;
        valid[0] += none ? "-1 " : "12 ";
        valid[1] += none ? "-1 " : "988 ";
      }
      list += Element("burst",
                      "\n" + Element("azimuthTime", TimeText(first_line_s + start_s)) +
                          (valid_samples ? Element("firstValidSample", valid[0]) +
                                               Element("lastValidSample", valid[1])
                                         : ""));
    }
    text += Element("swathTiming",
                    "\n" + Element("linesPerBurst", "1100") + Element("burstList", "\n" + list));
  }
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  std::string grid;
  for (int row = 0; row < 3; ++row) {
    for (int pixel = 0; pixel <= 1000; pixel += 500) {
      const double two_way_s = 2.0 * SlantRange_m(1000.0 * row, pixel) / kLight_mps;
      const double late_s = timing ? 0.5 * (two_way_s - kReference_s) : 0.0;
      const double time_s = first_line_s + LineTime_s(1000 * row) + std::round(1e6 * late_s) / 1e6;
      FixedPathLook observation;
      observation.antenna_m = Position_m(time_s);
      observation.velocity_mps = Velocity_mps(time_s);
      observation.acceleration_mps2 = Eigen::Vector3d::Zero();
      observation.range_m = SlantRange_m(1000.0 * row, pixel);
      observation.side = -1;
      const Intersection place = IntersectWithHeight(observation, frame, 100.0 + 217.0 * row);
      const Geodetic at = frame.GeodeticFromFrame(place.position_m);
      const auto k = static_cast<std::size_t>(row);
      grid +=
          Element("geolocationGridPoint",
                  "\n" + Element("azimuthTime", TimeText(time_s)) +
                      Element("slantRangeTime", Number(2.0 * observation.range_m / kLight_mps)) +
                      Element("line", std::to_string(1000 * row)) +
                      Element("pixel", std::to_string(pixel)) +
                      Element("latitude", Number(at.lat_rad * kDegrees + latitude_error_deg[k])) +
                      Element("longitude", Number(at.lon_rad * kDegrees)) +
                      Element("height", Number(at.h_m + height_error_m[k])));
    }
  }
  text += Element("geolocationGrid", "\n" + Element("geolocationGridPointList", "\n" + grid));
  std::string conversions;
  for (std::size_t k = 0; ground && k < kGroundRange.size(); ++k) {
    const auto& c = kGroundRange[k];
    conversions += Element(
        "coordinateConversion",
        "\n" + Element("azimuthTime", TimeText(first_line_s + 20.0 * static_cast<double>(k))) +
            Element("gr0", "0.0") +
            Element("grsrCoefficients", Number(c[0]) + " " + Number(c[1]) + " " + Number(c[2])));
  }
  text += Element("coordinateConversion",
                  "\n" + Element("coordinateConversionList", "\n" + conversions));
  return text + "</product>\n";
}

std::string SyntheticAnnotation::OrbitXml(double from_s, double to_s) const {
  std::string list;
  for (double s = from_s; s <= to_s; s += 10.0) {
    const Eigen::Vector3d p = Position_m(s), v = Velocity_mps(s);
    std::string state =
        Element("TAI", "TAI=" + TimeText(s + 37.0)) + Element("UTC", "UTC=" + TimeText(s));
    for (int k = 0; k < 3; ++k)
      state += Element(std::string(1, "XYZ"[k]), fmt::format("{:+.9f}", p[k]));
    for (int k = 0; k < 3; ++k) {
      state += Element(std::string("V") + "XYZ"[k], fmt::format("{:+.9f}", v[k]));
    }
    list += Element("OSV", "\n" + state);
  }
  return "<?xml version=\"1.0\" ?>\n<Earth_Explorer_File>\n" +
         Element("Earth_Explorer_Header",
                 "\n" + Element("Fixed_Header", "\n" + Element("Mission", "Sentinel-1A")) +
                     Element("Variable_Header", "\n" + Element("Ref_Frame", "EARTH_FIXED"))) +
         Element("Data_Block", "\n" + Element("List_of_OSVs", "\n" + list)) +
         "</Earth_Explorer_File>\n";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from << " does not stand there";
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::size_t LineOf(const std::string& text, const std::string& wanted) {
  const std::size_t at = text.find(wanted);
  EXPECT_NE(at, std::string::npos) << wanted << " does not stand there";
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(at, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

}  // namespace sarblock::test
