// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geodesy/ellipsoid.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace sarblock {
namespace {

const std::vector<Ellipsoid>& Known() {
  static const std::vector<Ellipsoid> known = {
      {"WGS84", 6378137.0, 1.0 / 298.257223563},  // NGA.STND.0036, 2014
      {"GRS80", 6378137.0, 1.0 / 298.257222101},  // Moritz, 1980
      {"Moon", 1737400.0, 0.0},                   // IAU/IAG working group
      {"Venus", 6051800.0, 0.0},                  // IAU/IAG working group
      {"Mars", 3396190.0, 19990.0 / 3396190.0},   // IAU 2000, polar radius 3376.20 km
  };
  return known;
}

bool SameName(std::string_view a, std::string_view b) {
  const auto lower = [](char c) {
    return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&lower](char x, char y) {
    return lower(x) == lower(y);
  });
}

}  // namespace

Ellipsoid NamedEllipsoid(const std::string& name) {
  for (const Ellipsoid& known : Known()) {
    if (SameName(known.name, name)) return known;
  }
  std::string allowed;
  for (const std::string& known : EllipsoidNames())
    allowed += (allowed.empty() ? "" : ", ") + known;
  throw InputError("ellipsoid",
                   "'" + name + "' is not known, allowed are " + allowed +
                       DidYouMean(NearestName(name, EllipsoidNames())));
}

const std::vector<std::string>& EllipsoidNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Ellipsoid& known : Known()) list.push_back(known.name);
    return list;
  }();
  return names;
}

void Validate(const Ellipsoid& ellipsoid) {
  if (!(std::isfinite(ellipsoid.a_m) && ellipsoid.a_m > 0.0)) {
    throw InputError("ellipsoid.a_m",
                     std::to_string(ellipsoid.a_m) + " must be finite and greater than 0");
  }
  if (!(ellipsoid.flattening >= 0.0 && ellipsoid.flattening < 1.0)) {
    throw InputError("ellipsoid.flattening",
                     std::to_string(ellipsoid.flattening) + " must be at least 0 and less than 1");
  }
}

}  // namespace sarblock
