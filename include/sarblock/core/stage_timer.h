// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace sarblock {

/// Wall time of one stage of a run and the process's peak memory at its end.
struct StageCost {
  std::string stage;  ///< read, start, solve, covariance, quality, write
  double wall_s = 0.0;
  double peak_mib = 0.0;  ///< largest resident set of the process so far
};

/// Adds a StageCost to a list when it goes out of scope.
class StageTimer {
 public:
  StageTimer(std::string stage, std::vector<StageCost>* costs);
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  std::string stage_;
  std::vector<StageCost>* costs_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace sarblock
