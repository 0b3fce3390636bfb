// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sarblock {

/// A sum that does not depend on the order of its terms, nor on how they are divided into sums that
/// are added later: each term is taken to the nearest smaller multiple of kUnit_1 in magnitude, an
/// integer of 128 bits holds their sum. A term of 2^-8 or more loses nothing. It is for terms near
/// 1: what lies beyond kMost_1 in magnitude counts as kMost_1 with its sign, what is no number as
/// kMost_1. 2^31 terms fit.
class ExactSum {
 public:
  static constexpr double kUnit_1 = 0x1p-60;
  static constexpr double kMost_1 = 0x1p35;

  void Add(double term_1) {
    if (!(term_1 < kMost_1)) term_1 = kMost_1;
    if (term_1 < -kMost_1) term_1 = -kMost_1;
    units_ += static_cast<Units>(term_1 / kUnit_1);
  }
  void Add(const ExactSum& other) { units_ += other.units_; }
  /// The sum, to the nearest double.
  [[nodiscard]] double Value() const { return static_cast<double>(units_) * kUnit_1; }
  /// Whether so many terms can have this sum.
  [[nodiscard]] bool HasTerms(std::uint32_t count) const;

  /// The units as decimal digits, and back; nothing for a text that is no integer of at most 38
  /// digits.
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] static std::optional<ExactSum> FromText(std::string_view text);

  bool operator==(const ExactSum&) const = default;

 private:
  __extension__ using Units = __int128;
  Units units_ = 0;
};

}  // namespace sarblock
