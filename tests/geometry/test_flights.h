// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <cmath>

#include <Eigen/Core>

namespace sarblock::test {

/// A circle as large and as fast as a low orbit of the Earth.
inline constexpr double kCircleRadius_m = 7071234.5, kCircleRate_radps = 1.0618e-3;
inline StateVector OnCircle(double time_s) {
  const double angle = 0.7 + kCircleRate_radps * time_s;
  return {time_s,
          kCircleRadius_m * Eigen::Vector3d(std::cos(angle), 0.3, std::sin(angle)),
          kCircleRadius_m * kCircleRate_radps *
              Eigen::Vector3d(-std::sin(angle), 0.0, std::cos(angle))};
}

/// 97 m/s along x, waves of some metres with periods of 7 to 23 s in all axes: states 10 s apart or
/// more do not resolve them.
class Aircraft {
 public:
  explicit Aircraft(double phase) : phase_(phase) {}

  [[nodiscard]] StateVector operator()(double time_s) const {
    StateVector state{time_s, {97.0 * time_s, 250.0, 3000.0}, {97.0, 0.0, 0.0}};
    const auto add = [&](int axis, double size_m, double period_s, double phase) {
      const double w = 2.0 * M_PI / period_s;
      const double angle = w * time_s + phase + phase_ * (1.0 + axis) * period_s;
      state.position_m[axis] += size_m * std::sin(angle);
      state.velocity_mps[axis] += size_m * w * std::cos(angle);
    };
    add(0, 1.9, 17.3, 0.3);
    add(1, 5.3, 23.1, 1.1);
    add(1, 0.7, 7.1, 2.3);
    add(2, 3.7, 19.7, 4.1);
    add(2, 0.4, 9.3, 5.2);
    return state;
  }

 private:
  double phase_;
};

}  // namespace sarblock::test
