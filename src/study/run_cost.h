// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace sarblock {

/// What one call cost.
struct RunCost {
  double wall_s = 0.0;
  double cpu_s = 0.0;     ///< all threads
  double peak_mib = 0.0;  ///< NaN where the system does not tell
};

/// Runs `work` and measures it. The peak is that of the resident set during the call less what was
/// resident before it. Freed memory is given back first (malloc_trim); the process's high-water
/// mark, which otherwise only grows, is set back by /proc/self/clear_refs (Linux).
[[nodiscard]] RunCost MeasureRun(const std::function<void()>& work);

}  // namespace sarblock
