// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>

namespace sarblock::sparse {

/// Memory of fronts that come and go on several threads: places in one range of addresses, the
/// lowest that fits, so that pages once touched serve again. New pages cost more than the
/// arithmetic of a front of a few hundred rows. Takes as many pages as are in use at once and
/// what stands empty between them; returned with the object.
class FrontMemory {
 public:
  /// `most` doubles over all calls of Take, each rounded up to kGrain. Only addresses are reserved;
  /// where that is little, or the system refuses even those, every place is allocated by itself.
  explicit FrontMemory(std::size_t most);
  ~FrontMemory();
  FrontMemory(const FrontMemory&) = delete;
  FrontMemory& operator=(const FrontMemory&) = delete;

  class Return {
   public:
    Return() = default;
    Return(FrontMemory* memory, std::size_t count) : memory_(memory), count_(count) {}
    void operator()(double* place) const { memory_->Give(place, count_); }

   private:
    FrontMemory* memory_ = nullptr;
    std::size_t count_ = 0;
  };
  using Place = std::unique_ptr<double[], Return>;
  /// Uninitialised; goes back when the pointer dies, which must be before this object. Throws
  /// std::bad_alloc.
  [[nodiscard]] Place Take(std::size_t count);

  /// Doubles that were taken at once, at most so far.
  [[nodiscard]] std::size_t most_taken() const;

  static constexpr std::size_t kGrain = 8;  ///< doubles in a cache line
  [[nodiscard]] static std::size_t Rounded(std::size_t count) {
    return (count / kGrain + 1) * kGrain;
  }

 private:
  void Give(double* place, std::size_t count);

  std::size_t most_;
  double* begin_ = nullptr;
  mutable std::mutex mutex_;
  std::size_t taken_ = 0, most_taken_ = 0;
  std::map<std::size_t, std::size_t> free_;  // offset, length of what is free
};

}  // namespace sarblock::sparse
