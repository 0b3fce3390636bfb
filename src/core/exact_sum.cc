// SPDX-License-Identifier: Apache-2.0
#include "exact_sum.h"

#include <algorithm>

namespace sarblock {

bool ExactSum::HasTerms(std::uint32_t count) const {
  const Units most = static_cast<Units>(kMost_1 / kUnit_1) * count;
  return -most <= units_ && units_ <= most;
}

std::string ExactSum::Text() const {
  std::string text;
  Units left = units_;
  do {
    const auto digit = static_cast<int>(left % 10);
    text += static_cast<char>('0' + (digit < 0 ? -digit : digit));
    left /= 10;
  } while (left != 0);
  if (units_ < 0) text += '-';
  std::reverse(text.begin(), text.end());
  return text;
}

std::optional<ExactSum> ExactSum::FromText(std::string_view text) {
  constexpr std::size_t kMostDigits = 38;  // below 2^127
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  if (text.empty() || text.size() > kMostDigits) return std::nullopt;
  ExactSum sum;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    sum.units_ = 10 * sum.units_ + (c - '0');
  }
  if (negative) sum.units_ = -sum.units_;
  return sum;
}

}  // namespace sarblock
