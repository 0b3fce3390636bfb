// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <string>

namespace sarblock {

/// What a solver reports.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  double initial_cost_1 = 0.0;
  double final_cost_1 = 0.0;
  double damping_1 = 0.0;  ///< of SolveReduced, for a step that goes on
  std::string message;
};

struct SolveOptions {
  int max_iterations = 50;
  int threads = 1;
  /// Newton step left, in sigmas over all unknowns, at which the solution is done.
  double settled_1 = AdjustOptions{}.tolerance_1;
  double damping_1 = 1e-8;                        ///< of SolveReduced, at the first step
  CeresSolver ceres_solver = CeresSolver::kAuto;  ///< of SolveWithCeres
};

}  // namespace sarblock
