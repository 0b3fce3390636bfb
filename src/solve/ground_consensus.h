// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// What the looks of a block say of each other before anything is adjusted
/// (docs/theory/consensus.md, section 1).
struct GroundConsensus {
  /// By look: its place on the ground at the reference height, on the given paths, frame axes; NaN
  /// where its circle does not reach that height.
  std::vector<Eigen::Vector3d> place_m;
  /// By look: 1 where it agrees with the other looks of its point as far as they can tell.
  std::vector<std::uint8_t> agrees;
};

/// Puts every look on the ground at one reference height (that of the control, or of the
/// intersections that are determined) and compares the places pair of passes by pair of passes. A
/// path error moves all places of a pass alike: what a polynomial of time and range describes of
/// the differences of a pair, fitted by least median of squares, is not held against them. What is
/// left is parallax of the terrain, noise, and looks that belong to another point. Needs no
/// position of a point, no intersection and no start of the corrections. Deterministic; linear in
/// the looks.
[[nodiscard]] GroundConsensus FindGroundConsensus(const AdjustmentProblem& problem,
                                                  double reference_height_m);

}  // namespace sarblock
