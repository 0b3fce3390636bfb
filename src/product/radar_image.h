// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// Standard deviations that ISIS jigsaw gives the measures of a Mini-RF image, from the resolutions
/// in its label and 1.4 pixels.
struct JigsawSigma {
  double range_m = 0.0;
  double doppler_hz = 0.0;  ///< of the Doppler shift, its second measurement
};

/// A radar image in ground range as a cube of ISIS or an ISD describes it: zero-Doppler, times in
/// ephemeris time (TDB, seconds past J2000), flight path in body-fixed axes.
struct RadarImage {
  std::string file;
  std::string serial;  ///< serial number of ISIS; empty where the file has none (ISD)
  std::string target;  ///< name of the body as given; empty where the file has none (ISD)
  Ellipsoid ellipsoid;
  LookSide side = LookSide::kRight;
  double wavelength_m = 0.0;
  std::uint64_t lines = 0, samples = 0;
  double first_line_s = 0.0;  ///< ephemeris time of the centre of the first line
  double line_interval_s = 0.0;
  double first_sample_m = 0.0;    ///< ground range of the centre of the first sample
  double sample_spacing_m = 0.0;  ///< in ground range
  std::vector<GroundRangePolynomial> ground_range;  ///< with ephemeris times
  std::vector<StateVector> states;                  ///< with ephemeris times
  std::optional<JigsawSigma> jigsaw;
};

/// The spacing of the states of paths, unless they are given closer: the cubic through states 5 s
/// apart leaves a lunar orbit by less than 0.1 mm.
inline constexpr double kImageStateStep_s = 5.0;

}  // namespace sarblock
