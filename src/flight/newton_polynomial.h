// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/flight/path_through.h"

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Newton's form of an interpolation polynomial: nodes with repetitions and divided differences,
/// docs/theory/flight_path.md, eq. (14)-(15). kStates takes positions and velocities, kPositions
/// positions alone.
class NewtonPolynomial {
 public:
  NewtonPolynomial(std::span<const StateVector> states, OrbitThrough through);
  /// Position and its derivative.
  [[nodiscard]] StateVector At(double time_s) const;

 private:
  Eigen::Vector3d origin_m_;  // keeps the differences small
  std::vector<double> node_s_;
  std::vector<Eigen::Vector3d> coefficients_;
};

/// `count` states around the interval that begins at state k, all if there are fewer.
[[nodiscard]] std::span<const StateVector> StatesAround(std::span<const StateVector> states,
                                                        std::size_t k,
                                                        std::size_t count);

/// States of the polynomial of degree 7.
[[nodiscard]] constexpr std::size_t StatesOf(OrbitThrough through) {
  return through == OrbitThrough::kStates ? 4 : 8;
}

}  // namespace sarblock
