// SPDX-License-Identifier: Apache-2.0
#include "body.h"

#include <algorithm>
#include <array>

namespace sarblock {
namespace {

constexpr std::array<Body, 5> kBodies = {{{"WGS84", 3.986004418e14, 7.292115e-5},
                                          {"GRS80", 3.986005e14, 7.292115e-5},
                                          {"Moon", 4.9028e12, 2.6616995e-6},
                                          {"Venus", 3.24858592e14, -2.9924e-7},
                                          {"Mars", 4.282837e13, 7.088218e-5}}};

}  // namespace

const Body* FindBody(const std::string& ellipsoid) {
  const auto* found = std::find_if(
      kBodies.begin(), kBodies.end(), [&](const Body& body) { return body.name == ellipsoid; });
  return found == kBodies.end() ? nullptr : found;
}

}  // namespace sarblock
