// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
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

/// Control (C...), check (K...) and tie points (T...) of a scene, in this order. Tie points are
/// made when they are asked for: a list of ten million would outweigh the block. `scene` must
/// outlive it.
class PointPlan {
 public:
  explicit PointPlan(const Scene& scene);
  [[nodiscard]] std::size_t size() const { return known_.size() + scene_.points.count; }
  [[nodiscard]] PlacedPoint At(std::size_t i) const;

 private:
  const Scene& scene_;
  std::vector<PlacedPoint> known_;
};

}  // namespace sarblock
