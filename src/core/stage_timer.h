// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <chrono>
#include <string>
#include <vector>

namespace sarblock {

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
