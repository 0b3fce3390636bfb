// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "smooth_curve.h"
#include <Eigen/Core>

namespace sarblock {

/// Offsets of a flight from its planned path, along, across, up.
class Wander {
 public:
  struct Offset {
    Eigen::Vector3d value_m, first_mps, second_mps2, third_mps3;
  };
  /// Draws that of pass number `pass_index` from its own streams of `seed`, for the span of the
  /// planned path.
  Wander(const SceneWander& scene, const Pass& planned, std::size_t pass_index, std::uint64_t seed);
  [[nodiscard]] Offset At(double time_s) const;

 private:
  double start_s_ = 0.0;                // from which the table counts
  std::array<SmoothCurve, 3> process_;  // by axis
  std::array<SmoothCurve, 3> table_;
};

}  // namespace sarblock
