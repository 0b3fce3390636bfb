// SPDX-License-Identifier: Apache-2.0
#include "utc.h"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace sarblock {
namespace {

constexpr std::int64_t kDay_s = 86400;

struct Leap {
  int year;
  unsigned month;  // of its first day on
  int tai_minus_utc_s;
};
// IERS Bulletin C, 1972 to 2017.
constexpr std::array<Leap, 28> kLeaps{
    {{1972, 1, 10}, {1972, 7, 11}, {1973, 1, 12}, {1974, 1, 13}, {1975, 1, 14}, {1976, 1, 15},
     {1977, 1, 16}, {1978, 1, 17}, {1979, 1, 18}, {1980, 1, 19}, {1981, 7, 20}, {1982, 7, 21},
     {1983, 7, 22}, {1985, 7, 23}, {1988, 1, 24}, {1990, 1, 25}, {1991, 1, 26}, {1992, 7, 27},
     {1993, 7, 28}, {1994, 7, 29}, {1996, 1, 30}, {1997, 7, 31}, {1999, 1, 32}, {2006, 1, 33},
     {2009, 1, 34}, {2012, 7, 35}, {2015, 7, 36}, {2017, 1, 37}}};

std::int64_t DaysSince1970(std::chrono::year_month_day date) {
  return std::chrono::sys_days(date).time_since_epoch().count();
}

std::int64_t StartDay(const Leap& leap) {
  return DaysSince1970(std::chrono::year(leap.year) / std::chrono::month(leap.month) / 1);
}

// TAI - UTC on a day, or nothing before 1972.
std::optional<std::int64_t> Offset_s(std::int64_t day) {
  for (auto leap = kLeaps.rbegin(); leap != kLeaps.rend(); ++leap) {
    if (day >= StartDay(*leap)) return leap->tai_minus_utc_s;
  }
  return std::nullopt;
}

// Reads `digits` digits at the front of the text and the character behind them.
bool TakeDigits(std::string_view* text, std::size_t digits, char behind, int* value) {
  if (text->size() < digits) return false;
  const char* const end = text->data() + digits;
  if (text->front() < '0' || text->front() > '9') return false;
  const auto [stop, error] = std::from_chars(text->data(), end, *value);
  if (error != std::errc() || stop != end) return false;
  text->remove_prefix(digits);
  if (behind == '\0') return true;
  if (text->empty() || text->front() != behind) return false;
  text->remove_prefix(1);
  return true;
}

bool TakeFraction(std::string_view text, double* fraction_s) {
  *fraction_s = 0.0;
  if (text.empty()) return true;
  if (text.size() < 2 || text.front() != '.' || text[1] < '0' || text[1] > '9') return false;
  const char* const end = text.data() + text.size();
  const auto [stop, error] =
      std::from_chars(text.data(), end, *fraction_s, std::chars_format::fixed);
  return error == std::errc() && stop == end && *fraction_s < 1.0;
}

}  // namespace

std::optional<UtcTime> ParseUtc(std::string_view text) {
  if (text.starts_with("UTC=")) text.remove_prefix(4);
  if (text.ends_with('Z')) text.remove_suffix(1);
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  UtcTime time;
  if (!TakeDigits(&text, 4, '-', &year) || !TakeDigits(&text, 2, '-', &month) ||
      !TakeDigits(&text, 2, 'T', &day) || !TakeDigits(&text, 2, ':', &hour) ||
      !TakeDigits(&text, 2, ':', &minute) || !TakeDigits(&text, 2, '\0', &second) ||
      !TakeFraction(text, &time.fraction_s)) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date(std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  if (!date.ok() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  const std::int64_t days = DaysSince1970(date);
  const auto offset_s = Offset_s(days);
  if (!offset_s) return std::nullopt;
  const bool leap_second = second == 60;
  if (leap_second && (hour != 23 || minute != 59 || Offset_s(days + 1) == offset_s)) {
    return std::nullopt;
  }
  time.tai_whole = days * kDay_s + hour * 3600 + minute * 60 + second + *offset_s;
  return time;
}

double SecondsBetween(const UtcTime& from, const UtcTime& to) {
  return static_cast<double>(to.tai_whole - from.tai_whole) + (to.fraction_s - from.fraction_s);
}

int TaiMinusUtc_s(const UtcTime& time) {
  int offset_s = kLeaps.front().tai_minus_utc_s;
  for (const Leap& leap : kLeaps) {
    if (time.tai_whole - leap.tai_minus_utc_s >= StartDay(leap) * kDay_s) {
      offset_s = leap.tai_minus_utc_s;
    }
  }
  return offset_s;
}

UtcTime WholeSecond(const UtcTime& time) { return {time.tai_whole, 0.0}; }

namespace {

// `YYYY-MM-DDTHH:MM:SS` of seconds since 1970-01-01; `extra_s` is the leap second on top.
std::string CalendarText(std::int64_t since_1970_s, std::int64_t extra_s) {
  const std::int64_t day =
      since_1970_s >= 0 ? since_1970_s / kDay_s : (since_1970_s - kDay_s + 1) / kDay_s;
  const std::int64_t rest_s = since_1970_s - day * kDay_s;
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(day))};
  std::array<char, 96> text;
  std::snprintf(text.data(),
                text.size(),
                "%04d-%02u-%02uT%02d:%02d:%02d",
                static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()),
                static_cast<int>(rest_s / 3600),
                static_cast<int>(rest_s / 60 % 60),
                static_cast<int>(rest_s % 60 + extra_s));
  return text.data();
}

