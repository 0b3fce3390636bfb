// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "places.h"
#include <Eigen/Core>

namespace sarblock {

/// A pass as planned, with the data that decide visibility.
struct NominalPass {
  Pass pass;
  double reach_m = 0.0;  ///< no point of the strip is farther from the middle of the path
};

/// Nominal paths and strips of all flights, in file order. The states reach beyond the strip by
/// what six standard deviations of the navigation errors and noise can move a look's time.
/// Throws InputError where an orbit cannot see its aim.
[[nodiscard]] std::vector<NominalPass> PlanPasses(const Scene& scene);

/// One planned look at a point.
struct PlannedLook {
  std::uint32_t pass = 0;
  double time_s = 0.0;  ///< cone time on the nominal path
};

/// A look that a pass within reach of a point does not take.
struct LostLook {
  std::uint32_t pass = 0;
  LookLoss loss = LookLoss::kBeyondReach;
};

/// Which strips show a point (docs/scenes.md). Space is cut into cubes half as wide as the farthest
/// reach of a pass; a cube lists the passes whose reach touches it, so that a point asks the passes
/// around it and not all of a large block. Reading is thread-safe.
class Visibility {
 public:
  /// All must outlive it; `terrain` null: nothing hides. Throws InputError where a strip lies
  /// outside its path.
  Visibility(const Frame& frame,
             const std::vector<NominalPass>& planned,
             const TerrainSight* terrain);

  /// Looks at p in order of passes, and those that passes within reach do not take.
  void LooksAt(const Eigen::Vector3d& p_m,
               std::vector<PlannedLook>* looks,
               std::vector<LostLook>* lost) const;

 private:
  /// The cone's apex and axis at one end of the strip.
  struct End {
    Eigen::Vector3d position_m;
    Eigen::Vector3d ahead;
  };
  /// The sphere about the middle of a path that holds its strip, and the strip's two ends.
  struct Reach {
    Eigen::Vector3d middle_m;
    double square_m2 = 0.0;
    double sine_of_squint = 0.0;
    std::array<End, 2> ends;
  };
  using Cell = std::array<std::int64_t, 3>;
  struct HashCell {
    std::size_t operator()(const Cell& cell) const;
  };

  [[nodiscard]] Cell CellOf(const Eigen::Vector3d& p_m) const;
  /// The loss, if it can be decided without solving for the time of the look.
  [[nodiscard]] std::optional<LookLoss> FindPlainLoss(const Reach& reach,
                                                      const Eigen::Vector3d& p_m) const;

  const Frame& frame_;
  const std::vector<NominalPass>& planned_;
  const TerrainSight* terrain_;
  std::vector<Reach> reaches_;
  double cell_m_ = 1.0;
  std::unordered_map<Cell, std::vector<std::uint32_t>, HashCell> passes_of_;
};

}  // namespace sarblock
