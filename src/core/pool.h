// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace sarblock {

/// Scratch that the pieces of a parallel loop borrow in turn: as many objects as pieces run at
/// once. An object comes back as the piece before left it.
template <typename T>
class Pool {
 public:
  class Borrowed {
   public:
    explicit Borrowed(Pool* pool) : pool_(pool), object_(pool->Take()) {}
    ~Borrowed() { pool_->Give(std::move(object_)); }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    [[nodiscard]] T& operator*() const { return *object_; }
    [[nodiscard]] T* operator->() const { return object_.get(); }

   private:
    Pool* pool_;
    std::unique_ptr<T> object_;
  };
  [[nodiscard]] Borrowed Borrow() { return Borrowed(this); }

 private:
  std::unique_ptr<T> Take() {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<T> object = std::move(free_.back());
        free_.pop_back();
        return object;
      }
    }
    return std::make_unique<T>();
  }
  void Give(std::unique_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(object));
  }
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace sarblock
