// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

namespace sarblock {

/// A number that is not there.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace sarblock
