// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace sarblock {

/// Writes a table cell by cell, whatever it is stored in; it appears whole at Commit().
class TableWriter {
 public:
  virtual ~TableWriter() = default;

  virtual TableWriter& Text(std::string_view text) = 0;
  /// Text that is an id of the block: number `index` of its passes or its points.
  virtual TableWriter& Id(std::string_view text, std::uint32_t /*index*/) { return Text(text); }
  /// NaN is an empty cell. Infinity is refused (InputError), at the latest by EndPart() and
  /// Commit(): no table holds one.
  TableWriter& Number(double value) {
    if (next_cell_ < numbers_.size() && numbers_[next_cell_] != nullptr) {
      numbers_[next_cell_++][kept_rows_] = value;
    } else {
      PutNumber(value);
    }
    return *this;
  }
  template <std::integral T>
  TableWriter& Integer(T value) {
    if (next_cell_ < numbers_.size() && numbers_[next_cell_] != nullptr) {
      numbers_[next_cell_++][kept_rows_] = static_cast<double>(value);
    } else {
      PutInteger(static_cast<std::int64_t>(value));
    }
    return *this;
  }
  virtual TableWriter& Empty(std::size_t cells) = 0;
  TableWriter& Empty() { return Empty(1); }
  /// Ends the row; std::logic_error unless it has a cell for every column.
  virtual void EndRow() = 0;
  virtual void Commit() = 0;

  /// A writer of rows of this table that another thread may use beside this one: it keeps them
  /// until Append() writes them. Ids that the table is given the index of go to a part by Id().
  [[nodiscard]] virtual std::unique_ptr<TableWriter> Part() = 0;
  /// Ends a part, by the thread that wrote its rows: what no table holds is refused.
  virtual void EndPart() {}
  /// Writes the rows of an ended Part() of this table behind those written before. It has none then
  /// and may be used again.
  virtual void Append(TableWriter* part) = 0;
  /// Rows that a part holds best.
  [[nodiscard]] virtual std::size_t rows_of_part() const = 0;

  // Of a part without rows that keeps columns: its rows as whole columns, in any order of the
  // columns, all of which are needed before EndRows().
  /// Takes the numbers of a column from where they stand, which they do until Append(): finite, or
  /// the NaN of std::numeric_limits. False where columns are not kept.
  [[nodiscard]] virtual bool LendNumbers(std::size_t /*column*/, std::span<const double>) {
    return false;
  }
  /// Where so many indices of ids that the table is given, or of IndexOf(), go; likewise.
  [[nodiscard]] virtual std::uint32_t* IndicesOf(std::size_t /*column*/, std::size_t /*rows*/) {
    return nullptr;
  }
  /// The index of a text in the part's own list for a column of text.
  [[nodiscard]] virtual std::uint32_t IndexOf(std::size_t /*column*/, std::string_view /*text*/) {
    return 0;
  }
  /// Ends the part.
  virtual void EndRows(std::size_t /*rows*/) {}

 protected:
  TableWriter() = default;
  TableWriter(TableWriter&&) = default;
  TableWriter& operator=(TableWriter&&) = default;
  virtual void PutNumber(double value) = 0;
  virtual void PutInteger(std::int64_t value) = 0;

  /// By column: where the numbers of its rows stand; null where the cells are text. Empty where
  /// rows are kept as text.
  std::vector<double*> numbers_;
  std::size_t next_cell_ = 0;  // of the row
  std::size_t kept_rows_ = 0;
};

/// Has `write(begin, end, out)` write the rows of [0, count), or what is as long as `per_piece`
/// says: pieces of so many on all threads. The rows stand in their order.
void WriteRows(std::size_t count,
               std::size_t per_piece,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, TableWriter*)>& write);

/// Throws InputError naming the file for a number that no table holds.
void RefuseInfinity(double value, std::string_view file);

}  // namespace sarblock
