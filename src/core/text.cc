// SPDX-License-Identifier: Apache-2.0
#include "text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <system_error>

#include <fmt/compile.h>

namespace sarblock {
namespace {

template <typename... Values>
std::string Print(const char* format, Values... values) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

}  // namespace

std::string Digits(double value, int digits) { return Print("%.*g", digits, value); }

std::string Mebibytes(double bytes) {
  const double mib = bytes / 1048576.0;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), mib < 10.0 ? "%.1f" : "%.0f", mib);
  return text.data();
}

std::string ValueWithSigma(double value, double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(value) || !std::isfinite(sigma)) return Digits(value, 6);
  const int second_digit = static_cast<int>(std::floor(std::log10(sigma))) - 1;
  const double larger = std::max(std::abs(value), sigma);
  constexpr int kDecimals = 7, kMaxDecimals = 12;
  constexpr double kSmall = 1e-3, kLarge = 1e9;
  const int decimals = std::max(0, -second_digit);
  if (decimals <= (larger < kSmall ? kDecimals : kMaxDecimals) && larger < kLarge) {
    const double unit = std::pow(10.0, second_digit);
    const auto rounded = [&](double x) { return decimals > 0 ? x : unit * std::round(x / unit); };
    return Print("%.*f +- %.*f", decimals, rounded(value), decimals, rounded(sigma));
  }
  const int digits = static_cast<int>(std::floor(std::log10(larger))) - second_digit;
  return Print("%.*e +- %.1e", std::clamp(digits, 1, 16), value, sigma);
}

const char* ParseNumber(std::string_view text, double* value) {
  const char* begin = text.data();
  const char* const end = begin + text.size();
  // from_chars takes no plus sign; one is fine, "+-1" is not.
  if (text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, *value);
  if (error == std::errc::result_out_of_range) {
    return "a number of magnitude 1e-307 to 1e308 (or 0)";
  }
  if (error != std::errc() || stop != end) {
    return "a decimal number with a point";
  }
  return std::isfinite(*value) ? nullptr : "a finite number";
}

const char* ProblemOfPositive(double value) {
  if (!(value > 0.0)) return "a number above 0";
  const bool squares = value <= kLargestNumber && value >= 1.0 / kLargestNumber;
  return squares ? nullptr : "a number from 1e-60 to 1e60";
}

std::string MustBe(std::string_view allowed, std::string_view got) {
  return "must be " + std::string(allowed) + ", got " + std::string(got);
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
  // Both libraries write the fewest digits that read back, and these numbers without an exponent;
  // {fmt} is the faster.
  const double size = std::abs(value);
  if (size >= 1e-3 && size < 1e15 && value != std::trunc(value)) {
    text->append(digits.data(), fmt::format_to(digits.data(), FMT_COMPILE("{}"), value));
    return;
  }
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  static_cast<void>(error);  // cannot fail with 32 characters
  text->append(digits.data(), end);
}

std::string NumberText(double value) {
  std::string text;
  AppendNumber(value, &text);
  return text;
}

double ToUnit(double value, double factor) {
  double best = value / factor;
  double candidate = std::nextafter(std::nextafter(best, -HUGE_VAL), -HUGE_VAL);
  for (int i = 0; i < 5; ++i, candidate = std::nextafter(candidate, HUGE_VAL)) {
    if (candidate * factor == value && best * factor != value) best = candidate;
  }
  return best;
}

std::string ListNames(const std::vector<std::string>& names, std::size_t all, std::size_t shown) {
  if (names.size() > 1 && names.size() == all) return "all passes";
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), shown); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > shown) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

std::string XmlText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return out;
}

}  // namespace sarblock
