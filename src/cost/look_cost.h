// SPDX-License-Identifier: Apache-2.0
// What the cost functions read of a flight, and the same functions as the solver's Ceres engine
// takes them: of a problem of the adjustment, whose weights and paths they use as they are.
#pragma once

#include "sarblock/cost/look_cost.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "model/corrected_paths.h"
#include "model/look_evaluation.h"
#include "model/parameters.h"
#include "model/problem.h"

namespace sarblock {

/// The local corrections of a look have the order of PassCorrections: those of blocks that do not
/// depend on the time of a look, then four of each spline.
struct CorrectedFlight::Parts {
  /// One correction of the caller.
  struct Term {
    int size = 0;            ///< of one block
    std::size_t blocks = 1;  ///< in all
    int spline = -1;         ///< index into PassCorrections::splines
    std::vector<std::string> names;
    std::vector<PriorSigma> prior_sigmas;  ///< of one block; NaN: none
  };
  std::vector<Term> terms;
  std::vector<int> static_sizes;  ///< of the blocks that do not depend on the time

  // Only in a flight that a caller made; one of the solver refers to the paths of its problem.
  Frame frame = Frame::Local();
  FlightPath nominal;
  PassCorrections corrections;
  std::optional<CorrectedPath> own;

  const CorrectedPath* path = nullptr;  ///< `own`, or that of a LookModel

  Parts() = default;
  Parts(const Parts&) = delete;  // it points to itself
  Parts& operator=(const Parts&) = delete;

  [[nodiscard]] int ColumnCount() const;
  /// Checks the time, the cone and what a measured Doppler needs; throws InputError.
  [[nodiscard]] MeasuredLook Measured(const LookMeasurement& look) const;
};

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
