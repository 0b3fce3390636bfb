// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// A function of time with a continuous second derivative: a polynomial of degree 5 between nodes
/// that give value and two derivatives, straight beyond the first and the last node. Without nodes
/// it is zero.
class SmoothCurve {
 public:
  struct Node {
    double time_s = 0.0;
    double value = 0.0, first = 0.0, second = 0.0;
  };
  SmoothCurve() = default;
  /// Times strictly increase.
  explicit SmoothCurve(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}
  /// Natural cubic spline through values at increasing times, two or more.
  [[nodiscard]] static SmoothCurve Natural(const std::vector<double>& times_s,
                                           const std::vector<double>& values);

  /// Value and three derivatives; the third jumps at the nodes.
  [[nodiscard]] std::array<double, 4> At(double time_s) const;
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

 private:
  std::vector<Node> nodes_;
};

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
