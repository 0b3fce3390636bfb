// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// What the looks of one point say of each other on the paths of a state.
struct PointConsensus {
  enum class Outcome {
    kAgree,       ///< all looks meet in one place
    kMajority,    ///< all but some do, and no other choice of as many
    kContradict,  ///< nothing tells which are wrong
    kOpen,        ///< too few looks, or they leave a direction open
  };
  Outcome outcome = Outcome::kOpen;
  std::vector<std::size_t> looks;  ///< that agree, ascending; of kContradict all
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< the best place whatever the outcome
  double weighted_square_sum = 0.0;                      ///< of the looks that agree
};

/// Minimal sets are pairs of looks: each pair's intersection is joined by every other look that
/// meets it within its noise, v'Pv times 1 / `variance_1` within chi-square at 0.999. The largest
/// set stands. `looks` are tried, whether they take part or not.
[[nodiscard]] PointConsensus FindPointConsensus(const AdjustmentProblem& problem,
                                                const BlockState& state,
                                                std::size_t point,
                                                double variance_1);

}  // namespace sarblock
