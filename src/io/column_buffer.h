// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>

namespace sarblock {

/// Values of a column of some rows, without the zeros that a std::vector writes first.
template <typename T>
class ColumnBuffer {
 public:
  /// Room for `rows`; the first `kept` of those before stay.
  void MakeRoom(std::size_t rows, std::size_t kept) {
    if (rows <= room_) return;
    auto values = std::make_unique_for_overwrite<T[]>(rows);
    std::copy_n(values_.get(), kept, values.get());
    values_ = std::move(values);
    room_ = rows;
  }
  [[nodiscard]] T* data() const { return values_.get(); }
  /// The first `rows`, for which there is room.
  [[nodiscard]] std::span<T> first(std::size_t rows) const { return {values_.get(), rows}; }

 private:
  std::unique_ptr<T[]> values_;
  std::size_t room_ = 0;
};

}  // namespace sarblock
