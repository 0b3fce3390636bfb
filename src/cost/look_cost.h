// SPDX-License-Identifier: Apache-2.0
// The cost functions of look_cost.h as the solver's Ceres engine takes them: of a problem of the
// adjustment, whose weights and paths they use as they are.
#pragma once

#include "sarblock/cost/look_cost.h"

#include <vector>

#include "model/problem.h"

namespace sarblock {

/// By pass the flight of a problem, with one block for each parameter block of its layout. It
/// refers to the problem, which must outlive it, and reads the paths where the problem does at that
/// moment.
[[nodiscard]] std::vector<FlightPointer> FlightsOf(const AdjustmentProblem& problem);

/// Both measurements of a look with the weights that it has now. `start_m`, the origin of its
/// point, may move between evaluations and must outlive it.
[[nodiscard]] CostPointer LookCostOf(const AdjustmentProblem& problem,
                                     FlightPointer flight,
                                     const Eigen::Vector3d* start_m,
                                     std::size_t look);

/// Control equations of a point; `start_m` must outlive it.
[[nodiscard]] CostPointer ControlCostOf(const Frame& frame,
                                        const ControlEquations& control,
                                        const Eigen::Vector3d* start_m);

/// The equations of the priors of one block.
struct PriorOfBlock {
  CostPointer cost;         ///< of PriorRowsOf(); null if it has none
  std::vector<int> blocks;  ///< that it takes, in their order: the block and, where a process leads
                            ///< to it, the one before
};
[[nodiscard]] PriorOfBlock PriorCostOf(const ParameterLayout& layout, int block);

}  // namespace sarblock