std::string WholeUtcText(const UtcTime& time) {
  std::int64_t utc_s = time.tai_whole - kLeaps.front().tai_minus_utc_s;
  std::int64_t extra_s = 0;
  for (const Leap& leap : kLeaps) {
    const std::int64_t start_s = StartDay(leap) * kDay_s;
    if (time.tai_whole - leap.tai_minus_utc_s >= start_s) {
      utc_s = time.tai_whole - leap.tai_minus_utc_s;
    } else if (&leap != &kLeaps.front() && time.tai_whole - leap.tai_minus_utc_s == start_s - 1) {
      utc_s = start_s - 1;  // the leap second itself is 23:59:60
      extra_s = 1;
    }
  }
  return CalendarText(utc_s, extra_s);
}

std::string FractionText(const UtcTime& time) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), ".%06ld", std::lround(time.fraction_s * 1e6));
  return text.data();
}

}  // namespace

UtcTime AddSeconds(const UtcTime& time, double seconds_s) {
  const double whole_s = std::floor(seconds_s);
  UtcTime sum{time.tai_whole + static_cast<std::int64_t>(whole_s),
              time.fraction_s + (seconds_s - whole_s)};
  if (sum.fraction_s >= 1.0) {
    sum.fraction_s -= 1.0;
    ++sum.tai_whole;
  }
  return sum;
}

UtcTime WholeMicrosecond(const UtcTime& time) {
  const double microseconds = std::round(time.fraction_s * 1e6);
  if (microseconds >= 1e6) return {time.tai_whole + 1, 0.0};
  return {time.tai_whole, microseconds / 1e6};
}

std::string UtcText(const UtcTime& time) { return WholeUtcText(time) + "Z"; }

std::string UtcMicroseconds(const UtcTime& time) { return WholeUtcText(time) + FractionText(time); }

std::string TaiMicroseconds(const UtcTime& time) {
  return CalendarText(time.tai_whole, 0) + FractionText(time);
}

namespace {

constexpr std::int64_t kNoonOf2000 = 946'728'000;  // 2000-01-01T12:00:00 from 1970-01-01
constexpr double kTerrestrialMinusTai_s = 32.184;

double BarycentricMinusTerrestrial_s(double terrestrial_s) {
  constexpr double kAmplitude_s = 1.657e-3, kEccentricity = 1.671e-2;
  constexpr double kAnomaly_rad = 6.239996, kAnomalyRate_rad_per_s = 1.99096871e-7;
  const double mean_rad = kAnomaly_rad + kAnomalyRate_rad_per_s * terrestrial_s;
  return kAmplitude_s * std::sin(mean_rad + kEccentricity * std::sin(mean_rad));
}

}  // namespace

namespace {

constexpr double kJulianYear_s = 365.25 * static_cast<double>(kDay_s);

}  // namespace

double JulianYear(const UtcTime& time) {
  return 2000.0 + SecondsBetween({kNoonOf2000, 0.0}, time) / kJulianYear_s;
}

UtcTime TimeOfJulianYear(double year) {
  return AddSeconds({kNoonOf2000, 0.0}, (year - 2000.0) * kJulianYear_s);
}

double EphemerisTime_s(const UtcTime& time) {
  const double terrestrial_s = static_cast<double>(time.tai_whole - kNoonOf2000) +
                               (time.fraction_s + kTerrestrialMinusTai_s);
  return terrestrial_s + BarycentricMinusTerrestrial_s(terrestrial_s);
}

UtcTime UtcOfEphemerisTime(double ephemeris_time_s) {
  // The difference changes by 3e-10 a second: one step is enough.
  const double terrestrial_s = ephemeris_time_s - BarycentricMinusTerrestrial_s(ephemeris_time_s);
  return AddSeconds({kNoonOf2000, 0.0}, terrestrial_s - kTerrestrialMinusTai_s);
}

}  // namespace sarblock
