// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/corrections.h"

#include <utility>
#include <vector>

#include "fit.h"
#include "hypothesis.h"

namespace sarblock {

/// Solves a sample with mistakes undone, and counts how often.
class Trials {
 public:
  Trials(const Block& sample, CorrectionModel corrections, ProgressSink* progress)
      : sample_(sample), corrections_(std::move(corrections)), progress_(progress) {}

  /// The sample as it is.
  [[nodiscard]] Fit AsItIs();
  [[nodiscard]] Fit With(const Hypothesis& hypothesis,
                         double value,
                         const BlockState* warm,
                         Effort effort = Effort::kFull);
  /// The block that With() solves: check points as control.
  [[nodiscard]] Block BlockWith(const Hypothesis* hypothesis, double value) const;
  [[nodiscard]] int solutions() const { return solutions_; }

 private:
  const Block& sample_;
  CorrectionModel corrections_;
  ProgressSink* progress_;
  int solutions_ = 0;
};

/// A hypothesis solved: at its size, with the size's standard deviation where it is free.
struct Solved {
  double value = 0.0, sigma = kNotGiven;
  Fit fit;
};

/// Finds the size of least cost from hypothesis.value on: Newton's steps on the parabola through
/// three solutions, a fixed number at most, fewer with Effort::kQuick. Its standard deviation is
/// that of the likelihood, sqrt(2 / cost''). Returns `first` where the cost has no minimum there.
[[nodiscard]] Solved SearchSize(const Hypothesis& hypothesis,
                                const Fit& first,
                                Effort effort,
                                Trials* trials);

}  // namespace sarblock
