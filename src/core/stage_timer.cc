// SPDX-License-Identifier: Apache-2.0
#include "stage_timer.h"

#include <utility>

#include <sys/resource.h>

namespace sarblock {

StageTimer::StageTimer(std::string stage, std::vector<StageCost>* costs)
    : stage_(std::move(stage)), costs_(costs), begin_(std::chrono::steady_clock::now()) {}

StageTimer::~StageTimer() {
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin_;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const double peak_mib = static_cast<double>(usage.ru_maxrss) / 1024.0;
  for (StageCost& cost : *costs_) {
    if (cost.stage != stage_) continue;
    cost.wall_s += wall.count();
    cost.peak_mib = peak_mib;
    return;
  }
  costs_->push_back({stage_, wall.count(), peak_mib});
}

}  // namespace sarblock
