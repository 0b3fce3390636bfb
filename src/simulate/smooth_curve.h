// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

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

}  // namespace sarblock
