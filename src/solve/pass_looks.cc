// SPDX-License-Identifier: Apache-2.0
#include "pass_looks.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cstdint>

namespace sarblock {
namespace {

/// Of taking chance for a pass off its place, all passes together.
constexpr double kChance_1 = 0.05;
/// Least part of its looks that such a pass loses, and how much more often than the others: matches
/// of one image are worse than those of another.
constexpr double kLeastPart_1 = 0.2, kMoreOften_1 = 2.0;

}  // namespace

std::vector<PassLooks> CountPassLooks(const Block& block,
                                      const std::vector<std::uint8_t>& look_used) {
  const Looks& looks = block.looks;
  std::vector<PassLooks> by_pass(block.passes.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    std::size_t given = 0;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      given += looks.rejected(i) ? 0U : 1U;
    }
    if (given < 2) continue;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (looks.rejected(i)) continue;
      PassLooks& of_pass = by_pass[looks.pass[i]];
      const bool kept = look_used[i] != 0;
      ++(kept ? of_pass.all.kept : of_pass.all.lost);
      if (given > 2) ++(kept ? of_pass.deciding.kept : of_pass.deciding.lost);
    }
  }
  return by_pass;
}

std::optional<std::size_t> UndecidedPass(const std::vector<PassLooks>& by_pass) {
  for (std::size_t pass = 0; pass < by_pass.size(); ++pass) {
    if (!by_pass[pass].deciding.Decide()) return pass;
  }
  return std::nullopt;
}

std::optional<std::size_t> PassThatLosesMore(const std::vector<PassLooks>& by_pass) {
  LookCounts all;
  for (const PassLooks& of_pass : by_pass) {
    all.kept += of_pass.deciding.kept;
    all.lost += of_pass.deciding.lost;
  }
  const double level_1 = kChance_1 / static_cast<double>(std::max<std::size_t>(1, by_pass.size()));
  for (std::size_t pass = 0; pass < by_pass.size(); ++pass) {
    const LookCounts& own = by_pass[pass].deciding;
    const auto lost = static_cast<double>(own.lost), kept = static_cast<double>(own.kept);
    const double others_lost = static_cast<double>(all.lost) - lost;
    const double others_kept = static_cast<double>(all.kept) - kept;
    // One look more of each kind: a frequency of 0 is not known from any number of looks.
    const double frequency_1 = (others_lost + 1.0) / (others_lost + others_kept + 2.0);
    if (own.lost_1() < std::max(kLeastPart_1, kMoreOften_1 * frequency_1)) continue;
    const double odds = frequency_1 / (1.0 - frequency_1);
    // P(X >= l) of n = l + k binomial trials by the F distribution (Abramowitz and Stegun (1964),
    // 26.5.24 and 26.6.2).
    const double chance_1 =
        FisherTailProbability(lost / ((kept + 1.0) * odds), 2.0 * (kept + 1.0), 2.0 * lost);
    if (chance_1 < level_1) return pass;
  }
  return std::nullopt;
}

}  // namespace sarblock
