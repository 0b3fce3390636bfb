// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/look_equations.h"

#include <Eigen/Core>

namespace sarblock {

/// One look with its flight path held: everything that confines the point.
struct Sight {
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();
  double range_m = 0.0;
  Cone cone;
  int side = +1;  ///< +1 left of the flight direction, -1 right (the sign of (up x along).d)
  double range_sigma_m = 1.0;
  double azimuth_sigma = 1.0;  ///< [m] at the target or [s]
  bool azimuth_in_seconds = false;
  /// The azimuth error is one of the Doppler at an exact time, in [m]: it moves no range.
  bool exact_time = false;
};

enum class IntersectionOutcome {
  kDetermined,
  kTooFewLooks,
  kCirclesDoNotMeet,  ///< the two circles stay apart by more than the looks' noise explains
  kCirclesTouch,      ///< they meet tangentially: one direction is not determined
  kCirclesCoincide,   ///< same circle (single-flight squinted stereo, zero base)
  kWrongSide,         ///< they meet, but not on the side the antennas look to
  kAmbiguous,         ///< two solutions satisfy looks and sides equally well
  kNotConverged,
};
[[nodiscard]] const char* NameOf(IntersectionOutcome outcome);   ///< "circles-coincide", ...
[[nodiscard]] const char* Explain(IntersectionOutcome outcome);  ///< one sentence for people

struct Intersection {
  IntersectionOutcome outcome = IntersectionOutcome::kNotConverged;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< (J'J)^-1: frame axes, paths held
  double weighted_square_sum = 0.0;                         ///< v'Pv of the 2 n equations
  double intersection_rad = 0.0;  ///< largest angle between the planes of two looks' sights
  int iterations = 0;
};

struct IntersectionOptions {
  int max_iterations = 100;
  /// Below this reciprocal condition of the column-scaled whitened Jacobian the point counts as not
  /// determined (touching or coinciding circles).
  double min_reciprocal_condition = 1e-9;
};

}  // namespace sarblock
