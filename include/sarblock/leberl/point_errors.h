// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/configuration.h"

namespace sarblock::leberl {

/// What is wrong with one station: value used in the reconstruction minus true value.
struct StationErrors {
  double dx0_m = 0.0;     ///< antenna position along track
  double dy0_m = 0.0;     ///< antenna position across track
  double dz0_m = 0.0;     ///< antenna position up
  double dr_m = 0.0;      ///< slant range
  double dydot0_1 = 0.0;  ///< velocity direction, across component of a unit along vector
  double dzdot0_1 = 0.0;  ///< velocity direction, up component
};

/// Errors of both stations; `first` is ', `second` is ''.
struct StereoErrors {
  StationErrors first = {};
  StationErrors second = {};
};

/// Error of a reconstructed point (reconstructed minus true), frame of the paper.
struct PointError {
  double dx_m = 0.0;
  double dy_m = 0.0;
  double dz_m = 0.0;
};

/// Across-track error by dy0'' alone, dy = dy0'' (B - y)/B [m]. Leberl (1979), Eq. 12.
[[nodiscard]] double AcrossErrorOfSecondAcross(const StereoConfiguration& c, double dy0_second_m);

/// Along-track error [m], the mean of what the two Doppler planes say. Leberl (1979), Eq. 13:
///     dx = (dx0' + dx0'')/2 + dydot0' y/2 + dydot0'' (y - B)/2 + (dzdot0' + dzdot0'') H/2
/// kDerived: the sight line is (0, y, -H), so the dydot0 terms have the opposite sign,
///     dx = (dx0' + dx0'')/2 - dydot0' y/2 - dydot0'' (y - B)/2 + (dzdot0' + dzdot0'') H/2.
[[nodiscard]] double AlongError(const StereoConfiguration& c,
                                const StereoErrors& errors,
                                Signs signs);

/// Across-track error [m], Leberl (1979), Eq. 14: illegible in our copy, derived in
/// docs/theory/leberl.md from the two range spheres,
///     dy = dy0' y/B - dy0'' (y - B)/B - (dz0' - dz0'') H/B + dr' r'/B - dr'' r''/B
[[nodiscard]] double AcrossError(const StereoConfiguration& c, const StereoErrors& errors);

/// Height error [m], Leberl (1979), Eq. 15:
///     dz = (dy0' - dy0'') y (y - B)/(H B) - dz0' (y - B)/B + dz0'' y/B
///          + dr' r' (y - B)/(B H) - dr'' r'' y/(B H)
[[nodiscard]] double HeightError(const StereoConfiguration& c, const StereoErrors& errors);

/// Eq. 13, 14 and 15 together.
[[nodiscard]] PointError PointErrors(const StereoConfiguration& c,
                                     const StereoErrors& errors,
                                     Signs signs);

}  // namespace sarblock::leberl
