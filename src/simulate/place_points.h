// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/simulate/scene.h"

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// A point as planned: where it stands in the scene plane, and as what.
struct PlacedPoint {
  std::string id;
  PointRole role = PointRole::kTie;
  Eigen::Vector2d plane_m = Eigen::Vector2d::Zero();
};

/// Control (C...), check (K...) and tie points (T...) of a scene, in this order.
[[nodiscard]] std::vector<PlacedPoint> PlacePoints(const Scene& scene);

}  // namespace sarblock
