// SPDX-License-Identifier: Apache-2.0
#include "workspace.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <new>

#include <glog/logging.h>
#include <sys/mman.h>

namespace sarblock::sparse {
namespace {

/// Small ranges come from the heap piece by piece: to map and unmap one takes longer than to use
/// it.
constexpr std::size_t kFromHeap = std::size_t{1} << 15;

}  // namespace

FrontMemory::FrontMemory(std::size_t most) : most_(Rounded(most)) {
  if (most_ <= kFromHeap) return;
  void* range = mmap(nullptr,
                     most_ * sizeof(double),
                     PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE,
                     -1,
                     0);
  if (range == MAP_FAILED) return;
#ifdef MADV_HUGEPAGE
  static_cast<void>(madvise(range, most_ * sizeof(double), MADV_HUGEPAGE));  // advice only
#endif
  begin_ = static_cast<double*>(range);
  free_[0] = most_;
}

FrontMemory::~FrontMemory() {
  if (begin_ != nullptr) munmap(begin_, most_ * sizeof(double));
}

FrontMemory::Place FrontMemory::Take(std::size_t count) {
  const std::size_t length = Rounded(count);
  if (begin_ == nullptr) {
    void* place = std::aligned_alloc(kGrain * sizeof(double), length * sizeof(double));
    if (place == nullptr) throw std::bad_alloc();
    const std::lock_guard lock(mutex_);
    most_taken_ = std::max(most_taken_, taken_ += length);
    return {static_cast<double*>(place), Return(this, length)};
  }
  const std::lock_guard lock(mutex_);
  most_taken_ = std::max(most_taken_, taken_ += length);
  const auto fits = std::find_if(
      free_.begin(), free_.end(), [length](const auto& hole) { return hole.second >= length; });
  CHECK(fits != free_.end()) << "more was taken than announced";
  const auto [offset, available] = *fits;
  free_.erase(fits);
  if (available > length) free_[offset + length] = available - length;
  return {begin_ + offset, Return(this, length)};
}

std::size_t FrontMemory::most_taken() const {
  const std::lock_guard lock(mutex_);
  return most_taken_;
}

void FrontMemory::Give(double* place, std::size_t count) {
  const std::lock_guard lock(mutex_);
  taken_ -= count;
  if (begin_ == nullptr) {
    std::free(place);
    return;
  }
  auto hole = free_.emplace(static_cast<std::size_t>(place - begin_), count).first;
  const auto after = std::next(hole);
  if (after != free_.end() && hole->first + hole->second == after->first) {
    hole->second += after->second;
    free_.erase(after);
  }
  if (hole != free_.begin()) {
    const auto before = std::prev(hole);
    if (before->first + before->second == hole->first) {
      before->second += hole->second;
      free_.erase(hole);
    }
  }
}

}  // namespace sarblock::sparse
