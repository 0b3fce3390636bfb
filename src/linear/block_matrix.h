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

/// Which values a border T has beside a matrix A on a pattern of blocks (BorderedMatrix): a few
/// rows, called terms, over all columns. The blocks of A fall into groups that A does not join
/// (connected components); a term has values in all columns of a group or in none. So thousands of
/// passes that A does not join, each touched by a few terms, have few values each, and A^-1 T' has
/// values only where T' has.
class BorderPattern {
 public:
  BorderPattern() = default;
  /// `places` are the pairs (term, block) where T is not zero, in any order, duplicates allowed.
  BorderPattern(const BlockPattern& matrix,
                int terms,
                const std::vector<std::pair<int, int>>& places);
  /// A value in every term of every column.
  BorderPattern(int terms, int columns);

  struct Group {
    std::vector<int> terms;    ///< ascending
    std::vector<int> columns;  ///< of the matrix, ascending
    std::size_t begin = 0;     ///< of its values: terms x columns, column by column
  };
  [[nodiscard]] int terms() const { return terms_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
  [[nodiscard]] std::size_t value_count() const { return value_count_; }
  /// The largest number of terms of a group.
  [[nodiscard]] int MaxTerms() const;
  /// Groups in which a term has values, ascending.
  [[nodiscard]] const std::vector<int>& GroupsOf(int term) const {
    return groups_of_[static_cast<std::size_t>(term)];
  }
  /// Multiplications of T A^-1 T'.
  [[nodiscard]] double SquareOperations() const;
  /// Group of a column, -1 where T is zero.
  [[nodiscard]] int GroupOf(int column) const {
    return group_of_[static_cast<std::size_t>(column)];
  }
  /// Place of a column in its group.
  [[nodiscard]] int PlaceOf(int column) const {
    return place_of_[static_cast<std::size_t>(column)];
  }

 private:
  /// Fills the members that follow from the groups.
  void Finish();

  int terms_ = 0, columns_ = 0;
  std::vector<Group> groups_;
  std::vector<std::vector<int>> groups_of_;  // by term
  std::vector<int> group_of_, place_of_;     // by column
  std::size_t value_count_ = 0;
};

/// The values of a border.
class Border {
 public:
  Border() : pattern_(std::make_shared<const BorderPattern>()) {}
  /// Zero. The pattern is not null.
  explicit Border(std::shared_ptr<const BorderPattern> pattern);
  /// All values of a dense one.
  explicit Border(const Eigen::MatrixXd& dense);

  [[nodiscard]] bool operator==(const Border& other) const { return values_ == other.values_; }

  [[nodiscard]] const BorderPattern& pattern() const { return *pattern_; }
  [[nodiscard]] const std::shared_ptr<const BorderPattern>& shared_pattern() const {
    return pattern_;
  }
  [[nodiscard]] int terms() const { return pattern_->terms(); }
  [[nodiscard]] int columns() const { return pattern_->columns(); }
  [[nodiscard]] std::span<const double> values() const { return values_; }

  using Part = Eigen::Map<Eigen::MatrixXd>;
  using ConstPart = Eigen::Map<const Eigen::MatrixXd>;
  [[nodiscard]] Part Of(const BorderPattern::Group& group) {
    return {values_.data() + group.begin, Count(group.terms), Count(group.columns)};
  }
  [[nodiscard]] ConstPart Of(const BorderPattern::Group& group) const {
    return {values_.data() + group.begin, Count(group.terms), Count(group.columns)};
  }
  /// Pointer to the value of a term in a column; the values of the next terms of the group follow
  /// it. The value must be in the pattern (CHECK).
  [[nodiscard]] double* At(int term, int column);
  [[nodiscard]] const double* At(int term, int column) const {
    return const_cast<Border*>(this)->At(term, column);  // NOLINT: reads alone
  }

  [[nodiscard]] Eigen::MatrixXd ToDense() const { return Rows(0, terms()); }
  /// Consecutive terms over all columns.
  [[nodiscard]] Eigen::MatrixXd Rows(int first, int count) const;
  /// T X, X with a row per column.
  [[nodiscard]] Eigen::MatrixXd Times(const Eigen::Ref<const Eigen::MatrixXd>& x) const;
  /// X += T' Y, Y with a row per term.
  void AddTransposedTimes(const Eigen::MatrixXd& y, Eigen::Ref<Eigen::MatrixXd> x) const;
  [[nodiscard]] Eigen::VectorXd ColumnSquares() const;
  /// T D with the diagonal matrix D of its columns.
  [[nodiscard]] Border Scaled(const Eigen::VectorXd& d) const;

 private:
  [[nodiscard]] static Eigen::Index Count(const std::vector<int>& of) {
    return static_cast<Eigen::Index>(of.size());
  }
  std::shared_ptr<const BorderPattern> pattern_;
  std::vector<double> values_;
};

}  // namespace sarblock
