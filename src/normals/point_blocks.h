// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "model/problem.h"
#include "point_terms.h"

namespace sarblock {

/// The parameter blocks of one point after the other, and how much their looks in use have
/// together.
class BlocksOfPoints {
 public:
  explicit BlocksOfPoints(const AdjustmentProblem& problem) : problem_(problem) {
    for (const PassCorrections& pass : problem.layout.passes) {
      const bool one = pass.blocks.size() == 1 && pass.splines.empty();
      only_block_.push_back(one ? pass.blocks[0] : -1);
    }
  }
  /// Ascending. Calls of_look(columns) for each look in use of a pass that has more than one block.
  template <typename OfLook>
  const std::vector<int>& At(std::size_t point, const OfLook& of_look) {
    const Looks& looks = problem_.block.looks;
    const ParameterLayout& layout = problem_.layout;
    blocks_.clear();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem_.look_used[i] == 0) continue;
      ++looks_;
      if (const int only = only_block_[looks.pass[i]]; only >= 0) {
        InsertBlock(only, &blocks_);
        counted_columns_ +=
            static_cast<std::size_t>(layout.blocks[static_cast<std::size_t>(only)].size);
        continue;
      }
      problem_.model.ColumnsOf(i, &columns_);
      InsertBlocks(columns_, &blocks_);
      of_look(columns_);
      counted_columns_ += static_cast<std::size_t>(columns_.column_count);
    }
    return blocks_;
  }
  const std::vector<int>& At(std::size_t point) {
    return At(point, [](const LookColumns&) {});
  }

  /// Of all points asked for so far.
  [[nodiscard]] std::size_t looks() const { return looks_; }
  [[nodiscard]] std::size_t columns() const { return counted_columns_; }

 private:
  const AdjustmentProblem& problem_;
  std::vector<int> only_block_;  // of a pass whose looks all have the same one
  std::vector<int> blocks_;
  LookColumns columns_;
  std::size_t looks_ = 0, counted_columns_ = 0;
};

}  // namespace sarblock
