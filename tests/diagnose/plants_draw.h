// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/statistics.h"

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plants.h"
#include "plants_edit.h"

namespace sarblock::test {

inline constexpr double kRadOfDeg = std::numbers::pi / 180.0;

[[nodiscard]] std::uint32_t DrawPass(const Block& block, RandomStream* random);
[[nodiscard]] std::uint32_t DrawPoint(const Block& block, RandomStream* random);
[[nodiscard]] double DrawSign(RandomStream* random);
/// Logarithms equally likely.
[[nodiscard]] double DrawSize(double least, double most, RandomStream* random);
[[nodiscard]] double DrawOf(const std::vector<double>& values, RandomStream* random);

/// What is to be said: a cause of a pass, of all passes, of points.
[[nodiscard]] Planted PlantInPass(const Block& block, std::uint32_t pass, std::string cause);
[[nodiscard]] Planted PlantEverywhere(std::string cause);
[[nodiscard]] Planted PlantAtPoints(const Block& block,
                                    const std::vector<std::uint32_t>& points,
                                    std::string cause);

[[nodiscard]] double MeanRange(const Block& block);
/// Exchanges what two looks measured.
void SwapValues(std::size_t i, std::size_t j, Looks* looks);

template <typename Edit>
void EditLooks(Block* block, std::optional<std::uint32_t> pass, const Edit& edit) {
  for (std::size_t i = 0; i < block->looks.size(); ++i) {
    if (!pass || block->looks.pass[i] == *pass) edit(i);
  }
}

}  // namespace sarblock::test
