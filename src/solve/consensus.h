// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// Consensus of the looks of a block before anything is adjusted (docs/theory/consensus.md, section
/// 1).
struct GroundConsensus {
  /// By look: its place on the ground at the reference height, on the given paths, frame axes; NaN
  /// where its circle does not reach that height.
  std::vector<Eigen::Vector3d> place_m;
  /// By look: 1 where it agrees with the other looks of its point as far as they determine it.
  std::vector<std::uint8_t> agrees;
};

/// Puts every look on the ground at one reference height (that of the control, or of the
/// intersections that are determined) and compares the places pair of passes by pair of passes. A
/// path error moves all places of a pass alike: the part of the differences of a pair that a
/// polynomial of time and range describes, fitted by least median of squares, is not counted as an
/// error of looks. The rest is parallax of the terrain, noise, and looks that belong to another
/// point. Needs no position of a point, no intersection and no start of the corrections.
/// Deterministic; linear in the looks.
[[nodiscard]] GroundConsensus FindGroundConsensus(const AdjustmentProblem& problem,
                                                  double reference_height_m);

/// Consensus of the looks of one point on the paths of a state.
struct PointConsensus {
  enum class Outcome {
    kAgree,       ///< all looks meet in one place
    kMajority,    ///< all but some meet in one place, and no other choice of as many does
    kContradict,  ///< none can be identified as wrong
    kOpen,        ///< too few looks, or they leave a direction open
  };
  Outcome outcome = Outcome::kOpen;
  std::vector<std::size_t> looks;  ///< that agree, ascending; of kContradict all
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< the best place, for any outcome
  double weighted_square_sum = 0.0;                      ///< of the looks that agree
};

/// Minimal sets are pairs of looks: each pair's intersection is joined by every other look that
/// meets it within its noise, v'Pv times 1 / `variance` within chi-square at 0.999. The largest
/// set is kept. `looks` are tried, whether they take part or not.
[[nodiscard]] PointConsensus FindPointConsensus(const AdjustmentProblem& problem,
                                                const BlockState& state,
                                                std::size_t point,
                                                double variance);

/// What SolveByConsensus left out of a block.
struct ConsensusReport {
  struct PointRejection {
    std::size_t point = 0;
    std::vector<std::size_t> looks;  ///< left out; of a contradiction all
    bool azimuth = false;            ///< the larger component of that error
    double distance = 0.0;           ///< whitened length of the largest error of these looks
    bool contradiction = false;      ///< none can be identified as wrong: the point is left out
  };
  std::vector<PointRejection> left_out;  ///< by point, ascending
  int iterations = 0;
  /// No pass lost more than half of its looks, and the passes are connected as before: single looks
  /// are wrong, not a pass.
  bool scattered = false;
};

/// Brings a block near its solution from any start, with gross errors among its looks
/// (docs/theory/consensus.md): ground consensus, a graduated loss from there, consensus of each
/// point's looks on the paths found. `problem` and `state` are those of ComputeStartValues or after
/// any attempt to solve; corrections start from zero again. Looks and points that agree take part
/// at the end, each point in the place where its looks meet.
[[nodiscard]] ConsensusReport SolveByConsensus(const AdjustOptions& options,
                                               AdjustmentProblem* problem,
                                               BlockState* state,
                                               ProgressSink* progress);

}  // namespace sarblock
