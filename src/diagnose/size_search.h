// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "fit.h"
#include "hypothesis.h"
#include "work.h"

namespace sarblock {

/// Solves a sample with mistakes undone, and counts how often and with how much work.
class Trials {
 public:
  Trials(const Block& sample, CorrectionModel corrections, Work work, ProgressSink* progress);

  /// The sample as it is.
  [[nodiscard]] Fit AsItIs();
  /// Without the looks of some points.
  [[nodiscard]] Fit Without(const std::vector<std::uint32_t>& points, const FitOptions& options);
  [[nodiscard]] Fit With(const Hypothesis& hypothesis, double value, const FitOptions& options);
  /// The block that AsItIs() solves: check points as control.
  [[nodiscard]] const Block& given() const { return given_; }
  [[nodiscard]] int solutions() const { return solutions_; }
  [[nodiscard]] const Work& work() const { return work_; }

 private:
  [[nodiscard]] Fit Solve(const Block& block, const FitOptions& options);

  const Block& sample_;
  Block given_;
  CorrectionModel corrections_;
  Work work_;
  std::size_t states_ = 0;  ///< recorded states of the passes, which every trial copies
  ProgressSink* progress_;
  int solutions_ = 0;
};

/// A hypothesis solved: at its size, with the size's standard deviation where it is free.
struct Solved {
  double value = 0.0, sigma = kNotGiven;
  Fit fit;
};

struct SearchOptions {
  Effort effort = Effort::kFull;
  /// Cost above which a size is of no use: the search ends where four times what the parabola
  /// promises would not bring it there.
  double useless_above_1 = std::numeric_limits<double>::infinity();
  double part_of_work_1 = 1.0;  ///< at which the search ends where it is
};

/// Finds the size of least cost from hypothesis.value on: Newton's steps on the parabola through
/// three solutions, a fixed number at most, fewer with Effort::kQuick. Its standard deviation is
/// that of the likelihood, sqrt(2 / cost''). Returns `first` where the cost has no minimum there.
[[nodiscard]] Solved SearchSize(const Hypothesis& hypothesis,
                                const Fit& first,
                                const SearchOptions& options,
                                Trials* trials);

}  // namespace sarblock
