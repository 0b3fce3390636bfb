// SPDX-License-Identifier: Apache-2.0
#include "parallel.h"

#include "sarblock/core/error.h"

#include <algorithm>

#include "cancellation.h"
#include "ranks.h"
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

namespace sarblock {

void ParallelForChunks(std::size_t count,
                       std::size_t chunk_size,
                       const std::function<void(std::size_t, std::size_t, std::size_t)>& work) {
  if (count == 0) return;
  const std::size_t chunks = (count + chunk_size - 1) / chunk_size;
  const ProgressSink* const sink = CancellationScope::Current();
  const RanksScope alone(nullptr);  // other threads have no ranks, so this one has none either
  const auto run = [&](std::size_t chunk) {
    if (sink != nullptr && sink->Cancelled()) throw Interrupted("a loop over points");
    const std::size_t begin = chunk * chunk_size;
    work(chunk, begin, std::min(count, begin + chunk_size));
  };
  if (chunks == 1) {
    run(0);
    return;
  }
  // A loop inside another one ends in its middle, without a word, where that one has failed: what
  // follows it must not read what was never made.
  tbb::task_group_context context;
  tbb::parallel_for(std::size_t{0}, chunks, run, context);
  if (context.is_group_execution_cancelled()) throw Interrupted("a loop over points");
}

struct ThreadLimit::Impl {
  explicit Impl(std::size_t threads)
      : control(tbb::global_control::max_allowed_parallelism, threads) {}
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : impl_(std::make_unique<Impl>(
          static_cast<std::size_t>(threads > 0 ? threads : AvailableCores()))) {}
ThreadLimit::~ThreadLimit() = default;

int AvailableCores() { return std::max(1, tbb::info::default_concurrency()); }

int ThreadsAllowed() {
  const std::size_t most =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::max(1, static_cast<int>(std::min(most, static_cast<std::size_t>(AvailableCores()))));
}

}  // namespace sarblock
