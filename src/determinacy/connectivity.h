// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// How the passes of a block hang together through the points that take part: passes are nodes, a
/// point joins all passes whose looks of it are in use (union-find).
struct PassConnection {
  int islands = 0;                           ///< of the passes that have looks
  std::vector<std::uint8_t> pass_has_looks;  ///< by pass

  /// True where `after` has as few islands and no pass lost its last look.
  [[nodiscard]] bool IsKeptBy(const PassConnection& after) const;
};

[[nodiscard]] PassConnection ConnectPasses(const AdjustmentProblem& problem);

}  // namespace sarblock
