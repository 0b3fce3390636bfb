// SPDX-License-Identifier: Apache-2.0
#include "threads.h"

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "ranks.h"
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>
#include <sys/resource.h>

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

namespace {

thread_local const ProgressSink* t_sink = nullptr;

}  // namespace

CancellationScope::CancellationScope(const ProgressSink* sink)
    : outer_(std::exchange(t_sink, sink != nullptr ? sink : t_sink)) {}
CancellationScope::~CancellationScope() { t_sink = outer_; }

const ProgressSink* CancellationScope::Current() { return t_sink; }

void RunInLibrary(int threads, const ProgressSink* sink, const std::function<void()>& work) {
  const CancellationScope scope(sink);
  if (threads <= 0 || threads >= ThreadsAllowed()) {
    RunIsolated(work);  // a loop of the caller may have begun this
    return;
  }
  tbb::task_arena arena(threads);
  arena.execute(work);
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
  const std::size_t process =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const int arena = tbb::this_task_arena::max_concurrency();
  return std::max(1, std::min({static_cast<int>(process), arena, AvailableCores()}));
}

PiecesOfRank PiecesOf(std::size_t count, int rank, int ranks) {
  const auto r = static_cast<std::size_t>(rank), n = static_cast<std::size_t>(ranks);
  const auto begin = [&](std::size_t k) { return count / n * k + count % n * k / n; };
  return {begin(r), begin(r + 1)};
}

std::span<std::byte> SharedArray::Bytes(std::size_t begin,
                                        std::size_t end,
                                        const PiecesOfRank& chunks) const {
  const auto elements = [this](std::size_t from, std::size_t to) {
    return bytes_.subspan(from * element_bytes_, (to - from) * element_bytes_);
  };
  if (bytes_.empty()) return {};
  switch (kind_) {
    case Kind::kChunk:
      return elements(chunks.first, chunks.last);
    case Kind::kRange:
      return elements(offsets_[begin], offsets_[end]);
    case Kind::kItem:
      break;
  }
  return elements(begin, end);
}

void ForChunksOfRanks(std::size_t count,
                      std::size_t chunk_size,
                      std::initializer_list<SharedArray> arrays,
                      const std::function<void(std::size_t, std::size_t, std::size_t)>& work) {
  Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr) {
    ParallelForChunks(count, chunk_size, work);
    return;
  }
  const std::size_t chunks = (count + chunk_size - 1) / chunk_size;
  const auto item = [&](std::size_t chunk) { return std::min(count, chunk * chunk_size); };
  const PiecesOfRank own = PiecesOf(chunks, ranks->rank(), ranks->size());
  const std::size_t before = item(own.first);
  ParallelForChunks(item(own.last) - before,
                    chunk_size,
                    [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                      work(own.first + chunk, before + begin, before + end);
                    });
  std::vector<RankPart> parts;
  for (const SharedArray& array : arrays) {
    for (int r = 0; r < ranks->size(); ++r) {
      const PiecesOfRank its = PiecesOf(chunks, r, ranks->size());
      AddPart(array.Bytes(item(its.first), item(its.last), its), r, &parts);
    }
  }
  ranks->Share(parts);
}

int ThreadsOfRanks() {
  int sum = 0;
  for (const int threads : JoinedOfRanks(std::vector<int>{ThreadsAllowed()})) sum += threads;
  return sum;
}

void PipeInOrder(std::size_t at_once,
                 const std::function<bool(std::size_t)>& next,
                 const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& take) {
  const ProgressSink* const sink = CancellationScope::Current();
  std::vector<std::exception_ptr> errors(at_once);
  std::size_t items = 0;
  bool failed = false;
  // An item is begun when fewer than `at_once` are in the pipe, which they leave in order: its
  // place is free then.
  const auto begin = [&](tbb::flow_control& control) {
    const std::size_t place = items++ % at_once;
    try {
      if (sink != nullptr && sink->Cancelled()) throw Interrupted("a loop over rows");
      if (failed || !next(place)) control.stop();
    } catch (...) {
      errors[place] = std::current_exception();
      failed = true;
    }
    return place;
  };
  const auto go_on = [&](std::size_t place) {
    try {
      if (!errors[place]) work(place);
    } catch (...) {
      errors[place] = std::current_exception();
    }
    return place;
  };
  const auto end = [&](std::size_t place) {
    if (errors[place]) std::rethrow_exception(errors[place]);
    take(place);
  };
  tbb::task_group_context context;
  tbb::parallel_pipeline(
      at_once,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, begin) &
          tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, go_on) &
          tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, end),
      context);
  if (context.is_group_execution_cancelled()) throw Interrupted("a loop over rows");
}

std::size_t ItemsAtOnce() { return 1 + static_cast<std::size_t>(ThreadsAllowed()); }

void RunIsolated(const std::function<void()>& work) { tbb::this_task_arena::isolate(work); }

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
