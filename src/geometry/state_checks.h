// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace sarblock {

/// Two states that follow each other so closely that their difference is noise.
struct CloseStates {
  std::size_t second = 0;  ///< index of the later one
  double apart_s = 0.0;
  double usual_s = 0.0;  ///< upper quartile of all intervals; 0: there are less than four
};

/// The first pair of states that is closer in time than a thousandth of the upper
/// quartile of all intervals, or
/// so close that the rounding of coordinates is an acceleration above 1 m/s^2: 12 eps |p|/h^2, 0.1
/// ms for coordinates of 7e6 m. Such pairs come from orbits that were merged. Times must increase.
[[nodiscard]] std::optional<CloseStates> FindCloseStates(std::span<const StateVector> states);

/// What is wrong with them and what is allowed, as the rest of a sentence that names both states.
[[nodiscard]] std::string Describe(const CloseStates& close);

/// How far every second state is from the flight of the others.
struct Alternation {
  double position_m = 0.0, velocity_mps = 0.0;  ///< 0: not significant
};

/// Odd states against even ones: divided differences of order 8, scaled so that an alternation of
/// +-1/2 comes out as +-1/2, in which a flight that the states resolve vanishes. Two solutions
/// whose states alternate make it change its sign from state to state; it counts where the mean
/// with alternating signs has more than 80 % of the mean square, is more than three times the noise
/// of the odd and of the even states by themselves, and more than 1 mm or 0.1 mm/s. Nothing where
/// there are less than 20 states or no alternation.
[[nodiscard]] std::optional<Alternation> FindAlternation(std::span<const StateVector> states);

/// "its states alternate between two solutions ...".
[[nodiscard]] std::string Describe(const Alternation& alternation);

/// What brings a time to the path by a whole day or week, whose seconds begin again: +-86,400 or
/// +-604,800 s. 0 where the time is on the path, or none does.
[[nodiscard]] double WrapOf_s(const FlightPath& path, double time_s);

/// Acceleration of recorded states that the attraction of their body leaves unexplained.
struct InertialMotion {
  double in_fixed_axes_mps2 = 0.0;    ///< if the axes do not turn
  double in_turning_axes_mps2 = 0.0;  ///< if they turn with the body
};

/// Whether the states of a satellite stand in axes that do not turn with the body: over the first
/// and over the second half of them the change of the velocities, less the integral (trapezoids) of
/// the attraction of a point mass, is less than a tenth of what is left of it with Coriolis and
/// centrifugal acceleration. Nothing where they do not, or where there are fewer than three states;
/// an aircraft's motion is none of attraction in either axes.
[[nodiscard]] std::optional<InertialMotion> FindInertialMotion(std::span<const StateVector> states,
                                                               const Body& body);

/// "its states move as in axes that do not turn with the body ...".
[[nodiscard]] std::string Describe(const InertialMotion& motion);

}  // namespace sarblock
