// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace sarblock {

/// Calls work(chunk, begin, end) for the pieces of [0, count) of `chunk_size` each, on the threads
/// ThreadLimit allows. Pieces do not depend on the number of threads, so results summed by
/// piece and then in order of pieces do not either. The first exception is rethrown here.
void ParallelForChunks(std::size_t count,
                       std::size_t chunk_size,
                       const std::function<void(std::size_t, std::size_t, std::size_t)>& work);

/// Limits the threads of ParallelForChunks while it lives; 0 means all cores.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Cores this process may use, at least 1.
[[nodiscard]] int AvailableCores();

/// Threads that ParallelForChunks may take now, at least 1. For the size of buffers, never for what
/// is computed.
[[nodiscard]] int ThreadsAllowed();

}  // namespace sarblock
