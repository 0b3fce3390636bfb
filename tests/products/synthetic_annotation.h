// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock::test {

/// A Sentinel-1 annotation made from a closed form: the antenna goes round a circle in earth-fixed
/// axes and looks to the right at points on the ellipsoid's height surfaces. Seconds count from
/// 23:59:00 UTC of its day. Texts carry enough digits for 1e-6 m.
struct SyntheticAnnotation {
  bool leap_second = false;     ///< day 2016-12-31 in place of 2022-10-16
  bool ground = false;          ///< a ground range product
  bool bursts = false;          ///< two of 1100 lines
  bool size = false;            ///< numberOfLines (2001, of bursts 2200) and numberOfSamples (1001)
  bool valid_samples = false;   ///< of bursts: 12 to 988, none in their first and last five lines
  double first_line_s = 50.25;  ///< to 20 s later: over midnight
  std::string swath = "IW2";
  double velocity_error_mps = 0.0;  ///< added to the x of every velocity
  /// Pulses, Dopplers and FM rates as below, and times of the grid that have the part of the
  /// bistatic residual that is linear in range.
  bool timing = false;
  /// By row of the grid: added to the latitude, to the height.
  std::array<double, 3> latitude_error_deg{};
  std::array<double, 3> height_error_m{};

  static constexpr double kLineInterval_s = 0.01;
  static constexpr double kNearRange_m = 850123.5;
  static constexpr double kPixel_m = 5.0;         ///< slant presentation; ground: 10
  static constexpr double kReference_s = 5.7e-3;  ///< tau_mid
  static constexpr int kRank = 9;
  static constexpr double kPri_s = 6e-4;
  static constexpr double kChirpRate_hz_per_s = 1e12;
  static constexpr double kSteering_deg_per_s = 0.75;
  static constexpr double kFmRate_hz_per_s = -2136.0;
  static constexpr double kCentroid_hz = 24.0;
  /// Ground range polynomials of `ground`, 20 s apart.
  static constexpr std::array<std::array<double, 3>, 2> kGroundRange{
      {{850123.5, 0.6, 3e-7}, {850223.5, 0.61, 3e-7}}};

  [[nodiscard]] std::string Xml() const;
  /// The same orbit as an Earth Explorer file, states 10 s apart.
  [[nodiscard]] std::string OrbitXml(double from_s, double to_s) const;
  [[nodiscard]] std::string TimeText(double seconds) const;
  /// Of a line, from `first_line_s`.
  [[nodiscard]] double LineTime_s(int line) const;

  [[nodiscard]] Eigen::Vector3d Position_m(double seconds) const;
  [[nodiscard]] Eigen::Vector3d Velocity_mps(double seconds) const;
  [[nodiscard]] double SlantRange_m(double line, double pixel) const;
};

/// An element of XML on a line of its own.
[[nodiscard]] std::string Element(const std::string& name,
                                  const std::string& text,
                                  const std::string& attributes = "");

/// `text` with the first `from` replaced; a failure of the test where it does not stand there.
[[nodiscard]] std::string Replaced(std::string text,
                                   const std::string& from,
                                   const std::string& to);

/// Line of the first `wanted`, from 1.
[[nodiscard]] std::size_t LineOf(const std::string& text, const std::string& wanted);

}  // namespace sarblock::test
