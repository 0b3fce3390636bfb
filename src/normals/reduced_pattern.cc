// SPDX-License-Identifier: Apache-2.0
#include "reduced_pattern.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "point_blocks.h"

namespace sarblock {
namespace {

/// A point of more blocks than this may stand in the border.
constexpr std::size_t kMostEliminated = 512;
/// Points in the border: each costs a solution with three columns a factorisation.
constexpr std::size_t kMostBordered = 64;
/// Memory of the border's rows.
constexpr std::size_t kBorderBytes = std::size_t{128} << 20;
/// The border pays only where it leaves points of so many times fewer blocks.
constexpr std::size_t kGap = 2;

/// Pairs of blocks seen together: a word a block or a bit table while that is small, else a hash
/// set.
class PairSet {
 public:
  explicit PairSet(std::size_t blocks)
      : blocks_(blocks), words_(blocks <= 64 ? blocks : 0), dense_(blocks <= 16384) {
    if (dense_ && words_.empty()) bits_.assign(blocks * blocks, false);
  }
  /// All pairs of the blocks of a point, ascending.
  void AddPairs(const std::vector<int>& blocks) {
    if (!words_.empty()) {
      std::uint64_t seen = 0;
      for (const int block : blocks) {
        words_[static_cast<std::size_t>(block)] |= seen;
        seen |= std::uint64_t{1} << block;
      }
      return;
    }
    for (std::size_t a = 0; a < blocks.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) Add(blocks[a], blocks[b]);
    }
  }
  [[nodiscard]] std::vector<std::pair<int, int>> Pairs() {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if ((words_[i] >> j & 1U) == 0) continue;
        pairs_.emplace_back(static_cast<int>(i), static_cast<int>(j));
      }
    }
    return std::move(pairs_);
  }

 private:
  void Add(int i, int j) {
    const std::size_t key = static_cast<std::size_t>(i) * blocks_ + static_cast<std::size_t>(j);
    if (dense_) {
      if (bits_[key]) return;
      bits_[key] = true;
    } else if (!seen_.insert(key).second) {
      return;
    }
    pairs_.emplace_back(i, j);
  }

  std::size_t blocks_;
  std::vector<std::uint64_t> words_;  // by block, the earlier ones seen with it
  bool dense_;
  std::vector<bool> bits_;
  std::unordered_set<std::size_t> seen_;
  std::vector<std::pair<int, int>> pairs_;
};

/// Of points by their numbers of blocks, those seen by many more passes than the points after them.
std::vector<std::uint32_t> ChooseBordered(
    std::vector<std::pair<std::size_t, std::uint32_t>> many_blocks,
    std::size_t most_others,
    std::size_t most) {
  std::stable_sort(many_blocks.begin(), many_blocks.end(), [](const auto& a, const auto& b) {
    return a.first > b.first;
  });
  std::size_t taken = 0;
  for (std::size_t k = 1; k <= std::min(most, many_blocks.size()); ++k) {
    const std::size_t next = k < many_blocks.size() ? many_blocks[k].first : most_others;
    if (many_blocks[k - 1].first >= kGap * next) taken = k;
  }
  std::vector<std::uint32_t> out;
  for (std::size_t k = 0; k < taken; ++k) out.push_back(many_blocks[k].second);
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::uint32_t> FindBordered(const AdjustmentProblem& problem) {
  if (problem.layout.blocks.size() <= kMostEliminated) return {};
  BlocksOfPoints blocks_of(problem);
  std::vector<std::pair<std::size_t, std::uint32_t>> many_blocks;
  std::size_t most_others = 0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    auto count = static_cast<std::size_t>(problem.CountLooks(point));
    if (count * LookColumns{}.block.size() > kMostEliminated) {
      count = blocks_of.At(point).size();
    }
    if (count > kMostEliminated) {
      many_blocks.emplace_back(count, static_cast<std::uint32_t>(point));
    } else {
      most_others = std::max(most_others, count);
    }
  }
  const auto columns = static_cast<std::size_t>(problem.layout.size());
  const std::size_t fit = kBorderBytes / (3 * sizeof(double) * columns);
  return ChooseBordered(std::move(many_blocks), most_others, std::min(fit, kMostBordered));
}

}  // namespace

ReducedPattern FindPattern(const AdjustmentProblem& problem, bool allow_border) {
  const ParameterLayout& layout = problem.layout;
  ReducedPattern out;
  if (allow_border) out.bordered.points = FindBordered(problem);
  std::vector<int> sizes;
  for (const ParameterBlock& block : layout.blocks) sizes.push_back(block.size);
  PairSet seen(layout.blocks.size());
  BlocksOfPoints blocks_of(problem);
  std::vector<int> of_look;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    if (out.bordered.RowOf(point) < 0) {
      seen.AddPairs(blocks_of.At(point));
      continue;
    }
    blocks_of.At(point, [&](const LookColumns& columns) {
      of_look.clear();
      InsertBlocks(columns, &of_look);
      seen.AddPairs(of_look);
    });
  }
  out.looks = blocks_of.looks();
  out.columns = blocks_of.columns();
  out.pattern = std::make_shared<const BlockPattern>(std::move(sizes), seen.Pairs());
  return out;
}

}  // namespace sarblock
