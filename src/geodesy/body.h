// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sarblock {

/// How a body attracts and turns.
struct Body {
  std::string_view name;  ///< of its ellipsoid
  double gm = 0.0;        ///< gravity parameter [m3/s2]
  double rotation = 0.0;  ///< sidereal [rad/s], positive eastwards
};

/// The body of a named ellipsoid; null for an ellipsoid given by numbers. Moon: IAU/GRAIL GM;
/// Venus: IAU 2015 rotation, retrograde; Mars: IAU 2015.
[[nodiscard]] const Body* FindBody(const std::string& ellipsoid);

}  // namespace sarblock
