// SPDX-License-Identifier: Apache-2.0
#include "plants_ids.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "plants_draw.h"

namespace sarblock::test {
namespace {

std::optional<std::size_t> LookOf(const Block& block, std::uint32_t point, std::uint32_t pass) {
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.pass[i] == pass) return i;
  }
  return std::nullopt;
}

Planted ExchangedPoints(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const std::uint32_t a = DrawPoint(*block, random), b = DrawPoint(*block, random);
    const auto i = LookOf(*block, a, pass), j = LookOf(*block, b, pass);
    if (a == b || !i || !j) continue;
    SwapValues(*i, *j, &block->looks);
    const auto [low, high] = std::minmax(a, b);
    // With two looks and no known position the other pass may as well be said.
    const auto tie = [&](std::uint32_t point) {
      return block->points.FindKnown(point) == nullptr &&
             block->looks.offsets[point + 1] - block->looks.offsets[point] == 2;
    };
    const bool either = tie(a) && tie(b);
    return {true,
            {"ids.exchanged"},
            either ? std::vector<std::string>{} : std::vector<std::string>{block->passes[pass].id},
            {std::string(block->points.ids[low]), std::string(block->points.ids[high])},
            ""};
  }
  return {};
}

Planted ShiftedIds(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  std::vector<std::size_t> rows;
  EditLooks(block, pass, [&](std::size_t i) { rows.push_back(i); });
  if (random->Uniform() < 0.5) std::reverse(rows.begin(), rows.end());
  for (std::size_t k = 1; k < rows.size(); ++k) SwapValues(rows[k - 1], rows[k], &block->looks);
  return PlantInPass(*block, pass, "ids.shifted");
}

Planted CopiedPass(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  AppendPassCopy(pass, block);
  return {true, {"copy"}, {}, {}, "one is a copy"};
}

Planted CopiedPoint(Block* block, RandomStream* random) {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const auto point =
        static_cast<std::uint32_t>(random->Uniform() * static_cast<double>(block->points.size()));
    if (block->looks.offsets[point + 1] - block->looks.offsets[point] < 2) continue;
    AppendPointCopy(point, block);
    return {true, {"copy"}, {}, {}, "same point under two ids"};
  }
  return {};
}

}  // namespace

std::vector<Plant> IdPlants() {
  return {{"two points exchanged in a pass", ExchangedPoints},
          {"ids shifted by one row", ShiftedIds},
          {"the same images twice", CopiedPass},
          {"a point under two ids", CopiedPoint}};
}

}  // namespace sarblock::test
