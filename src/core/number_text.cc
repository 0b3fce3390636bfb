// SPDX-License-Identifier: Apache-2.0
#include "number_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

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

std::string ValueWithSigma(double value, double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(value) || !std::isfinite(sigma)) return Digits(value, 6);
  const int second_digit = static_cast<int>(std::floor(std::log10(sigma))) - 1;
  const double larger = std::max(std::abs(value), sigma);
  constexpr int kDecimals = 7, kMostDecimals = 12;
  constexpr double kSmall = 1e-3, kLarge = 1e9;
  const int decimals = std::max(0, -second_digit);
  if (decimals <= (larger < kSmall ? kDecimals : kMostDecimals) && larger < kLarge) {
    const double unit = std::pow(10.0, second_digit);
    const auto rounded = [&](double x) { return decimals > 0 ? x : unit * std::round(x / unit); };
    return Print("%.*f +- %.*f", decimals, rounded(value), decimals, rounded(sigma));
  }
  const int digits = static_cast<int>(std::floor(std::log10(larger))) - second_digit;
  return Print("%.*e +- %.1e", std::clamp(digits, 1, 16), value, sigma);
}

}  // namespace sarblock
