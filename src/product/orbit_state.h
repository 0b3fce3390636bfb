// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "product/utc_time.h"
#include <Eigen/Core>

namespace sarblock {

/// One state vector as a product or an orbit file gives it: earth-fixed axes, velocities relative
/// to the turning Earth.
struct OrbitState {
  UtcTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

}  // namespace sarblock
