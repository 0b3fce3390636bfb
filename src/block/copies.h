// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <string>
#include <vector>

namespace sarblock {

/// Looks that stand in a block twice, as no two measurements do: times and ranges equal within
/// kEqual_1 of their standard deviations.
inline constexpr double kEqual_1 = 1e-3;
struct Copies {
  std::vector<std::string> remarks;   ///< a sentence a copied pass, and one of points
  std::vector<std::uint32_t> passes;  ///< copies of an earlier pass
  std::vector<std::size_t> looks;     ///< of these passes, equal to those of the earlier ones
  std::vector<std::uint32_t> points;  ///< copies of an earlier point
  [[nodiscard]] bool any() const { return !remarks.empty(); }
};

/// Passes of which half of the looks or more equal those of an earlier one.
[[nodiscard]] Copies FindCopiedPasses(const Block& block);
/// The same, and points all whose looks are those of another one: n log n in the looks.
[[nodiscard]] Copies FindCopies(const Block& block);

/// Rejects the looks that are copies, so that they count once.
void CountOnce(const Copies& copies, Block* block);

}  // namespace sarblock
