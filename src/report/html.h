// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sarblock {

/// Text as it may stand between tags and in quoted attributes: & < > " ' become references, control
/// characters other than tab and newline the replacement character, and so does what is not UTF-8.
[[nodiscard]] std::string EscapeHtml(std::string_view text);

/// JSON as it may stand inside a script element: < > & and the two line separators that a script
/// would take for line ends become \u escapes. They occur in strings only, so the value is the
/// same.
[[nodiscard]] std::string EscapeScriptJson(std::string_view json);

/// A number for people with `digits` significant digits and without an exponent between 1e-5 and
/// 1e9; "-" for NaN. A thin space parts thousands from five digits before the point on.
[[nodiscard]] std::string ReadableNumber(double value, int digits = 4);

/// A count with thin spaces between groups of three from five digits on.
[[nodiscard]] std::string ReadableCount(double count_1);
[[nodiscard]] inline std::string ReadableCount(std::size_t count) {
  return ReadableCount(static_cast<double>(count));
}

}  // namespace sarblock
