// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Looks of a pass that take part, and those that were left out.
struct LookCounts {
  std::size_t kept = 0, lost = 0;

  /// Part that was left out; 0 of none.
  [[nodiscard]] double lost_1() const {
    return lost == 0 ? 0.0 : static_cast<double>(lost) / static_cast<double>(kept + lost);
  }
  /// As many for a path as against it decide nothing.
  [[nodiscard]] bool Decide() const { return lost < 2 || lost < kept; }
};

/// Of one pass, at points of two looks and more. `deciding` are those at points of three looks and
/// more: two looks meet nearly always, wherever their paths are, and speak for none.
struct PassLooks {
  LookCounts all, deciding;
};

/// By pass, of the looks that take part by `look_used` (AdjustmentProblem) and all others. A look
/// that the block rejects is not counted.
[[nodiscard]] std::vector<PassLooks> CountPassLooks(const Block& block,
                                                    const std::vector<std::uint8_t>& look_used);

/// The first pass whose deciding looks decide nothing.
[[nodiscard]] std::optional<std::size_t> UndecidedPass(const std::vector<PassLooks>& by_pass);

/// The first pass that lost more of its deciding looks than chance explains: a pass that settled
/// off its place loses good ones. It lost a fifth of them at least and twice as many as the others,
/// and the chance of so many is below 0.05, all passes together; the number lost is held against a
/// binomial distribution with the frequency of the other passes (docs/theory/consensus.md, eq.
/// (4)).
[[nodiscard]] std::optional<std::size_t> PassThatLosesMore(const std::vector<PassLooks>& by_pass);

}  // namespace sarblock
