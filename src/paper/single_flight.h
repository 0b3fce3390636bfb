// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/intersection.h"

#include <string>

namespace sarblock {

/// One flight line, two looks at the same point, one squinted forward, one backward: the paper's
/// example (its Fig. 5) of a configuration without valid stereo.
struct SingleFlightPair {
  double height_m = 0.0;           ///< H > 0
  double ground_range_m = 0.0;     ///< y, not 0
  double first_squint_rad = 0.0;   ///< tau', in (-pi/2, pi/2); positive looks forward
  double second_squint_rad = 0.0;  ///< tau'', another one
};

/// What the four equations of the pair determine.
///
/// Why they cannot determine the point: a range sphere about s and a cone of half angle 90 deg -
/// tau about the flight line through s meet in the circle at the distance R sin(tau) ahead of s
/// with radius R cos(tau), in the plane normal to the line. For the same point both looks give the
/// same plane and the same radius: one circle. In the Jacobian: the gradients of both spheres and
/// both cones lie in the plane of the flight line and the point, so its rank is 2.
struct SingleFlightProof {
  int rank = 0;               ///< of the 4 x 3 Jacobian, singular values above 1e-10
  double singular_1[3] = {};  ///< its singular values, largest first
  double plane_gap_m = 0.0;   ///< distance of the planes of the two circles
  double radius_gap_m = 0.0;  ///< difference of their radii
  IntersectionOutcome outcome = IntersectionOutcome::kNotConverged;  ///< of Intersect
  std::string reason;                                                ///< a sentence for people
};

/// Throws InputError naming the value unless the pair is as described above.
[[nodiscard]] SingleFlightProof ProveSingleFlight(const SingleFlightPair& pair);

}  // namespace sarblock
