// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sarblock {

/// A point whose own equations leave a direction open.
struct WeakPoint {
  std::uint32_t point = 0;
  double reciprocal_condition_1 = 0.0;
};

/// Smallest reciprocal condition of a point's scaled Jacobian that still counts as determined.
inline constexpr double kLeastPointCondition_1 = 1e-10;

}  // namespace sarblock
