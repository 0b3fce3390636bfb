// SPDX-License-Identifier: Apache-2.0
#include "block_matrix.h"

#include <algorithm>
#include <utility>

#include <glog/logging.h>

namespace sarblock {

BlockPattern::BlockPattern(std::vector<int> sizes, const std::vector<std::pair<int, int>>& pairs)
    : sizes_(std::move(sizes)) {
  const std::size_t count = sizes_.size();
  offsets_.resize(count + 1);
  for (std::size_t b = 0; b < count; ++b) {
    CHECK_GE(sizes_[b], 0) << "block " << b;
    offsets_[b + 1] = offsets_[b] + sizes_[b];
  }
  // Rows bucketed by column first, so that only short lists are sorted.
  std::vector<std::size_t> begin(count + 1, 0);
  for (const auto& [a, b] : pairs) {
    CHECK(a >= 0 && b >= 0 && a < block_count() && b < block_count()) << a << ", " << b;
    ++begin[static_cast<std::size_t>(std::min(a, b)) + 1];
  }
  for (std::size_t j = 0; j < count; ++j) {
    begin[j + 1] += begin[j] + 1;  // the diagonal
  }
  std::vector<int> bucket(begin.back());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t j = 0; j < count; ++j) {
    bucket[next[j]++] = static_cast<int>(j);
  }
  for (const auto& [a, b] : pairs) {
    bucket[next[static_cast<std::size_t>(std::min(a, b))]++] = std::max(a, b);
  }
  column_begin_.assign(count + 1, 0);
  for (std::size_t j = 0; j < count; ++j) {
    const auto first = bucket.begin() + static_cast<std::ptrdiff_t>(begin[j]);
    const auto end = bucket.begin() + static_cast<std::ptrdiff_t>(begin[j + 1]);
    std::sort(first, end);
    rows_.insert(rows_.end(), first, std::unique(first, end));
    column_begin_[j + 1] = rows_.size();
  }
  value_begin_.resize(rows_.size() + 1);
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t slot = column_begin_[j]; slot < column_begin_[j + 1]; ++slot) {
      value_begin_[slot + 1] = value_begin_[slot] + static_cast<std::size_t>(size(rows_[slot])) *
                                                        static_cast<std::size_t>(sizes_[j]);
    }
  }
  if (block_count() <= kTableLimit) {
    table_.assign(count * (count + 1) / 2, -1);
    for (int j = 0; j < block_count(); ++j) {
      std::size_t slot = FirstSlot(j);
      for (const int i : RowsOfColumn(j)) {
        table_[TableIndex(i, j)] = static_cast<std::int32_t>(slot++);
      }
    }
  }
}

std::span<const int> BlockPattern::RowsOfColumn(int column) const {
  const auto j = static_cast<std::size_t>(column);
  return std::span(rows_).subspan(column_begin_[j], column_begin_[j + 1] - column_begin_[j]);
}

std::size_t BlockPattern::Search(int i, int j) const {
  const std::span<const int> rows = RowsOfColumn(j);
  const auto found = std::lower_bound(rows.begin(), rows.end(), i);
  if (found == rows.end() || *found != i) {
    return kAbsent;
  }
  return FirstSlot(j) + static_cast<std::size_t>(found - rows.begin());
}

void BlockPattern::SlotsOfPairs(std::span<const int> blocks, std::size_t* out) const {
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    if (table_.empty()) {
      for (std::size_t i = j; i < blocks.size(); ++i) {
        out[i * (i + 1) / 2 + j] = Slot(blocks[i], blocks[j]);
      }
      continue;
    }
    const std::int32_t* slots = table_.data() + TableIndex(0, blocks[j]);
    std::size_t at = j * (j + 1) / 2 + j;
    for (std::size_t i = j; i < blocks.size(); at += ++i) {
      const std::int32_t slot = slots[blocks[i]];
      if (slot < 0) FailMissing(blocks[i], blocks[j]);
      out[at] = static_cast<std::size_t>(slot);
    }
  }
}

void BlockPattern::FailMissing(int i, int j) {
  LOG(FATAL) << "block (" << i << ", " << j << ") is not in the pattern";
}

BlockSymmetricMatrix::BlockSymmetricMatrix()
    : BlockSymmetricMatrix(std::make_shared<const BlockPattern>()) {}

BlockSymmetricMatrix::BlockSymmetricMatrix(std::vector<int> sizes,
                                           std::vector<std::pair<int, int>> pairs)
    : BlockSymmetricMatrix(std::make_shared<const BlockPattern>(std::move(sizes), pairs)) {}

BlockSymmetricMatrix::BlockSymmetricMatrix(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)), values_(pattern_->ValueBegin(pattern_->slot_count()), 0.0) {}

void BlockSymmetricMatrix::SetZero() { std::fill(values_.begin(), values_.end(), 0.0); }

Eigen::MatrixXd BlockSymmetricMatrix::ToDense() const {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows(), rows());
  for (int j = 0; j < block_count(); ++j) {
    for (const int i : RowsOfColumn(j)) {
      dense.block(offset(i), offset(j), size(i), size(j)) = Block(i, j);
    }
  }
  dense.triangularView<Eigen::StrictlyUpper>() = dense.transpose();
  return dense;
}

Eigen::MatrixXd BlockSymmetricMatrix::Multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  CHECK_EQ(x.rows(), rows());
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(rows(), x.cols());
  for (int j = 0; j < block_count(); ++j) {
    for (const int i : RowsOfColumn(j)) {
      const Eigen::Map<const Eigen::MatrixXd> block = Block(i, j);
      if (i == j) {
        y.middleRows(offset(j), size(j)) +=
            block.selfadjointView<Eigen::Lower>() * x.middleRows(offset(j), size(j));
      } else {
        y.middleRows(offset(i), size(i)).noalias() += block * x.middleRows(offset(j), size(j));
        y.middleRows(offset(j), size(j)).noalias() +=
            block.transpose() * x.middleRows(offset(i), size(i));
      }
    }
  }
  return y;
}

}  // namespace sarblock
