// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "factor_outcome.h"
#include "front_division.h"
#include "workspace.h"

namespace sarblock {
class Ranks;
}

namespace sarblock::sparse {

/// One factorisation: every own front into its panel, its update matrix handed to its parent, which
/// may stand on another rank.
class FrontFactorisation {
 public:
  /// `values` of S on every rank; `factor` has room for the own panels.
  FrontFactorisation(const OwnFronts& own, std::span<const double> values, double* factor);

  /// The same on every rank. Throws OtherRankFailed.
  [[nodiscard]] FactorOutcome Run();
  /// Doubles of this rank.
  [[nodiscard]] std::size_t most_waiting() const { return memory_.most_taken(); }

 private:
  /// The least pivot of a front, or the one that failed, with ratio 0.
  struct Pivot {
    double ratio = 1.0;
    std::int64_t row = -1;  // in elimination order
  };

  void Work(std::size_t f);
  void RecordPivots(std::size_t f,
                    const std::vector<double>& diagonal,
                    const double* panel,
                    int failed);
  /// Update matrices of a stage go to the ranks of their parents.
  void MoveUpdates(int stage, Ranks* ranks);
  /// The first failed front of all ranks becomes known to all.
  void ShareFailure(Ranks* ranks);
  void SharePivots(Ranks* ranks);
  [[nodiscard]] LowerTriangle Update(std::size_t f) const;

  const OwnFronts& own_;
  const std::vector<Front>& fronts_;
  std::span<const double> values_;
  double* factor_;
  FrontMemory memory_;
  std::vector<FrontMemory::Place> updates_;  // waiting for their parents; packed if they came
  std::vector<Pivot> pivots_;
  std::atomic<std::size_t> failed_front_;  // the first in postorder
};

}  // namespace sarblock::sparse
