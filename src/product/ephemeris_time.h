// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "product/utc_time.h"

namespace sarblock {

/// Ephemeris time (barycentric dynamical time, TDB, seconds past J2000) of an instant, as the
/// toolkit SPICE computes it:
///
///     TT = TAI + 32.184 s,  TDB = TT + K sin E,  E = M + e sin M,  M = M0 + M1 TT
///
/// with the K, e, M0 and M1 of its leap second kernels. A double of it steps by 0.06 us today.
[[nodiscard]] double EphemerisTime_s(const UtcTime& time);

/// The inverse, to that step.
[[nodiscard]] UtcTime UtcOfEphemerisTime(double ephemeris_time_s);

}  // namespace sarblock
