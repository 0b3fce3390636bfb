// SPDX-License-Identifier: Apache-2.0
#include "run_cost.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <string>

#include <malloc.h>
#include <sys/resource.h>

namespace sarblock {
namespace {

/// A line `NAME: n kB` of /proc/self/status; NaN where it is not there.
double StatusMib(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) / 1024.0;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// False where the mark cannot be set back.
bool ResetHighWater() {
  std::ofstream refs("/proc/self/clear_refs");
  refs << "5";
  return static_cast<bool>(refs.flush());
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

RunCost MeasureRun(const std::function<void()>& work) {
  malloc_trim(0);
  const bool peak = ResetHighWater();
  const double before_mib = StatusMib("VmRSS");
  const double cpu_s = CpuSeconds();
  const auto begin = std::chrono::steady_clock::now();
  work();
  RunCost cost;
  cost.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  cost.cpu_s = CpuSeconds() - cpu_s;
  cost.peak_mib = peak ? std::max(0.0, StatusMib("VmHWM") - before_mib)
                       : std::numeric_limits<double>::quiet_NaN();
  return cost;
}

}  // namespace sarblock
