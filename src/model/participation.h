// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "problem.h"

namespace sarblock {

/// What takes part in an adjustment, kept so that a trial can be undone: looks and their weights,
/// points, known positions.
class Participation {
 public:
  explicit Participation(const AdjustmentProblem& problem)
      : look_used_(problem.look_used),
        point_status_(problem.point_status),
        point_reason_(problem.point_reason),
        misplaced_(problem.misplaced),
        weights_(problem.weights),
        control_of_(problem.control_of) {}

  /// Of the problem that it was made of.
  void Restore(AdjustmentProblem* problem) const {
    problem->look_used = look_used_;
    problem->point_status = point_status_;
    problem->point_reason = point_reason_;
    problem->misplaced = misplaced_;
    problem->weights = weights_;
    problem->control_of = control_of_;
  }

 private:
  std::vector<std::uint8_t> look_used_;
  std::vector<PointStatus> point_status_;
  std::vector<std::string> point_reason_;
  std::vector<std::uint8_t> misplaced_;
  std::vector<LookWeights> weights_;
  std::vector<std::int32_t> control_of_;
};

}  // namespace sarblock
