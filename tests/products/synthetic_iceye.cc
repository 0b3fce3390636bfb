// SPDX-License-Identifier: Apache-2.0
#include "products/synthetic_iceye.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/intersection.h"

#include <fmt/core.h>

namespace sarblock::test {

Eigen::Vector3d SyntheticIceye::Ground_m(double line, double sample) const {
  const double time_s = first_line_s + line * kLineInterval_s;
  FixedPathLook look;
  look.antenna_m = orbit.Position_m(time_s);
  look.velocity_mps = orbit.Velocity_mps(time_s);
  look.acceleration_mps2 = Eigen::Vector3d::Zero();
  look.range_m = SlantRange_m(sample);
  look.side = -1;
  return IntersectWithHeight(look, Frame::Geocentric(NamedEllipsoid("WGS84")), kHeight_m)
      .position_m;
}

std::string SyntheticIceye::Xml() const {
  std::string states;
  for (double s = 0.0; s <= 120.0; s += 10.0) {
    const Eigen::Vector3d p = orbit.Position_m(s), v = orbit.Velocity_mps(s);
    std::string state = Element("time", orbit.TimeText(s));
    for (int k = 0; k < 3; ++k) {
      state += Element(std::string("pos") + "XYZ"[k], fmt::format("{:.9f}", p[k])) +
               Element(std::string("vel") + "XYZ"[k], fmt::format("{:.9f}", v[k]));
    }
    states += Element("orbit_vector", "\n" + state);
  }
  std::string ground =
      Element("zero_doppler_time", orbit.TimeText(60.0)) + Element("ground_range_origin", "0.0");
  int number = 0;
  for (const char* value : {"850123.5", "0.6", "3e-7"}) {
    ground += Element("coefficient",
                      Element("number", std::to_string(++number)) + Element("value", value));
  }
  const auto corner = [this](const char* name, int line, int sample) {
    const Geodetic at =
        Frame::Geocentric(NamedEllipsoid("WGS84")).GeodeticFromFrame(Ground_m(line, sample));
    return Element(name,
                   fmt::format("{} {} {:.12f} {:.12f}",
                               sample + 1,
                               line + 1,
                               at.lat_rad / kRadPerDeg,
                               at.lon_rad / kRadPerDeg));
  };
  const double last_s = first_line_s + (kLines - 1) * kLineInterval_s;
  return Element(
      "Metadata",
      "\n" + Element("Orbit_State_Vectors", "\n" + states) +
          Element("GRSR_Coefficients", "\n" + ground) + Element("satellite_name", "ICEYE-X7") +
          Element("product_level", "GRD") + Element("geo_ref_system", "WGS84") +
          Element("look_side", "right") + Element("carrier_frequency", "9650000000.0") +
          Element("number_of_azimuth_samples", std::to_string(kLines)) +
          Element("number_of_range_samples", std::to_string(kSamples)) +
          Element("zerodoppler_start_utc", orbit.TimeText(first_line_s)) +
          Element("zerodoppler_end_utc", orbit.TimeText(last_s)) +
          Element("azimuth_time_interval", fmt::format("{}", kLineInterval_s)) +
          Element("range_spacing", fmt::format("{}", kPixel_m)) +
          Element("orbit_processing_level", "precise") + Element("tropo_range_delay", "2.5") +
          Element("avg_scene_height", fmt::format("{}", kHeight_m)) +
          corner("coord_first_near", 0, 0) + corner("coord_first_far", 0, kSamples - 1) +
          corner("coord_last_near", kLines - 1, 0) +
          corner("coord_last_far", kLines - 1, kSamples - 1) +
          corner("coord_center", (kLines - 1) / 2, (kSamples - 1) / 2));
}

}  // namespace sarblock::test
