// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "terrain_sight.h"
#include <Eigen/Core>

namespace sarblock {

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
