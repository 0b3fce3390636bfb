// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sarblock {

/// What long work tells its caller. The library prints nothing: the command line draws a bar.
/// Calls come from one thread at a time.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  /// A named stage is `done` of `total` (total 0: unknown). `detail` is for people.
  virtual void Update(std::string_view stage,
                      std::size_t done,
                      std::size_t total,
                      std::string_view detail) = 0;
  /// True once the user asked to stop; work ends between steps by throwing Interrupted.
  [[nodiscard]] virtual bool Cancelled() const = 0;
};

/// Wall time of one stage of a run and the process's peak memory at its end.
struct StageCost {
  std::string stage;  ///< read, start, solve, covariance, quality, write
  double wall_s = 0.0;
  double peak_mib = 0.0;  ///< largest resident set of the process so far
};

/// Updates `sink` if there is one; throws Interrupted(stage) if it was cancelled.
void Step(ProgressSink* sink,
          std::string_view stage,
          std::size_t done,
          std::size_t total,
          std::string_view detail = {});

}  // namespace sarblock
