// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace sarblock
