// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// What SolveByConsensus left out of a block.
struct ConsensusReport {
  struct OfPoint {
    std::size_t point = 0;
    std::vector<std::size_t> looks;  ///< left out; of a contradiction all
    bool azimuth = false;            ///< the larger component of that error
    double distance_1 = 0.0;         ///< whitened length of the largest error of these looks
    bool contradiction = false;      ///< nothing tells which is wrong: the point is left out
  };
  std::vector<OfPoint> left_out;  ///< by point, ascending
  int iterations = 0;
  /// No pass lost more than half of its looks, and the passes hang together as they did: single
  /// looks are wrong, not a pass.
  bool scattered = false;
};

/// Brings a block near its solution whatever the start, with gross errors among its looks
/// (docs/theory/consensus.md): ground consensus, a graduated loss from there, consensus of each
/// point's looks on the paths found. `problem` and `state` are those of ComputeStartValues or after
/// any attempt to solve; corrections start from zero again. Looks and points that agree take part
/// at the end, each point in the place where its looks meet.
[[nodiscard]] ConsensusReport SolveByConsensus(const AdjustOptions& options,
                                               AdjustmentProblem* problem,
                                               BlockState* state,
                                               ProgressSink* progress);

}  // namespace sarblock
