// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sarblock {

/// An ellipsoid of revolution: equatorial radius and flattening f = (a - b)/a.
struct Ellipsoid {
  std::string name;
  double a_m = 0.0;
  double flattening = 0.0;
};

/// WGS84, GRS80, Moon (1737.4 km), Venus (6051.8 km), Mars (IAU 2000: 3396.19 km, 1/169.894447...).
/// Names are matched without regard to case; throws InputError naming the nearest known one.
[[nodiscard]] Ellipsoid NamedEllipsoid(const std::string& name);
[[nodiscard]] const std::vector<std::string>& EllipsoidNames();

/// Throws InputError unless a is finite and positive and 0 <= f < 1 (oblate or sphere).
void Validate(const Ellipsoid& ellipsoid);

}  // namespace sarblock
