// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/path.h"
#include "sarblock/simulate/scene.h"

#include <functional>
#include <optional>

#include <Eigen/Core>

namespace sarblock {

/// The ground over the scene plane, with what bounds a search on it.
struct Ground {
  std::function<double(const Eigen::Vector2d&)> height_m;  ///< by place in the scene plane
  double lowest_m = 0.0, highest_m = 0.0;
  double steepest = 0.0;  ///< the tangent of no slope is above it, on the body
  double detail_m = 0.0;  ///< > 0; about the least distance from a crest to the next trough
};

/// What the ground hides from an antenna. On the cone of a look, in polar coordinates (theta, R)
/// about the antenna, the ground is a curve and a point of it is
///
///     in shadow    where a point of the same theta and smaller R lies below the ground;
///     in layover   where the ground meets the circle of the same R at another theta as well,
///                  from the nadir to the zenith on the look side: an image shows both in one
///                  pixel.
///
/// A slope that faces away more steeply than the grazing angle is in shadow, one that faces the
/// antenna more steeply than the incidence angle in layover. A part of the ground that is in shadow
/// itself counts all the same as the other part of a layover, as it does in maps of layover made
/// from range alone (Kropatsch and Strobl 1990, IEEE Trans. GRS 28(1)).
///
/// Line and circle are followed in steps that a slope of `steepest` cannot leave unseen, or of
/// an eighth of detail_m; a least clearance between steps is refined by Brent's method to 1e-3 of a
/// step. Points within detail_m / 8192 of the edge of a shadow or layover may be decided either
/// way.
class TerrainSight {
 public:
  /// `scene` must outlive it.
  TerrainSight(const Scene& scene, Ground ground);

  /// LookLoss::kShadow, kLayover (in this order) or nothing. `p_m` lies on the ground and on the
  /// look side; `motion` is that of the antenna at the time of the look, frame axes.
  [[nodiscard]] std::optional<LookLoss> Hides(const Motion& motion,
                                              LookSide side,
                                              const Eigen::Vector3d& p_m) const;

 private:
  /// Height above the ellipsoid (`local`: z), and that above the ground.
  struct Height {
    double own_m = 0.0, clear_m = 0.0;
  };
  [[nodiscard]] Height HeightOf(const Eigen::Vector3d& p_m) const;
  [[nodiscard]] bool InShadow(const Eigen::Vector3d& antenna_m, const Eigen::Vector3d& p_m) const;
  [[nodiscard]] bool InLayover(const Motion& motion,
                               LookSide side,
                               const Eigen::Vector3d& p_m) const;

  const Scene& scene_;
  Ground ground_;
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d enu_from_frame_ = Eigen::Matrix3d::Identity();
};

}  // namespace sarblock
