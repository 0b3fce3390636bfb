// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Position of a moving antenna and its time derivatives, frame axes.
struct Motion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d jerk_mps3 = Eigen::Vector3d::Zero();

  /// The motion a time later, the jerk constant.
  [[nodiscard]] Motion After(double time_s) const {
    return {position_m + time_s * (velocity_mps + (0.5 * time_s) * (acceleration_mps2 +
                                                                    (time_s / 3.0) * jerk_mps3)),
            velocity_mps + time_s * (acceleration_mps2 + (0.5 * time_s) * jerk_mps3),
            acceleration_mps2 + time_s * jerk_mps3,
            jerk_mps3};
  }
};

/// One state vector of a flight path.
struct StateVector {
  double time_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

/// Where the acceleration of a flight path is taken from.
///     kOfCubic       second derivative of the interpolating cubic, which jumps at the states
///     kOfVelocities  slope of the parabola through the velocities of a state and its neighbours,
///                    linear between states
/// Both are O(h^2) from that of a smooth flight. An error dp of a position makes the cubic's jump
/// by 12 dp / h^2 and leaves the other alone (docs/theory/flight_path.md, eq. (3a)).
enum class Acceleration { kOfCubic, kOfVelocities };

/// Nominal flight path: cubic Hermite interpolation through position and velocity.
///
/// On [t_k, t_k+1] the cubic that takes both given positions and both given velocities; position
/// and velocity are continuous, acceleration jumps at the states (model.md, section 3;
/// docs/theory/flight_path.md). Interpolation error of a smooth path with states h apart:
/// h^4/384 max|s''''| in position. States that a straight flight passes through, but for rounding,
/// are one piece, its velocity that of its first state.
/// Domain: [start_s, end_s], both included; outside At() returns nothing, never an extrapolation.
class FlightPath {
 public:
  FlightPath() = default;
  /// Throws InputError unless there are two states or more, all finite, times strictly
  /// increasing and no velocity zero.
  explicit FlightPath(std::vector<StateVector> states);

  /// Position, velocity, acceleration and jerk; at a state those of the piece that begins there
  /// (at the last state, of the last piece). Rounding: 2e-9 m for coordinates of 7e6 m.
  [[nodiscard]] std::optional<Motion> At(double time_s) const;
  /// The same without a copy, for inner loops; false outside.
  [[nodiscard]] bool Evaluate(double time_s, Motion* out) const;
  /// The motion that a look is read with: position and velocity of At(), acceleration and jerk as
  /// asked for. Beyond the ends the first or last piece is continued by up to the length of the
  /// path. False farther off. `piece`, where given, becomes the index of the piece.
  [[nodiscard]] bool Read(double time_s,
                          Acceleration acceleration,
                          Motion* out,
                          std::size_t* piece = nullptr) const;
  /// Largest difference of the two accelerations in a piece, at one of its ends.
  [[nodiscard]] double AccelerationMisfit_mps2(std::size_t piece) const;
  /// The piece that contains a time, beyond the ends the first or last one. Requires states.
  [[nodiscard]] std::size_t PieceOf(double time_s) const;
  /// Pieces of the path: state to state, or several states that a straight flight passes through.
  [[nodiscard]] std::size_t piece_count() const { return pieces_.size(); }
  [[nodiscard]] double PieceStart_s(std::size_t piece) const { return pieces_[piece].start_s; }
  [[nodiscard]] const Eigen::Vector3d& PieceVelocity_mps(std::size_t piece) const {
    return pieces_[piece].velocity_mps;  // at its start
  }
  [[nodiscard]] double PieceEnd_s(std::size_t piece) const { return pieces_[piece].end_s; }
  /// Asks the memory for what Read(time_s) will read: points seen by many long paths jump about
  /// in them, and waiting for memory would take as long as all the arithmetic of a look.
  void Prefetch(double time_s) const;
  /// The whole path is one straight piece at constant velocity: that of its first state.
  [[nodiscard]] bool IsStraight() const;
  [[nodiscard]] double start_s() const { return start_s_; }
  [[nodiscard]] double end_s() const { return end_s_; }
  [[nodiscard]] const std::vector<StateVector>& states() const { return states_; }

