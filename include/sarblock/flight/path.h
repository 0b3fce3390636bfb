// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Position of a moving antenna and its time derivatives, frame axes.
struct Motion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d jerk_mps3 = Eigen::Vector3d::Zero();
};

/// One state vector of a flight path.
struct StateVector {
  double time_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

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
  /// Asks the memory for what Evaluate(time_s) will read: points seen by many long paths jump about
  /// in them, and waiting for memory would take as long as all the arithmetic of a look.
  void Prefetch(double time_s) const;
  /// The whole path is one straight piece at constant velocity: that of its first state.
  [[nodiscard]] bool IsStraight() const;
  [[nodiscard]] double start_s() const { return states_.front().time_s; }
  [[nodiscard]] double end_s() const { return states_.back().time_s; }
  [[nodiscard]] const std::vector<StateVector>& states() const { return states_; }

 private:
  /// One cubic: everything that a time within it needs, in two lines of the cache.
  struct alignas(64) Piece {
    double start_s = 0.0, end_s = 0.0;
    Eigen::Vector3d position_m, velocity_mps;
    Eigen::Vector3d second_mps2, third_mps3;  ///< coefficients of (t - t_k)^2 and (t - t_k)^3
  };
  std::vector<StateVector> states_;
  std::vector<Piece> pieces_;
  double spacing_s_ = 0.0;  // > 0 where the times are equally spaced: index without a search
};

}  // namespace sarblock
