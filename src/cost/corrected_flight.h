// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/cost/corrected_flight.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "model/corrected_paths.h"
#include "model/look_evaluation.h"
#include "model/parameters.h"

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

}  // namespace sarblock
