// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sarblock {

/// Attitude of a body at a time: rotation from inertial to (its time-dependent) body axes and
/// angular velocity in inertial axes.
struct BodyAttitude {
  double time_s = 0.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
};

/// A flight in inertial axes (J2000) above a turning body, as cubes of ISIS and ISDs give it.
struct InertialOrbit {
  std::string file;                 ///< for messages
  std::vector<StateVector> states;  ///< times increasing, the cubic of two is the flight
  std::vector<BodyAttitude> body;   ///< times increasing; between two: the shortest rotation
  Eigen::Matrix3d constant = Eigen::Matrix3d::Identity();  ///< body-fixed of the attitude's axes
};

/// The flight in body-fixed axes, velocity relative to the body:
///
///     p = C R(q) r,  v = C R(q) (v_inertial - omega x r)
///
/// at the times of the states and between them, every interval cut into equal parts of at most
/// `step_s`. Throws InputError where times do not increase, a number is not finite or a quaternion
/// is not one of a rotation.
[[nodiscard]] std::vector<StateVector> BodyFixedStates(const InertialOrbit& orbit, double step_s);

}  // namespace sarblock
