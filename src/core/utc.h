// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sarblock {

/// An instant given in UTC, kept without its leaps: whole seconds of TAI and a fraction, so that
/// differences are exact to the last given digit.
struct UtcTime {
  std::int64_t tai_whole = 0;  ///< seconds of TAI since 1970-01-01T00:00:00 TAI
  double fraction_s = 0.0;     ///< [0, 1)
};

/// Reads `2022-10-16T01:50:44.577283`, with `UTC=` before or `Z` behind it or not; nothing where
/// the text is no time from 1972 on. A second 60 is read where there was one. Leap seconds are
/// those of IERS Bulletin C up to 2017-01-01, the last one until at least 2026.
[[nodiscard]] std::optional<UtcTime> ParseUtc(std::string_view text);

/// Elapsed SI seconds; leap seconds between the two count.
[[nodiscard]] double SecondsBetween(const UtcTime& from, const UtcTime& to);

/// Whole seconds of TAI less UTC; within a leap second those before it.
[[nodiscard]] int TaiMinusUtc_s(const UtcTime& time);

/// Years of 365.25 days, 2000.0 at 2000-01-01T12:00:00, as epochs of reference frames are counted.
[[nodiscard]] double JulianYear(const UtcTime& time);

/// The time of such a year, to a microsecond.
[[nodiscard]] UtcTime TimeOfJulianYear(double year);

/// The whole second at or before a time.
[[nodiscard]] UtcTime WholeSecond(const UtcTime& time);

/// A time some SI seconds later (or earlier), to the last digit of the fraction.
[[nodiscard]] UtcTime AddSeconds(const UtcTime& time, double seconds_s);

/// The nearest whole microsecond, the resolution of Sentinel-1's orbit files.
[[nodiscard]] UtcTime WholeMicrosecond(const UtcTime& time);

/// `2022-10-16T01:50:44Z`; the fraction is left out.
[[nodiscard]] std::string UtcText(const UtcTime& time);

/// `2022-10-16T01:50:44.577283` of a time in whole microseconds, in UTC and in TAI.
[[nodiscard]] std::string UtcMicroseconds(const UtcTime& time);
[[nodiscard]] std::string TaiMicroseconds(const UtcTime& time);

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
