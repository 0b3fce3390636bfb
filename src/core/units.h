// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace sarblock {

/// Angles are radians inside and degrees at the edges (files, messages).
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// Speed of light in vacuum, exact (SI).
inline constexpr double kSpeedOfLight_mps = 299792458.0;

}  // namespace sarblock
