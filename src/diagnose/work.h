// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/diagnose/diagnosis.h"

#include <algorithm>
#include <cstddef>

#include "fit.h"

namespace sarblock {

/// Work of a diagnosis, counted and not timed, so that the same block is told the same on every
/// machine and with any number of threads. Its unit is a look formed: the equations of one look
/// made once, with its part of their elimination (docs/theory/diagnosis.md, eq. (11)).
class Work {
 public:
  enum class Start { kOfItsOwn, kOfAnother };

  /// At most so many adjustments of a block, of which a sample is solved.
  Work(const Block& block, const Block& sample, const DiagnosisBounds& bounds)
      : most_looks_(bounds.adjustments_1 *
                    std::max(kFormedByAdjustment * static_cast<double>(block.looks.size()),
                             kLeastOfSample * static_cast<double>(sample.looks.size()))) {}

  /// A solution of a sample of so many looks, and the recorded states that it copied.
  void AddSolution(std::size_t looks, const Fit& fit, Start start, std::size_t states) {
    const double of_start = fit.lost > 0 ? kStartOfLost : kStartValues;
    const double beside = kLastSum + (start == Start::kOfItsOwn ? of_start : 0.0);
    done_looks_ += static_cast<double>(looks) * (fit.formed + beside) +
                   kCopiedState * static_cast<double>(states);
  }
  /// Recorded states of which a path was made that does not go through them.
  void AddSmoothed(std::size_t states) {
    done_looks_ += kSmoothedState * static_cast<double>(states);
  }

  /// Less than this part of it is done.
  [[nodiscard]] bool Allows(double part_1) const { return done_looks_ < part_1 * most_looks_; }
  [[nodiscard]] double done_looks() const { return done_looks_; }
  [[nodiscard]] double most_looks() const { return most_looks_; }

 private:
  /// What one adjustment forms of each look, its covariance counted as what takes as long; and of
  /// each look of the sample at least, which is most of a small block.
  static constexpr double kFormedByAdjustment = 5.5, kLeastOfSample = 36.0;
  /// The last square sum with the places of the looks, and start values, also where circles do not
  /// meet, in looks formed once.
  static constexpr double kLastSum = 2.0, kStartValues = 2.0, kStartOfLost = 5.0;
  static constexpr double kCopiedState = 0.005, kSmoothedState = 4.0;

  double most_looks_;
  double done_looks_ = 0.0;
};

}  // namespace sarblock
