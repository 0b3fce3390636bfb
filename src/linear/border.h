// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "block_matrix.h"
#include <Eigen/Core>

namespace sarblock {

/// Which values a border T has beside a matrix A on a pattern of blocks (BorderedMatrix): a few
/// rows, called terms, over all columns. The blocks of A fall into groups that A does not join
/// (connected components); a term has values in all columns of a group or in none. Thousands of
/// passes that A does not join, each seen by a few of the terms, so have a few values each, and
/// A^-1 T' has values where T' has.
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
  /// What follows from the groups.
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
  /// The value of a term in a column, those of the terms after it in the group behind it. It must
  /// be in the pattern (CHECK).
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
