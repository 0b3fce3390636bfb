// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace sarblock {

/// The middle of values put in order, of an even number the upper of both; NaN of none. None may be
/// NaN. Leaves them in another order.
template <typename T>
[[nodiscard]] T MedianInPlace(std::vector<T>* values) {
  if (values->empty()) return std::numeric_limits<T>::quiet_NaN();
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

/// The same, of a copy.
template <typename T>
[[nodiscard]] T Median(std::vector<T> values) {
  return MedianInPlace(&values);
}

}  // namespace sarblock
