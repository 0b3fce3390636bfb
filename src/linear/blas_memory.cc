// SPDX-License-Identifier: Apache-2.0
#include "blas_memory.h"

#include "sarblock/core/error.h"

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/resource.h>

namespace sarblock::dense {

void TakeBlasMemory(int threads) {
  constexpr std::size_t kBytes = (std::size_t{128} << 20) + (std::size_t{1} << 16);  // of a buffer
  static std::mutex mutex;
  static int taken = 0;
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  void* const allocate = dlsym(RTLD_DEFAULT, "blas_memory_alloc");
  void* const release = dlsym(RTLD_DEFAULT, "blas_memory_free");
  if (allocate == nullptr || release == nullptr) return;
  const std::lock_guard lock(mutex);
  if (threads <= taken) return;
  const std::size_t missing = kBytes * static_cast<std::size_t>(threads - taken);
  void* const room =
      ::mmap(nullptr, missing, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) {
    throw InputError("ulimit -v",
                     "leaves this process no " + std::to_string(missing >> 20U) +
                         " MiB of addresses, which BLAS takes for " + std::to_string(threads) +
                         (threads == 1 ? " thread" : " threads") +
                         "; a higher limit is needed, or fewer --threads");
  }
  ::munmap(room, missing);
  std::vector<void*> buffers;
  for (int i = 0; i < threads; ++i) {
    buffers.push_back(reinterpret_cast<void* (*)(int)>(allocate)(0));
  }
  for (void* const buffer : buffers) reinterpret_cast<void (*)(void*)>(release)(buffer);
  taken = threads;
}

}  // namespace sarblock::dense
