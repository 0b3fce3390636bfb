// SPDX-License-Identifier: Apache-2.0
#include "number.h"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace sarblock {

const char* ParseNumber(std::string_view text, double* value) {
  const char* begin = text.data();
  const char* const end = begin + text.size();
  // from_chars takes no plus sign; one is fine, "+-1" is not.
  if (text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, *value);
  if (error == std::errc::result_out_of_range) {
    return " is out of range, a number of magnitude 1e-307 to 1e308 (or 0) is allowed";
  }
  if (error != std::errc() || stop != end) {
    return " is not a number, a decimal number with a point is allowed";
  }
  return std::isfinite(*value) ? nullptr : " is not allowed, a finite number is";
}

const char* ProblemOfPositive(double value) {
  if (!(value > 0.0)) return " is not allowed, a number above 0 is";
  const bool squares = value <= kLargestNumber && value >= 1.0 / kLargestNumber;
  return squares ? nullptr : " is not allowed, a number from 1e-60 to 1e60 is";
}

std::string Quoted(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string quoted = "'";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    quoted += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  return quoted + (text.size() > kLongest ? "...'" : "'");
}

void AppendNumber(double value, std::string* text) {
  std::array<char, 32> digits;  // the longest shortest form has 24 characters
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  static_cast<void>(error);  // cannot fail with 32 characters
  text->append(digits.data(), end);
}

std::string NumberText(double value) {
  std::string text;
  AppendNumber(value, &text);
  return text;
}

double InUnit(double value, double factor) {
  double best = value / factor;
  double candidate = std::nextafter(std::nextafter(best, -HUGE_VAL), -HUGE_VAL);
  for (int i = 0; i < 5; ++i, candidate = std::nextafter(candidate, HUGE_VAL)) {
    if (candidate * factor == value && best * factor != value) best = candidate;
  }
  return best;
}

}  // namespace sarblock
