// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sarblock {

/// Reads all of `text` as a finite decimal number. Returns null, or what is wrong as the rest of a
/// sentence that begins with the text.
[[nodiscard]] const char* ParseNumber(std::string_view text, double* value);

/// Text of a file as it appears in a message: in quotes, shortened, control characters as `?`.
[[nodiscard]] std::string Quoted(std::string_view text);

/// Shortest decimal that reads back to the same double ("nan" and "inf" as such), appended.
void AppendNumber(double value, std::string* text);
[[nodiscard]] std::string NumberText(double value);

/// A number x with x * factor == value where one exists near value / factor, so that a unit
/// converted for a file comes back to the same double.
[[nodiscard]] double InUnit(double value, double factor);
/// Magnitudes within which squares, their inverses and the products of two variances are finite.
inline constexpr double kLargestNumber = 1e60;
/// What is wrong with a standard deviation or another number that must be above 0; null: nothing.
[[nodiscard]] const char* ProblemOfPositive(double value);

}  // namespace sarblock
