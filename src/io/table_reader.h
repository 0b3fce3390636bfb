// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "table_columns.h"

namespace sarblock {

/// Reads a table row by row, whatever it is stored in: what a block or a result may hold is checked
/// here and by who asks for the cells, once for all kinds of files. Views of cells are valid until
/// the next call of Next(). Everything that is wrong throws InputError with its place.
class TableReader {
 public:
  virtual ~TableReader() = default;

  /// Goes to the next row; false at the end of the table.
  [[nodiscard]] virtual bool Next() = 0;
  /// A reader of the next rows, some at a time, that another thread may use beside this one, which
  /// goes on behind them. Null at the end. No row may be read by Next() of this one before. A part
  /// has no parts.
  [[nodiscard]] virtual std::unique_ptr<TableReader> Part() = 0;
  /// Number of rows to come where it is known before the end; else 0.
  [[nodiscard]] virtual std::size_t RowCount() const { return 0; }
  /// Line (row) of the current row, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// The file, for messages.
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Columns of the file that nobody asked for, as they stand there.
  [[nodiscard]] const std::vector<std::string>& unknown_columns() const { return unknown_; }

  /// True if the file has this column.
  [[nodiscard]] bool Has(std::size_t column) const { return place_[column] != kAbsent; }
  /// Throws if it does not.
  void RequireColumn(std::size_t column) const;
  /// True if the cell is there and not empty.
  [[nodiscard]] bool Given(std::size_t column) const {
    if (!Has(column)) return false;
    return numbers_[column] != nullptr ? !std::isnan(numbers_[column][at_])
                                       : !TextOf(column).empty();
  }
  /// The cell; empty where the column or the cell is not given.
  [[nodiscard]] std::string_view Text(std::size_t column) const {
    return Has(column) ? TextOf(column) : std::string_view();
  }
  /// The cell, refused if it is empty or holds control characters: a name of a pass or a point.
  [[nodiscard]] std::string_view Id(std::size_t column) const;
  /// What keeps a text from being a name of a pass or a point; null: nothing.
  [[nodiscard]] static const char* ProblemOfId(std::string_view id);
  /// Number of the cell's text where the file stores each text once, else kUnknown.
  [[nodiscard]] virtual std::uint32_t IndexOfText(std::size_t /*column*/) const { return kUnknown; }
  /// A finite number, or NaN (kNotGiven) for an empty cell.
  [[nodiscard]] double Number(std::size_t column) const {
    if (!Has(column)) return std::numeric_limits<double>::quiet_NaN();
    return numbers_[column] != nullptr ? numbers_[column][at_] : ParsedNumber(column);
  }
  /// A finite number; an empty cell is refused.
  [[nodiscard]] double RequiredNumber(std::size_t column) const;
  /// An integer of 0 to 2^32 - 1; 0 for an empty cell.
  [[nodiscard]] std::uint32_t Count(std::size_t column) const;
  /// True for 1, false for 0 or an empty cell.
  [[nodiscard]] bool Flag(std::size_t column) const;
  /// What `find` returns for the cell's text, an index of something. Where a file stores each text
  /// once, `find` is asked once for each: in one way for a column, and for all columns of ids of
  /// passes, or of points, of all tables of a source.
  template <typename Find>
  [[nodiscard]] std::uint32_t Lookup(std::size_t column, const Find& find) const {
    std::uint32_t* const memo = Memo(column);
    if (memo == nullptr) return find();
    if (*memo == kUnknown) *memo = find();
    return *memo;
  }

