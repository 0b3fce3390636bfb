// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>

#include "model/problem.h"

namespace sarblock {

/// A tolerance for a block of so many points: few unknowns share what is left among them, and one
/// step more costs nothing. Scaled by points / 1000, within [0.01, 1].
[[nodiscard]] double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem);

/// Why a solver gave up, in words.
extern const char kStagnates[];
[[nodiscard]] std::string LimitReached(int max_iterations);

/// Whether iterations still get anywhere: of every 50 accepted steps the cost must fall by a part
/// in a thousand, or the Newton decrement to half. Steps that shrink more slowly end nowhere within
/// any limit; those that shrink are let go on to the limit of iterations, which only guards. The
/// two ends, no progress and a limit, are those of Dennis and Schnabel (1996), Numerical Methods
/// for Unconstrained Optimization and Nonlinear Equations, section 7.2.
class ProgressOfSteps {
 public:
  [[nodiscard]] bool Stagnates(int iteration, double cost_1, double decrement_1);

 private:
  int iteration_ = 0;  ///< of the figures
  double cost_1_ = std::numeric_limits<double>::infinity();
  double decrement_1_ = std::numeric_limits<double>::infinity();
};

}  // namespace sarblock
