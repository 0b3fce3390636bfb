// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/path.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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
/// antenna more steeply than the incidence angle in layover. Ground that is in shadow itself still
/// counts as the other part of a layover, as in maps of layover made from range alone (Kropatsch
/// and Strobl 1990, IEEE Trans. GRS 28(1)).
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

/// Heights of a simulated terrain, anywhere in the scene plane.
///
///     h(x) = h_0 + relief sum_m a_m cos(k_m . x + phi_m),    sum_m a_m^2 = 2
///
/// with wave vectors k_m ~ N(0, 2/L^2 I), which gives the correlation exp(-(r/L)^2), and uniform
/// phases. Rolling: 64 waves of one L. Rugged: 4 octaves of 32 waves, L and the amplitude halved
/// from octave to octave. The mean square over all draws is exactly relief^2; over one area it
/// scatters with the number of correlation lengths in it.
class Terrain {
 public:
  Terrain(const SceneTerrain& terrain, std::uint64_t seed);
  [[nodiscard]] bool IsFlat() const { return waves_.empty(); }
  [[nodiscard]] double HeightAt(const Eigen::Vector2d& plane_m) const;
  /// For a search on it: six standard deviations bound heights and slopes in practice. Keeps a
  /// reference.
  [[nodiscard]] Ground AsGround() const;

 private:
  struct Wave {
    Eigen::Vector2d wave_rad_per_m;
    double phase_rad;
    double amplitude_m;
  };
  double mean_m_ = 0.0;
  double relief_m_ = 0.0;
  double shortest_m_ = 0.0;  // correlation length of the shortest octave
  std::vector<Wave> waves_;  // empty: flat
};

/// A point as planned: its place in the scene plane, and its role.
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
