// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/look_equations.h"
#include "sarblock/geometry/path.h"

#include <Eigen/Core>

namespace sarblock {

/// An antenna that was read at one time, and a point as it is seen from there.
struct LookGeometry {
  Eigen::Vector3d line_of_sight_m = Eigen::Vector3d::Zero();  ///< p - s at that time, frame axes
  Motion motion;  ///< at that time; velocity, acceleration and jerk are used, the position is not
  Cone cone;
  double squint_bias_rad = 0.0;  ///< b_tau
  /// Direction error of the cone axis, c in v + |v| c, and its rate [1/s], frame axes.
  Eigen::Vector3d axis_turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_turn_rad_per_s = Eigen::Vector3d::Zero();
};

/// What the look measures, predicted. Row 0 of a partial is that of the range, row 1 that of the
/// time. Partials by the antenna are by what moves it at the time it was read: a parameter that
/// moves it by f(t) has the partial d_position f + d_velocity f' + d_acceleration f''.
struct LookPrediction {
  double range_m = 0.0;                    ///< rho at t_p
  double delay_s = 0.0;                    ///< t_p less the time at which the antenna was read
  double cone_rate_mps = 0.0;              ///< |de_d/dt| at t_p
  double along_mps = 0.0;                  ///< metres along track at the target per second, at t_p
  Eigen::Matrix<double, 2, 3> d_point;     ///< [1], [s/m]
  Eigen::Matrix<double, 2, 3> d_position;  ///< [1], [s/m]
  Eigen::Matrix<double, 2, 3> d_velocity;  ///< [s], [s2/m]
  Eigen::Matrix<double, 2, 3> d_acceleration;  ///< [s2], [s3/m]
  Eigen::Matrix<double, 2, 3> d_axis;          ///< by c [m], [s]
  Eigen::Matrix<double, 2, 1> d_squint;        ///< by b_tau [m/rad], [s/rad]
  Eigen::Vector3d line_of_sight_m;             ///< p - s at t_p
  Eigen::Vector3d velocity_mps;                ///< of the antenna at t_p
};

/// Range and time that a look of a point measures: the explicit model of Adjust() without its
/// corrections of the range (docs/theory/observations.md, eqs. (9) to (11c)),
///
///     e_d(p, t_p) = u.d - rho sin(tau + b_tau) = 0,    R_p = rho(t_p),    d = p - s(t), rho = |d|,
///
/// the cone axis u along v + |v| c, the antenna moving on from where it was read with its velocity,
/// acceleration and jerk. t_p by Newton's method to 1e-12 of rho, as the last step leaves it; its
/// partials are those of the implicit function, dt_p = -de_d / (de_d/dt). Left out of them, by
/// acceleration: what the third derivative of f moves.
///
/// False where there is no value: rho below 1 mm, antenna at rest, |sin(tau)| not below 1, a cone
/// that never passes over the point or does so with less than a fiftieth of the speed, an argument
/// that is not finite. `out` is then left half written. Reads its arguments alone, never throws.
[[nodiscard]] bool PredictLook(const LookGeometry& at, LookPrediction* out);

}  // namespace sarblock
