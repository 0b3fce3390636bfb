// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

/// Compares odd states with even ones by divided differences of order 8, in which a flight that the
/// states resolve vanishes, scaled so that an alternation of +-1/2 comes out as +-1/2. If states
/// alternate between two solutions, the difference changes its sign from state to state; an
/// alternation counts where the mean with alternating signs has more than 80 % of the mean square,
/// is more than three times the noise of the odd and of the even states by themselves, and more
/// than 1 mm or 0.1 mm/s. Nothing where there are less than 20 states or no alternation.
[[nodiscard]] std::optional<Alternation> FindAlternation(std::span<const StateVector> states);

/// "its states alternate between two solutions ...".
[[nodiscard]] std::string Describe(const Alternation& alternation);

/// Shift by a whole day or week (+-86,400 or +-604,800 s) that brings a time onto the path, for
/// seconds that were counted from another day or week; 0 where the time is on the path, or no such
/// shift helps.
[[nodiscard]] double WrapOf_s(const FlightPath& path, double time_s);

/// Acceleration of recorded states that the attraction of their body leaves unexplained.
struct InertialMotion {
  double in_fixed_axes_mps2 = 0.0;    ///< if the axes do not turn
  double in_turning_axes_mps2 = 0.0;  ///< if they turn with the body
};

/// Whether the states of a satellite are in axes that do not turn with the body: over the first and
/// over the second half of them the change of the velocities, less the integral (trapezoids) of the
/// attraction of a point mass, is less than a tenth of the same with Coriolis and centrifugal
/// acceleration included. Nothing where they do not, or where there are fewer than three states;
/// nothing for an aircraft, whose motion follows attraction in neither system of axes.
[[nodiscard]] std::optional<InertialMotion> FindInertialMotion(std::span<const StateVector> states,
                                                               const Body& body);

/// "its states move as in axes that do not turn with the body ...".
[[nodiscard]] std::string Describe(const InertialMotion& motion);

/// Errors of velocity and position of a path made of recorded states, root mean square over a
/// strip. Noise, and what a smoothed path does not follow, are for one axis; the others are lengths
/// of vectors across the flight, since an error of the speed does not turn its direction.
struct PathErrors {
  StateNoise noise{0.0, 0.0};
  double contradiction_mps = 0.0;  ///< by velocities that are not those of the positions
  double interpolation_mps = 0.0;  ///< by what the path between the states cannot follow
  double interpolation_m = 0.0;
};

/// A flight path made of a recording.
struct RecordedPath {
  PathThrough through = PathThrough::kStates;  ///< not kAuto
  FlightPath path;
  PathErrors errors;
  StateNoise noise;                ///< of the states: as given, else estimated
  std::optional<FitOfStates> fit;  ///< kSmooth, of sigmas that were given
};

/// A recording, examined once for all ways to read it: noise of its states, and their agreement
/// within a strip.
///
/// Noise comes from differences of high order, in which a flight that the states follow vanishes
/// (eq. (20)); where these still fall with the order, no noise is visible and it is 0. The
/// contradiction is the mean over sixteenths of the strip of velocities less derivatives of the
/// polynomials through nine positions (eq. (21)), 0 where it is not significant beside the noise.
///
/// What a path cannot follow between states is its difference to a polynomial of higher degree
/// through more states. Where there are no more states, it is the error of that way on a circular
/// flight at the same times, provided that the highest divided difference of the states is that of
/// this circle, as it is for orbits. Any other flight gets the difference to the polynomial through
/// one state less (the cubic: to parabolas), an upper bound
/// (docs/theory/flight_path.md#few-states).
class Recording {
 public:
  /// States of a FlightPath, sigmas where they are known. Keeps a copy of the states.
  Recording(std::vector<StateVector> states, const StateNoise& given, const TimeSpan& strip_s);

  /// Noise of the states: as given, else estimated.
  [[nodiscard]] const StateNoise& noise() const { return noise_; }
  [[nodiscard]] double contradiction_mps() const { return contradiction_mps_; }
  [[nodiscard]] const std::vector<StateVector>& states() const { return states_; }

  /// Errors of a path through the states, of orbits or positions, without making it.
  [[nodiscard]] PathErrors ErrorsOf(PathThrough through) const;
  /// The path, read in one of the ways but kAuto, and its errors. kOrbit and kPositions make states
  /// so dense that the cubic through them turns the flight direction by at most
  /// `direction_rad` (but at most 64 an interval in the mean; eq. (24)).
  [[nodiscard]] RecordedPath Read(PathThrough through, double direction_rad) const;

 private:
  [[nodiscard]] PathErrors ErrorsOfCubic() const;
  [[nodiscard]] PathErrors ErrorsOfPolynomials(PathThrough through) const;
  [[nodiscard]] bool CubicsFollowCircle() const;
  /// Velocity across the flight that less than ten states do not resolve: their scatter about the
  /// mean velocities between them, 0 where these are far nearer to the means of two velocities.
  [[nodiscard]] double Unresolved() const;
  void AddDifferenceToParabolas(PathErrors* errors) const;
  /// Error between states of the polynomial through all states, where there are no more.
  [[nodiscard]] StateNoise Unchecked(OrbitThrough through) const;
  /// The same of another path: its difference to kOrbit and the error of that.
  template <typename Path>
  [[nodiscard]] StateNoise DifferenceToOrbit(const Path& path, double noise_of_rate) const;
  [[nodiscard]] double DenseStep_s(PathThrough through, double direction_rad) const;

  std::vector<StateVector> states_;
  StateNoise given_, noise_;
  TimeSpan strip_s_;
  std::size_t first_ = 0, last_ = 0;  ///< intervals of the strip
  double contradiction_mps_ = 0.0;
  double unresolved_mps_ = 0.0;
};

}  // namespace sarblock
