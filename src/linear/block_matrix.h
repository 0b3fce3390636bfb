// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Which pairs of parameter blocks a BlockSymmetricMatrix stores, and where. Immutable, so that
/// the per-thread copies of a matrix, its factor and its selected inverse share one.
class BlockPattern {
 public:
  BlockPattern() = default;
  /// Block b has `sizes[b]` >= 0 rows. `pairs` are block pairs (i, j) in any order and either
  /// orientation, duplicates allowed; the diagonal is always added. CHECKs the range of both.
  BlockPattern(std::vector<int> sizes, const std::vector<std::pair<int, int>>& pairs);

  [[nodiscard]] bool operator==(const BlockPattern& other) const = default;

  [[nodiscard]] int block_count() const { return static_cast<int>(sizes_.size()); }
  [[nodiscard]] int size(int block) const { return sizes_[static_cast<std::size_t>(block)]; }
  [[nodiscard]] int offset(int block) const { return offsets_[static_cast<std::size_t>(block)]; }
  [[nodiscard]] int rows() const { return offsets_.back(); }
  /// Sorted rows i >= column of the stored blocks, starting with the column itself.
  [[nodiscard]] std::span<const int> RowsOfColumn(int column) const;
  /// Slot of the first block of a column; the slots of its RowsOfColumn follow one another.
  [[nodiscard]] std::size_t FirstSlot(int column) const {
    return column_begin_[static_cast<std::size_t>(column)];
  }
  /// Where the values of a slot begin; one past the last slot gives the number of values.
  [[nodiscard]] std::size_t ValueBegin(std::size_t slot) const { return value_begin_[slot]; }
  [[nodiscard]] std::size_t slot_count() const { return rows_.size(); }
  /// Number of values of a slot.
  [[nodiscard]] std::size_t ValuesOf(std::size_t slot) const {
    return value_begin_[slot + 1] - value_begin_[slot];
  }

  /// Slot of block (i, j), i >= j; kAbsent when it is not in the pattern. Constant time up to
  /// kTableLimit blocks (packed table, 8 MB at most), binary search in the column above: the
  /// assembly of the reduced normal matrix asks k (k + 1) / 2 times for a point with k looks.
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
  static constexpr int kTableLimit = 2048;
  [[nodiscard]] std::size_t Find(int i, int j) const {
    if (i < j || j < 0 || i >= block_count()) {
      return kAbsent;
    }
    if (table_.empty()) {
      return Search(i, j);
    }
    const std::int32_t slot = table_[TableIndex(i, j)];
    return slot < 0 ? kAbsent : static_cast<std::size_t>(slot);
  }
  /// As Find, for a block that must be there (CHECK).
  [[nodiscard]] std::size_t Slot(int i, int j) const {
    const std::size_t slot = Find(i, j);
    if (slot == kAbsent) {
      FailMissing(i, j);
    }
    return slot;
  }

  /// Slots of the blocks of every pair of an ascending list, (i, j) with i >= j at
  /// i (i + 1) / 2 + j. They must be there (CHECK).
  void SlotsOfPairs(std::span<const int> blocks, std::size_t* out) const;

 private:
  [[nodiscard]] std::size_t TableIndex(int i, int j) const {
    const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
    return column * (2 * sizes_.size() - column - 1) / 2 + row;
  }
  [[nodiscard]] std::size_t Search(int i, int j) const;
  [[noreturn]] static void FailMissing(int i, int j);

  std::vector<int> sizes_, offsets_{0};
  std::vector<std::size_t> column_begin_{0};  // into rows_
  std::vector<int> rows_;
  std::vector<std::size_t> value_begin_{0};  // by slot, one more than slots
  std::vector<std::int32_t> table_;          // lower triangle by columns; -1 is absent
};

/// A symmetric matrix of dense blocks over pairs of parameter blocks; the lower triangle is stored.
/// Block b has `sizes[b]` rows. The pattern always has the diagonal. Blocks are column-major,
/// one flat array; column j's rows are sorted and start with j. ToDense, Multiply and
/// BlockCholesky read only the lower triangle of a diagonal block.
class BlockSymmetricMatrix {
 public:
  BlockSymmetricMatrix();
  /// `pairs` are block pairs (i, j) in any order, duplicates allowed. All values start at zero.
  BlockSymmetricMatrix(std::vector<int> sizes, std::vector<std::pair<int, int>> pairs);
  /// A zero matrix on a shared pattern (not null).
  explicit BlockSymmetricMatrix(std::shared_ptr<const BlockPattern> pattern);

  [[nodiscard]] const std::shared_ptr<const BlockPattern>& pattern() const { return pattern_; }
  [[nodiscard]] int block_count() const { return pattern_->block_count(); }
  [[nodiscard]] int size(int block) const { return pattern_->size(block); }
  [[nodiscard]] int offset(int block) const { return pattern_->offset(block); }
  [[nodiscard]] int rows() const { return pattern_->rows(); }
  [[nodiscard]] std::span<const int> RowsOfColumn(int column) const {
    return pattern_->RowsOfColumn(column);
  }
  [[nodiscard]] bool Contains(int i, int j) const {
    return pattern_->Find(i, j) != BlockPattern::kAbsent;
  }
  /// The stored block (i, j), i >= j, size(i) x size(j). It must be in the pattern (CHECK).
  [[nodiscard]] Eigen::Map<Eigen::MatrixXd> Block(int i, int j) {
    return {values_.data() + pattern_->ValueBegin(pattern_->Slot(i, j)), size(i), size(j)};
  }
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXd> Block(int i, int j) const {
    return {values_.data() + pattern_->ValueBegin(pattern_->Slot(i, j)), size(i), size(j)};
  }
  /// Flat values of all blocks, for summing per-thread copies in a fixed order.
  [[nodiscard]] std::span<double> values() { return values_; }
  [[nodiscard]] std::span<const double> values() const { return values_; }
  void SetZero();
  [[nodiscard]] Eigen::MatrixXd ToDense() const;
  /// The product with the columns of x, each of rows() elements.
  [[nodiscard]] Eigen::MatrixXd Multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const;

 private:
  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<double> values_;
};

}  // namespace sarblock
