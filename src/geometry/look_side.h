// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geodesy/frame.h"
#include "sarblock/geometry/sight.h"

#include <Eigen/Core>

namespace sarblock {

/// True where p lies on the side the antenna looks to and below it: a mirror solution does not.
[[nodiscard]] bool LiesWhereItLooks(const Frame& frame,
                                    const Sight& sight,
                                    const Eigen::Vector3d& p_m);

}  // namespace sarblock
