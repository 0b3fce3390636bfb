// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// So many significant digits, without trailing zeros: Digits(0.1234, 2) is "0.12".
[[nodiscard]] std::string Digits(double value, int digits);

/// Bytes in MiB without the unit: "9.8", "120".
[[nodiscard]] std::string Mebibytes(double bytes);

/// A value and its standard deviation, both rounded to the second digit of the latter: "-0.99978
/// +- 0.00031", "1234570 +- 120"; as powers of ten where a billion and more or very small. Without
/// a standard deviation above 0: six digits of the value alone.
[[nodiscard]] std::string ValueWithSigma(double value, double sigma);

/// Reads all of `text` as a finite decimal number. Returns null, or what it must be (MustBe()).
[[nodiscard]] const char* ParseNumber(std::string_view text, double* value);

/// "must be ALLOWED, got GOT".
[[nodiscard]] std::string MustBe(std::string_view allowed, std::string_view got);

/// Text of a file as it appears in a message: in quotes, shortened, control characters as `?`.
[[nodiscard]] std::string Quoted(std::string_view text);

/// Shortest decimal that reads back to the same double ("nan" and "inf" as such), appended.
void AppendNumber(double value, std::string* text);
[[nodiscard]] std::string NumberText(double value);

/// A number x with x * factor == value where one exists near value / factor, so that a unit
/// converted for a file comes back to the same double.
[[nodiscard]] double ToUnit(double value, double factor);
/// Magnitudes within which squares, their inverses and the products of two variances are finite.
inline constexpr double kLargestNumber = 1e60;
/// What a standard deviation or another positive number must be (MustBe()); null if it is so.
[[nodiscard]] const char* ProblemOfPositive(double value);

inline constexpr std::uint64_t kFnv1aStart = 0xcbf29ce484222325u;

/// FNV-1a, 64 bits (Fowler, Noll and Vo): detects damaged or exchanged data, not forged data.
/// `state` is the value of the bytes before.
[[nodiscard]] inline std::uint64_t Fnv1a(std::span<const std::byte> bytes,
                                         std::uint64_t state = kFnv1aStart) {
  for (const std::byte byte : bytes) {
    state ^= static_cast<std::uint64_t>(byte);
    state *= 0x100000001b3u;
  }
  return state;
}
[[nodiscard]] inline std::uint64_t Fnv1a(std::string_view text, std::uint64_t state = kFnv1aStart) {
  return Fnv1a(std::as_bytes(std::span(text)), state);
}

/// "A1, A2, A3 and 5 more", "all passes" where `names` are all of them and more than one.
[[nodiscard]] std::string ListNames(const std::vector<std::string>& names,
                                    std::size_t all = 0,
                                    std::size_t shown = 4);

/// Text for XML: & < > " escaped, control characters as spaces.
[[nodiscard]] std::string XmlText(std::string_view text);

}  // namespace sarblock