  /// Of a part that no row has been read of: Lookup() of all its rows at once, after which several
  /// threads may call Lookup() of their parts. `find` returns kUnknown for a text that Lookup() is
  /// to ask for again, which then has to throw. False where the file does not store each text once,
  /// and nothing is done.
  template <typename Find>
  [[nodiscard]] bool LookupAhead(std::size_t column, const Find& find) const {
    const NumberedTexts numbered = TextsAhead(column);
    std::uint32_t* const memos = MemosAhead(column);
    for (const std::uint32_t text : numbered.rows) {
      if (text >= numbered.count) continue;  // refused where its row is read
      std::uint32_t& memo = memos[text];
      if (memo != kUnknown) continue;
      const std::uint32_t found = find(TextOfNumbered(column, text));
      if (found != kUnknown) memo = found;  // else other threads may read it
    }
    return memos != nullptr;
  }
  /// Of such a part, what LookupAhead() found, one index a row. False where some row has none or is
  /// not allowed.
  [[nodiscard]] bool IndicesAhead(std::size_t column, std::vector<std::uint32_t>* indices) const;
  /// Of a part that no row has been read of: the numbers of all its rows, NaN where none is given,
  /// infinite where Next() refuses the row. None where the cells are text or the column is absent.
  [[nodiscard]] std::span<const double> NumbersAhead(std::size_t column) const {
    return Has(column) ? CellsAhead(column) : std::span<const double>();
  }
  /// Of such a part: whether it is known without a look at the rows that none gives this number.
  [[nodiscard]] bool NoneAhead(std::size_t column) const {
    return !Has(column) || IsUnstored(column);
  }
  /// Of such a part, where the file stores each text once: by row, the number of the cell's text.
  /// None where the cells are stored otherwise or a number has no text.
  [[nodiscard]] std::span<const std::uint32_t> TextNumbersAhead(std::size_t column) const;
  /// The text of one of these numbers.
  [[nodiscard]] std::string_view TextAhead(std::size_t column, std::uint32_t number) const {
    return TextOfNumbered(column, number);
  }
  static constexpr std::uint32_t kUnknown = 0xffffffffu;

  /// Where the cell of the current row, or of that line (row), stands.
  [[nodiscard]] FilePlace Place(std::size_t column) const { return PlaceAt(line_, column); }
  [[nodiscard]] virtual FilePlace PlaceAt(std::size_t line, std::size_t column) const = 0;
  /// "line 12", for messages.
  [[nodiscard]] virtual std::string NameOfLine(std::size_t line) const = 0;
  /// Throws InputError at the current row and this column.
  [[noreturn]] void Fail(std::size_t column, const std::string& problem) const;

 protected:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

  TableReader(std::string file, std::span<const TableColumn> columns);
  TableReader(const TableReader&) = default;  // of the same columns, for a part
  TableReader(TableReader&&) noexcept = default;
  TableReader& operator=(TableReader&&) noexcept = default;
  /// Of a column that is there.
  [[nodiscard]] virtual std::string_view TextOf(std::size_t column) const = 0;
  /// A stored number as a text, empty for NaN; `text` is where it stands if need be.
  [[nodiscard]] static std::string_view TextOfNumber(double value, std::string* text);
  /// The cell's text as a number, NaN if it is empty.
  [[nodiscard]] double ParsedNumber(std::size_t column) const;
  /// Throws where a required column has no place.
  void RequireColumns(std::span<const TableColumn> columns) const;
  /// Where Lookup() keeps what it found for the text of this cell, kUnknown before; null where
  /// texts are not numbered.
  [[nodiscard]] virtual std::uint32_t* Memo(std::size_t /*column*/) const { return nullptr; }
  /// Texts by number, those that rows to come hold.
  struct NumberedTexts {
    std::span<const std::uint32_t> rows;
    std::size_t count = 0;
  };
  /// None where texts are not numbered.
  [[nodiscard]] virtual NumberedTexts TextsAhead(std::size_t /*column*/) const { return {}; }
  /// What Memo() of each text points to, by number; null where texts are not numbered.
  [[nodiscard]] virtual std::uint32_t* MemosAhead(std::size_t /*column*/) const { return nullptr; }
  /// A text by its number.
  [[nodiscard]] virtual std::string_view TextOfNumbered(std::size_t /*column*/,
                                                        std::uint32_t /*text*/) const {
    return {};
  }
  /// NumbersAhead() of a column that is there.
  [[nodiscard]] virtual std::span<const double> CellsAhead(std::size_t /*column*/) const {
    return {};
  }
  /// NoneAhead() of a column that is there.
  [[nodiscard]] virtual bool IsUnstored(std::size_t /*column*/) const { return false; }
  /// What the table has in place of a missing column: "the header has a,b".
  [[nodiscard]] virtual std::string ColumnsThere() const = 0;

  std::string file_;
  std::size_t line_ = 0;
  std::vector<std::string> names_;  // asked for
  std::vector<std::size_t> place_;  // by asked column: where it stands
  /// By asked column: numbers of several rows, of which the current one is number `at_`, finite or
  /// NaN; null where the cells are text.
  std::vector<const double*> numbers_;
  std::size_t at_ = 0;
  std::vector<std::string> unknown_;
};

}  // namespace sarblock
