// SPDX-License-Identifier: Apache-2.0
#include "html.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";
constexpr std::string_view kThinSpace = "\xe2\x80\xaf";  // narrow and not breaking

/// Bytes of the well-formed UTF-8 sequence at `at`; 0 where there is none.
std::size_t SequenceLength(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(at);
  if (lead < 0x80U) return 1;
  const std::size_t length = lead >= 0xf0U ? 4 : (lead >= 0xe0U ? 3 : 2);
  if (lead < 0xc2U || lead > 0xf4U || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0U) != 0x80U) return 0;
  }
  const unsigned second = byte(at + 1);
  const bool overlong = (lead == 0xe0U && second < 0xa0U) || (lead == 0xf0U && second < 0x90U);
  const bool surrogate = lead == 0xedU && second >= 0xa0U;
  const bool beyond = lead == 0xf4U && second >= 0x90U;
  return overlong || surrogate || beyond ? 0 : length;
}

std::string Grouped(const std::string& number) {
  const std::size_t start = number.find_first_of("0123456789");
  std::size_t end = number.find_first_not_of("0123456789", start);
  if (end == std::string::npos) end = number.size();
  if (start == std::string::npos || end - start < 5) return number;
  std::string out = number.substr(0, start);
  for (std::size_t i = start; i < end; ++i) {
    if (i > start && (end - i) % 3 == 0) out += kThinSpace;
    out += number[i];
  }
  return out + number.substr(end);
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = SequenceLength(text, i);
    const char c = text[i];
    if (length == 0 || (static_cast<unsigned char>(c) < 0x20U && c != '\t' && c != '\n') ||
        c == '\x7f') {
      out += kReplacement;
      ++i;
      continue;
    }
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
      case '\'':
        out += "&#39;";
        break;
      default:
        out += text.substr(i, length);
    }
    i += length;
  }
  return out;
}

std::string EscapeScriptJson(std::string_view json) {
  std::string out;
  out.reserve(json.size() + json.size() / 64);
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else if (json.substr(i, 3) == "\xe2\x80\xa8" || json.substr(i, 3) == "\xe2\x80\xa9") {
      out += json[i + 2] == '\xa8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else {
      out += c;
    }
  }
  return out;
}

std::string ReadableNumber(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  if (value == 0.0) return "0";
  const double size = std::abs(value);
  if (size < 1e-5 || size >= 1e9) return fmt::format("{:.{}e}", value, digits - 1);
  const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
  return Grouped(fmt::format("{:.{}f}", value, std::max(0, digits - before)));
}

std::string ReadableCount(double count) {
  return std::isnan(count) ? "-" : Grouped(fmt::format("{:.0f}", count));
}

}  // namespace sarblock
