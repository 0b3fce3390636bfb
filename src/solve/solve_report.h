// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <limits>
#include <string>

namespace sarblock {

/// What a solver reports.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  int formed = 0;  ///< times the system was formed, its work; of SolveReduced
  double initial_cost_1 = 0.0;
  double final_cost_1 = 0.0;
  /// Newton decrement at the end in sigmas, steps to come included; of least squares.
  double decrement_1 = 0.0;
  std::string message;
};

struct SolveOptions {
  int max_iterations = AdjustOptions{}.max_iterations;
  /// Times the system may be formed, refused steps included: a bound of the work; of SolveReduced.
  int max_formed = std::numeric_limits<int>::max();
  int threads = 1;
  /// Newton decrement, in sigmas over all unknowns, at which the solution is done.
  double settled_1 = AdjustOptions{}.tolerance_1;
  /// Takes the last step, shorter than settled_1, without forming the system again to verify it:
  /// what follows does (NewtonFinish).
  bool take_last_step = false;                    ///< of SolveReduced
  CeresSolver ceres_solver = CeresSolver::kAuto;  ///< of SolveWithCeres
  /// v'Pv above which a solution is of no use: after three steps, refused ones included, it is
  /// given up where four times
  /// what the next Newton step promises (the equations are bent) would not bring it there.
  double useless_above_1 = std::numeric_limits<double>::infinity();  ///< of SolveReduced
};

}  // namespace sarblock
