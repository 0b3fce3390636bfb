// SPDX-License-Identifier: Apache-2.0
#include "columns.h"

#include <algorithm>

namespace sarblock::cli {
namespace {

constexpr std::size_t kHanging = 4;

std::size_t WidthOf(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // not the inside of a character
  }));
}

void AppendFitted(std::string_view line, std::string* out) {
  const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
  const std::string_view words = line.substr(indent);
  if (WidthOf(line) <= kColumns || words.find("   ") != std::string_view::npos) {
    out->append(line);
    return;
  }
  out->append(indent, ' ');
  std::size_t width = indent;
  bool first = true;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find(' ', begin), words.size());
    const std::string_view word = words.substr(begin, end - begin);
    if (!first && width + 1 + WidthOf(word) > kColumns) {
      out->append("\n").append(indent + kHanging, ' ');
      width = indent + kHanging;
      first = true;
    }
    if (!first) {
      out->push_back(' ');
      ++width;
    }
    out->append(word);
    width += WidthOf(word);
    first = false;
    begin = end + 1;
  }
}

}  // namespace

std::string FitColumns(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 16);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    AppendFitted(text.substr(begin, end - begin), &out);
    if (end == std::string_view::npos) break;
    out.push_back('\n');
    begin = end + 1;
  }
  return out;
}

}  // namespace sarblock::cli
