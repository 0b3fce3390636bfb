// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

namespace sarblock {

/// While one of these lives, ParallelForChunks() asks `sink` before every chunk whether to stop, in
/// loops that this thread begins, and throws Interrupted then: who waits at a terminal need not
/// wait for the end of a loop over a million points. `sink` must answer any thread.
class CancellationScope {
 public:
  explicit CancellationScope(const ProgressSink& sink);
  ~CancellationScope();
  CancellationScope(const CancellationScope&) = delete;
  CancellationScope& operator=(const CancellationScope&) = delete;

  /// The sink of the innermost scope of this thread; null without one.
  [[nodiscard]] static const ProgressSink* Current();

 private:
  const ProgressSink* outer_;
};

}  // namespace sarblock
