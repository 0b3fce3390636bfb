// SPDX-License-Identifier: Apache-2.0
#include "terminal.h"

#include <algorithm>

namespace sarblock::cli {
namespace {

constexpr std::size_t kHanging = 4;

std::size_t WidthOf(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // not the inside of a character
  }));
}

/// The line with its words from `begin` on broken at spaces, lines after the first indented by
/// `rest`.
void AppendBroken(std::string_view line, std::size_t begin, std::size_t rest, std::string* out) {
  out->append(line.substr(0, begin));
  const std::string_view words = line.substr(begin);
  std::size_t width = WidthOf(line.substr(0, begin));
  bool first = true;
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    const std::string_view word = words.substr(at, end - at);
    if (!first && width + 1 + WidthOf(word) > kColumns) {
      out->append("\n").append(rest, ' ');
      width = rest;
      first = true;
    }
    if (!first) {
      out->push_back(' ');
      ++width;
    }
    out->append(word);
    width += WidthOf(word);
    first = false;
    at = end + 1;
  }
}

std::size_t IndentOf(std::string_view line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

void AppendFitted(std::string_view line, std::string* out) {
  const std::size_t indent = IndentOf(line);
  if (WidthOf(line) <= kColumns || line.substr(indent).find("   ") != std::string_view::npos) {
    out->append(line);
  } else {
    AppendBroken(line, indent, indent + kHanging, out);
  }
}

void AppendFittedHelp(std::string_view line, std::string* out) {
  std::size_t begin = IndentOf(line);
  const std::size_t gap = line.find("  ", begin);
  if (gap != std::string_view::npos) begin = gap + IndentOf(line.substr(gap));
  if (WidthOf(line) <= kColumns) {
    out->append(line);
  } else {
    AppendBroken(line, begin, begin, out);
  }
}

std::string EachLine(std::string_view text, void (*append)(std::string_view, std::string*)) {
  std::string out;
  out.reserve(text.size() + text.size() / 16);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    append(text.substr(begin, end - begin), &out);
    if (end == std::string_view::npos) break;
    out.push_back('\n');
    begin = end + 1;
  }
  return out;
}

}  // namespace

std::string FitColumns(std::string_view text) { return EachLine(text, AppendFitted); }

std::string FitHelp(std::string_view text) { return EachLine(text, AppendFittedHelp); }

bool RemainingTime::IsStable(double spent_s) {
  constexpr double kMin_s = 3.0, kPart = 2.0 / 3.0, kSpread = 1.3;
  constexpr std::size_t kMin = 4;
  std::erase_if(whole_s_, [&](const auto& of) { return of.first < kPart * spent_s; });
  if (spent_s < kMin_s || whole_s_.size() < kMin) return false;
  const auto [least, most] =
      std::minmax_element(whole_s_.begin(), whole_s_.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  return most->second < kSpread * least->second;
}

std::optional<double> RemainingTime::Update(std::string_view stage,
                                            std::size_t done,
                                            std::size_t total,
                                            double now_s) {
  if (stage != stage_ || done < done_) {
    stage_ = stage;
    done_ = 0;
    begin_s_ = now_s;
    whole_s_.clear();
    shown_s_.reset();
  }
  if (done == 0 || done >= total) return std::nullopt;
  const double spent_s = now_s - begin_s_;
  const double part = static_cast<double>(done) / static_cast<double>(total);
  if (done > done_) whole_s_.emplace_back(spent_s, spent_s / part);
  done_ = done;
  const double left_s = spent_s / part - spent_s;
  if (!shown_s_) {
    if (!IsStable(spent_s)) return std::nullopt;
    shown_s_ = left_s;
  } else {
    constexpr double kWrong = 2.0, kStep = 1.25, kEnd_s = 2.0;
    const double expected_s = std::max(*shown_s_ - (now_s - shown_at_s_), kEnd_s);
    if (left_s > kWrong * expected_s || (expected_s > kEnd_s && left_s < expected_s / kWrong)) {
      shown_s_.reset();
      whole_s_.clear();
      return std::nullopt;
    }
    shown_s_ = std::clamp(left_s, expected_s / kStep, kStep * expected_s);
  }
  shown_at_s_ = now_s;
  return shown_s_;
}

}  // namespace sarblock::cli
