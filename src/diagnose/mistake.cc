// SPDX-License-Identifier: Apache-2.0
#include "mistake.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/text.h"

namespace sarblock {
namespace {

template <typename... Values>
std::string Print(const char* format, Values... values) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string Joined(const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kNamed); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  if (names.size() > kNamed) text += " and " + std::to_string(names.size() - kNamed) + " more";
  return text;
}

/// Never 100 % unless nothing is left.
std::string Percent(double part) {
  return Print("%.2f", std::min(99.99, 100.0 * std::max(0.0, part))) + " %";
}

}  // namespace

std::string Short(double value) { return Digits(value, 4); }

std::string InFiles(double value, double sigma) {
  constexpr int kFewest = 4, kExact = 10, kMost = 16;
  if (!(sigma > 0.0) || !std::isfinite(sigma) || value == 0.0) return Digits(value, kExact);
  const auto order = [](double x) { return static_cast<int>(std::floor(std::log10(std::abs(x)))); };
  return Digits(value, std::clamp(order(value) - order(sigma) + 2, kFewest, kMost));
}

Size SizeOf(double value, double sigma, const std::string& unit) {
  const bool none = unit.empty() || unit == "1";
  return {value, sigma, ValueWithSigma(value, sigma) + (none ? "" : " " + unit)};
}

std::string Equals(const std::vector<KnownNumber>& numbers, double value, double sigma) {
  const double tolerance = std::max(sigma > 0.0 ? 4.0 * sigma : 0.0, 1e-3 * std::abs(value));
  if (!(tolerance < 0.1 * std::abs(value))) return "";
  const KnownNumber* nearest = nullptr;
  for (const KnownNumber& number : numbers) {
    const double off = std::abs(value - number.value);
    if (off > tolerance) continue;
    if (nearest == nullptr || off < std::abs(value - nearest->value)) nearest = &number;
  }
  return nearest == nullptr ? "" : nearest->text;
}

std::string PassWords(const std::vector<std::string>& passes) {
  if (passes.empty()) return "all passes";
  return (passes.size() == 1 ? "pass " : "passes ") + Joined(passes);
}

std::string PassesPhrase(const std::vector<std::string>& passes) {
  return "of " + (passes.empty() ? std::string("all passes") : Joined(passes));
}

std::string SentenceOf(const Hypothesis& hypothesis,
                       const Size& size,
                       const std::string& detail,
                       const Explanation& explanation) {
  std::string text = hypothesis.says(size);
  if (!explanation.equals.empty()) text += " (" + explanation.equals + ")";
  if (!detail.empty()) text += ", " + detail;
  if (hypothesis.kind != MistakeKind::kSigma || explanation.part > 0.0) {
    text += ": takes " + Percent(explanation.part) + " of v'Pv";
  }
  if (explanation.looks_lost_before > explanation.looks_lost_after) {
    text += Print(" and finds a place for %zu looks",
                  explanation.looks_lost_before - explanation.looks_lost_after);
  }
  const double left = explanation.square_sum_after / explanation.redundancy_after;
  if (left > 2.0 || explanation.looks_lost_after > 0) {
    text += " but does not explain all (v'Pv over redundancy " + Short(left) + " is left)";
  }
  const Explanation::Cure& cure = explanation.cure;
  if (cure.tried) {
    text += cure.cures ? "; with it the whole block is sound: s0^2 of looks and control "
                       : "; of the whole block it is a part: s0^2 of looks and control ";
    text += Short(cure.factor) + " (" + Short(cure.lower) + " to " + Short(cure.upper) +
            " is expected)";
    if (std::isfinite(cure.priors_factor)) text += ", of priors " + Short(cure.priors_factor);
  }
  return text + "; " + explanation.change;
}

}  // namespace sarblock
