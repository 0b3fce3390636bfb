// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/look_equations.h"
#include "sarblock/leberl/formulas.h"

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Angle of incidence at the ground [rad] of a look from `height_m` above a sphere (an infinite
/// radius: a plane), sin(i) = (a + H)/a sin(look); NaN where the look passes the sphere by.
[[nodiscard]] double IncidenceAngle(double look_rad, double height_m, double body_radius_m);

/// Slant range [m] of the same look, by the law of sines in the triangle of antenna, point and
/// centre; NaN where it passes the sphere by.
[[nodiscard]] double SlantRange(double look_rad, double height_m, double body_radius_m);

/// Two zero-Doppler looks at one point from parallel flights of equal height: straight lines over a
/// plane, circular orbits in one direction about a sphere that does not turn. Antennas and point
/// lie in the plane across the tracks. Orbits about a rotating body converge by some degrees, so
/// that azimuths more accurate than the ranges would also improve the position across; this is left
/// out.
struct StereoPair {
  std::array<double, 2> look_rad{};  ///< off nadir, magnitudes, first (') and second ('')
  double height_m = 0.0;             ///< of flight, H > 0
  double body_radius_m = std::numeric_limits<double>::infinity();  ///< a; infinite: a plane
  leberl::Arrangement arrangement = leberl::Arrangement::kSameSide;
};

/// Standard deviations of a point along and across the first track and up [m].
struct PointSigmas {
  double along_m = 0.0;
  double across_m = 0.0;
  double up_m = 0.0;
};

/// The standard deviations of `observations`' intersection (geometry::Intersect), flight paths
/// fixed, along three unit vectors of the frame; nothing where the point is not determined.
[[nodiscard]] std::optional<PointSigmas> SigmasOf(std::span<const FixedPathLook> observations,
                                                  const Eigen::Vector3d& along,
                                                  const Eigen::Vector3d& across,
                                                  const Eigen::Vector3d& up);

/// Standard deviations that a pair is planned with, by look; all > 0. Errors of both images are
/// independent.
struct PairSigmas {
  std::array<double, 2> range_m{};
  std::array<double, 2> azimuth_m{};  ///< along track at the target
  /// Standard deviation of each flight path along, across and up, constant over the strip; 0: paths
  /// known exactly.
  double path_m = 0.0;
};

/// Geometry and accuracy of a pair at its point.
struct PairAccuracy {
  double intersection_rad = 0.0;  ///< between the lines of sight, in (0, pi)
  std::array<double, 2> incidence_rad{};
  std::array<double, 2> range_m{};
  PointSigmas measured;  ///< by range and azimuth, paths exact
  PointSigmas paths;     ///< by the paths alone
  PointSigmas all;       ///< both together
};

/// Accuracy by the rigorous intersection of both looks. A path error moves the range by its part
/// along the line of sight and the azimuth by its part along track, which for an orbit is shorter
/// at the target than at the antenna. Over a plane, `measured` across and up are Leberl (1979), Eq.
/// 25. Nothing where the looks pass the body by or do not determine the point.
[[nodiscard]] std::optional<PairAccuracy> AccuracyOf(const StereoPair& pair,
                                                     const PairSigmas& sigmas);

/// Steepest slopes across track [rad] that both images show: a slope that faces an antenna lies
/// over (layover) from its angle of incidence i on, one that faces away is in shadow from pi/2 - i
/// on. By the side of the first antenna.
struct SlopeLimits {
  double facing_first_rad = 0.0;
  double facing_away_rad = 0.0;  ///< from the first antenna
};
[[nodiscard]] SlopeLimits SlopesShown(const std::array<double, 2>& incidence_rad,
                                      leberl::Arrangement arrangement);

/// Second look angles [rad] of a same-side pair at which the height is as good as `sigma_up_m` (of
/// PairAccuracy::all): all up to `below`, which is less than the first one, and all from `above` as
/// far as the body is seen. Not set: none on that side.
struct SecondLooks {
  std::optional<double> below, above;
};
[[nodiscard]] SecondLooks SecondLooksFor(const StereoPair& pair,
                                         const PairSigmas& sigmas,
                                         double sigma_up_m);

/// The second look angle with the best height (PairAccuracy::all), among all that see the body,
/// where standard deviations depend on the pair; nothing where no look determines a point.
struct BestLook {
  double look_rad = 0.0;
  double sigma_up_m = 0.0;
};
[[nodiscard]] std::optional<BestLook> BestSecondLook(
    const StereoPair& pair, const std::function<PairSigmas(const StereoPair&)>& sigmas_of);

/// The configurations of Leberl (1979), Fig. 3 to 5, 8 and 9, at one point of the ground, beside
/// each other. The point is (0, y, 0) in the paper's frame; its covariance is that of the rigorous
/// intersection (geometry::Intersect) with the flight paths held fixed.
///
///   - 3, 4 same side: stations at 0 and B, both H high
///   - 3, 4 opposite side: at 0 and beyond the point, at the look angle of the second station
///   - 3, 4 cross-wise: at 0, and across the first one's track at the same distance y
///   - 3, 4 two heights: at 0, 0.6 H and 1.2 H high
///   - 3, 4 convergent: at 0 and B, squinted by 20 and -20 degrees
///   - 5 single flight: one straight line, squinted by 15 and -15 degrees
///   - 5 single orbit: the same squints from a circular orbit 700 km above the Earth, look 45
///   degrees
///   - 8, 9 Apollo radar: 116 km above the Moon, bases of 3 and 13 km, looks of 14 to 20 degrees
struct FigureOptions {
  /// B, H and y of the first five; the aircraft of Table 1 in the middle of its model.
  leberl::StereoConfiguration ground{.base_m = 8e3, .height_m = 10e3, .ground_range_m = 19e3};
  double sigma_range_m = 1.0;
  double sigma_azimuth_m = 1.0;  ///< along track at the target
};

/// A configuration and what it gives.
struct FigureRow {
  std::string figure;  ///< "3, 4"
  std::string name;
  std::optional<double> base_m;  ///< distance of the tracks across; empty for crossing ones
  double first_look_rad = 0.0;   ///< off nadir, in the plane normal to the track
  double second_look_rad = 0.0;
  double intersection_rad = 0.0;  ///< dtheta, sarblock::IntersectionAngle
  /// Standard deviations of the point along and across the first track and up; empty where the
  /// circles of both looks do not determine it.
  std::optional<PointSigmas> sigmas;
  std::optional<double> exaggeration;  ///< q of Eq. 10; empty where no parallax can be viewed
  IntersectionOutcome outcome = IntersectionOutcome::kNotConverged;
};

/// Throws InputError naming the value unless `ground` is a same-side configuration and both
/// standard deviations are finite and positive.
[[nodiscard]] std::vector<FigureRow> PaperFigures(const FigureOptions& options);

}  // namespace sarblock
