// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"

#include <string_view>

#include <Eigen/Core>

/// Delays contained in a measured range and time, and motion of points with the Earth. Formulas
/// with their sources: docs/theory/reductions.md.
namespace sarblock {

/// Delay of a vertical ray from a height above the ellipsoid to space in the mean atmosphere of the
/// Earth [m], after Jehle et al. (2008), Sensors 8, 8479. Their polynomial is followed to 6 km, an
/// exponential with its value and slope from there on: within 0.025 m of what the pressure of the
/// standard atmosphere (ISO 2533) gives, and towards 0. Below -1 km the delay is that at -1 km.
[[nodiscard]] double ZenithDelay_m(double height_m);

/// The same in the weather of a day, after Saastamoinen (1972) with the gravity of Davis et al.
/// (1985). Pressure and temperature are carried from the weather's height to the point's by the
/// lapse of the standard atmosphere, 6.5 K/km to 11 km and none above; vapour decays with the
/// pressure (Askne and Nordius, 1987). Below -1 km the delay is that at -1 km. Throws as
/// Validate(weather) does.
[[nodiscard]] double ZenithDelay_m(const Weather& weather, double lat_rad, double height_m);

/// Group delay of a ray through free electrons [m]: 40.31 TEC/f^2, all of them in a shell at 450 km
/// that the ray crosses obliquely. `zenith_rad` is its angle from the vertical at the point. The
/// phase is advanced by as much. Throws as Validate(ionosphere) does.
[[nodiscard]] double IonosphericDelay_m(const Ionosphere& ionosphere,
                                        double wavelength_m,
                                        double zenith_rad);

/// Displacement of a point of the Earth (WGS84) by the solid Earth tide: east, north, up [m]. IERS
/// Conventions (2010), section 7.1.1: degrees 2 and 3, with what depends on latitude and frequency.
/// A position free of tides is the observed one less this ("conventional tide free"): the permanent
/// part is in it. Within 1 mm of the conventions' own program. Throws InputError ("utc") unless the
/// text is a time in UTC (`2022-10-16T01:50:44Z`) from 1972 to 2034.
[[nodiscard]] Eigen::Vector3d SolidEarthTide_m(const Geodetic& place, std::string_view utc);

/// Throw InputError naming the field, what it must be and the unit that was likely meant.
void Validate(const Weather& weather);
void Validate(const Ionosphere& ionosphere);

}  // namespace sarblock