 private:
  /// One cubic: everything that a time within it needs, in two neighbouring lines of the cache.
  struct alignas(128) Piece {
    double start_s = 0.0, end_s = 0.0;
    Eigen::Vector3d position_m, velocity_mps;
    Eigen::Vector3d second_mps2, third_mps3;  ///< coefficients of (t - t_k)^2 and (t - t_k)^3
  };
  /// Acceleration::kOfVelocities of one piece: at its start, and its rate.
  struct MeanMotion {
    Eigen::Vector3d acceleration_mps2, jerk_mps3;
  };
  void FillAccelerations();
  std::vector<StateVector> states_;
  std::vector<Piece> pieces_;
  std::vector<MeanMotion> mean_motions_;  // by piece
  double start_s_ = 1.0, end_s_ = 0.0;    // of a path without states nothing lies between
  double spacing_s_ = 0.0;  // > 0 where the times are equally spaced: index without a search
};

/// What an orbit is interpolated through between its state vectors.
enum class OrbitThrough {
  kStates,     ///< positions and velocities: Hermite polynomial of degree 7 through four states
  kPositions,  ///< positions alone: Lagrange polynomial of degree 7 through eight; velocities are
               ///< its derivative. For states whose velocities contradict their positions.
};

/// What a flight path goes through between the states of a recording
/// (docs/theory/flight_path.md#recorded-flights).
enum class PathThrough : std::uint8_t {
  kStates,     ///< the cubic of two states: positions and velocities
  kOrbit,      ///< polynomials of degree 7 through four states: positions and velocities
  kPositions,  ///< polynomials of degree 7 through the positions of eight states
  kSmooth,     ///< a spline with continuous acceleration, fitted by least squares
  kAuto,       ///< the first of these that the data bear
};
[[nodiscard]] const char* NameOf(PathThrough through);  ///< "states", "orbit", ...

/// White noise of states, one axis. NaN: not known.
struct StateNoise {
  double position_m = std::numeric_limits<double>::quiet_NaN();
  double velocity_mps = std::numeric_limits<double>::quiet_NaN();
};

/// How a recording is to be read.
struct TrajectoryOptions {
  PathThrough through = PathThrough::kStates;
  StateNoise sigma;  ///< standard deviations of the states; NaN: estimated from them
};

struct TimeSpan {
  double first_s = 0.0, last_s = 0.0;
};

/// How well the states of a smoothed path fit their standard deviations: sum of squares over their
/// variances by degrees of freedom, 1 where they are as stated.
struct FitOfStates {
  double position_ratio = 1.0, position_freedom = 0.0;
  double velocity_ratio = 1.0, velocity_freedom = 0.0;
};

/// Newton's form of an interpolation polynomial: nodes with repetitions and divided differences,
/// docs/theory/flight_path.md, eq. (14)-(15). kStates takes positions and velocities, kPositions
/// positions alone.
class NewtonPolynomial {
 public:
  NewtonPolynomial(std::span<const StateVector> states, OrbitThrough through);
  /// Position and its derivative.
  [[nodiscard]] StateVector At(double time_s) const;
  /// The divided difference of highest order: for p nodes that of order p - 1.
  [[nodiscard]] const Eigen::Vector3d& HighestDifference() const { return coefficients_.back(); }

 private:
  Eigen::Vector3d origin_m_;  // keeps the differences small
  std::vector<double> node_s_;
  std::vector<Eigen::Vector3d> coefficients_;
};

/// `count` states around the interval that begins at state k, all if there are fewer.
[[nodiscard]] std::span<const StateVector> StatesAround(std::span<const StateVector> states,
                                                        std::size_t k,
                                                        std::size_t count);

/// States of the polynomial of degree 7.
[[nodiscard]] constexpr std::size_t StatesOf(OrbitThrough through) {
  return through == OrbitThrough::kStates ? 4 : 8;
}

/// Every way that a file may ask for (NameOf()).
inline constexpr std::array kPathsThrough{PathThrough::kStates,
                                          PathThrough::kOrbit,
                                          PathThrough::kPositions,
                                          PathThrough::kSmooth,
                                          PathThrough::kAuto};

/// More states of the same orbit, so that the cubic of FlightPath follows it: every interval is cut
/// into equal parts of at most `step_s`. With states of a low Earth orbit 10 s apart that cubic is
/// 0.2 mm off in position and 7e-5 m/s in velocity (9 mm in the Doppler equation); with parts of 1
/// s it is off by less than the digits the states are given with. The polynomial uses the states
/// around the interval, fewer where the orbit has fewer (docs/theory/flight_path.md, eq.
/// (14)-(15)). The given states stay as they are (kPositions: their positions). Throws InputError
/// unless there are two states or more with increasing times and step_s > 0.
[[nodiscard]] std::vector<StateVector> ResampleOrbit(const std::vector<StateVector>& states,
                                                     double step_s,
                                                     OrbitThrough through);

}  // namespace sarblock
