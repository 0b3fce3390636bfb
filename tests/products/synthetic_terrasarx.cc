// SPDX-License-Identifier: Apache-2.0
#include "products/synthetic_terrasarx.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"

#include <utility>

#include <fmt/core.h>

namespace sarblock::test {
namespace {

constexpr double kReference_s = 5.7e-3;

std::string Parent(const std::string& name, const std::string& children) {
  return Element(name, "\n" + children);
}
std::string Digits17(double value) { return fmt::format("{:.17E}", value); }

double AnnotatedTime_s(double range_m) { return 2.0 * range_m / kSpeedOfLight_mps; }

std::string Term(const char* name, const char* source, double constant, double slope) {
  return Element(name,
                 "\n" + Element("referencePoint", Digits17(kReference_s)) +
                     Element("coefficient", Digits17(constant), "exponent=\"0\"") +
                     Element("coefficient", Digits17(slope), "exponent=\"1\""),
                 fmt::format("source=\"{}\"", source));
}

}  // namespace

double SyntheticTerraSarX::RangeDelay_m(double range_m) {
  const double x_s = AnnotatedTime_s(range_m) - kReference_s;
  return 0.5 * kSpeedOfLight_mps * (1.5e-8 + 2e-5 * x_s + 2e-10);
}

double SyntheticTerraSarX::AzimuthShift_s(double range_m) {
  return -1.8e-4 + 0.01 * (AnnotatedTime_s(range_m) - kReference_s);
}

std::string SyntheticTerraSarX::Xml() const {
  const double far_m = kNearRange_m + (kSamples - 1) * kPixel_m;
  const double last_s = first_line_s + (kLines - 1) * kLineInterval_s;
  const auto utc = [this](double seconds) { return Element("timeUTC", orbit.TimeText(seconds)); };
  std::string states = Parent(
      "orbitHeader", Element("accuracy", "SCIE") + Element("stateVectorRefFrame", "WGS84-G1150"));
  for (double s = 0.0; s <= 120.0; s += 10.0) {
    const Eigen::Vector3d p = orbit.Position_m(s), v = orbit.Velocity_mps(s);
    std::string state = utc(s);
    for (int k = 0; k < 3; ++k)
      state += Element(std::string("pos") + "XYZ"[k], fmt::format("{:.9f}", p[k]));
    // As coarse as those of real products.
    for (int k = 0; k < 3; ++k)
      state += Element(std::string("vel") + "XYZ"[k], fmt::format("{:.3f}", v[k]));
    states += Parent("stateVec", state);
  }
  return "<?xml version=\"1.0\"?>\n" +
         Parent(
             "level1Product",
             Parent("generalHeader", Element("mission", "TSX-1")) +
                 Parent(
                     "productInfo",
                     Parent("acquisitionInfo",
                            Element("imagingMode", "SM") + Element("lookDirection", "RIGHT")) +
                         Parent("productVariantInfo",
                                Element("productVariant", "SSC") +
                                    Element("projection", "SLANTRANGE")) +
                         Parent("imageDataInfo",
                                Parent("imageRaster",
                                       Element("numberOfRows", std::to_string(kLines)) +
                                           Element("numberOfColumns", std::to_string(kSamples)) +
                                           Element("rowSpacing",
                                                   Digits17(AnnotatedTime_s(kPixel_m)),
                                                   "units=\"s\"") +
                                           Element("columnSpacing",
                                                   Digits17(kLineInterval_s),
                                                   "units=\"s\""))) +
                         Parent("sceneInfo",
                                Parent("start", utc(first_line_s)) + Parent("stop", utc(last_s)) +
                                    Parent("rangeTime",
                                           Element("firstPixel",
                                                   Digits17(AnnotatedTime_s(kNearRange_m))) +
                                               Element("lastPixel",
                                                       Digits17(AnnotatedTime_s(far_m)))))) +
                 Parent("productSpecific",
                        Parent("complexImageInfo",
                               Element("imageCoordinateType", "ZERODOPPLER") +
                                   Element("imageDataStartWith", "EARLYAZNEARRG"))) +
                 Parent("instrument",
                        Parent("radarParameters", Element("centerFrequency", Digits17(9.65e9)))) +
                 Parent("platform", Parent("orbit", states)));
}

std::string SyntheticTerraSarX::GeorefXml() const {
  const double near_s = AnnotatedTime_s(kNearRange_m);
  const double a_m = 6378137.0, b_m = 6356752.315;  // as real products round it
  std::string grid = Parent("gridReferenceTime",
                            Element("tReferenceTimeUTC", orbit.TimeText(first_line_s)) +
                                Element("tauReferenceTime", Digits17(near_s)));
  for (int row = 0; row < 3; ++row) {
    const double h_m = Height_m(row);
    const Frame grown = Frame::Geocentric({"", a_m + h_m, (a_m - b_m) / (a_m + h_m)});
    for (int column = 0; column < 3; ++column) {
      // The last row and column of the grid lie between lines and samples, whose numbers are cut.
      const double line = 1000.0 * row - (row == 2 ? 0.25 : 0.0);
      const double sample = 500.0 * column - (column == 2 ? 0.75 : 0.0);
      const double range_m = kNearRange_m + sample * kPixel_m;
      const double time_s = first_line_s + line * kLineInterval_s - AzimuthShift_s(range_m);
      FixedPathLook look;
      look.antenna_m = orbit.Position_m(time_s);
      look.velocity_mps = orbit.Velocity_mps(time_s);
      look.acceleration_mps2 = Eigen::Vector3d::Zero();
      look.range_m = range_m - RangeDelay_m(range_m);
      look.side = -1;
      const Geodetic at = grown.GeodeticFromFrame(IntersectWithHeight(look, grown, 0.0).position_m);
      grid += Element("gridPoint",
                      "\n" + Element("t", Digits17(line * kLineInterval_s)) +
                          Element("tau", Digits17(AnnotatedTime_s(sample * kPixel_m))) +
                          Element("lat", Digits17(at.lat_rad / kRadPerDeg)) +
                          Element("lon", Digits17(at.lon_rad / kRadPerDeg)) +
                          Element("row", std::to_string(1 + static_cast<int>(line))) +
                          Element("col", std::to_string(1 + static_cast<int>(sample))) +
                          Element("height", Digits17(h_m)),
                      fmt::format("iaz=\"{}\" irg=\"{}\"", row + 1, column + 1));
    }
  }
  return Parent("geoReference",
                Parent("referenceFrames",
                       Parent("sphere",
                              Element("semiMajorAxis", Digits17(a_m)) +
                                  Element("semiMinorAxis", Digits17(b_m)))) +
                    Parent("signalPropagationEffects",
                           Term("rangeDelay", "ATMOS", 1.5e-8, 2e-5) +
                               Term("rangeDelay", "IONO", 2e-10, 0.0) +
                               Term("azimuthShift", "TIMING", -1.8e-4, 0.01)) +
                    Parent("geolocationGrid", grid));
}

}  // namespace sarblock::test
