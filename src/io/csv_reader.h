// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

class CsvSource;  ///< where the bytes come from (src/io/csv_source.h)

enum class CsvNeed { kOptional, kRequired };

/// A column a reader of a table knows. Its index in the list given to CsvReader is what the cell
/// functions take.
struct CsvColumn {
  std::string_view name;
  CsvNeed need = CsvNeed::kOptional;
};

/// Reads a table row by row, plain or gzip (docs/formats.md).
///
/// UTF-8, comma, one header row, columns in any order; empty cell = not given; lines that begin
/// with `#` and empty lines are skipped; CRLF and a byte order mark are tolerated; a cell may be
/// quoted ("a,b", quotes inside doubled) but not run over the end of a line. Spaces and tabs
/// around a cell do not count. Nothing is allocated per row: cells are views into a buffer, valid
/// until the next call of Next().
///
/// Everything that is wrong throws InputError with file, line and column.
class CsvReader {
 public:
  /// Opens a file; a name ending in `.gz` is inflated. Reads the header row at once.
  /// Throws if a required column is missing or a known one stands twice.
  CsvReader(const std::filesystem::path& file, std::span<const CsvColumn> columns);
  /// The same from memory; `name` stands for the file in messages, `text` must outlive the reader.
  CsvReader(std::string name, std::string_view text, std::span<const CsvColumn> columns);
  ~CsvReader();
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;

  /// Goes to the next row; false at the end of the file.
  [[nodiscard]] bool Next();
  /// Line of the current row, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Columns of the file that nobody asked for, as they stand there.
  [[nodiscard]] const std::vector<std::string>& unknown_columns() const { return unknown_; }

  /// True if the file has this column.
  [[nodiscard]] bool Has(std::size_t column) const { return place_[column] != kAbsent; }
  /// True if the cell is there and not empty.
  [[nodiscard]] bool Given(std::size_t column) const { return !Text(column).empty(); }
  /// The cell; empty where the column or the cell is not given.
  [[nodiscard]] std::string_view Text(std::size_t column) const {
    return Has(column) ? cells_[place_[column]] : std::string_view();
  }
  /// The cell, refused if it is empty or holds control characters: a name of a pass or a point.
  [[nodiscard]] std::string_view Id(std::size_t column) const;
  /// A finite number, or NaN (kNotGiven) for an empty cell.
  [[nodiscard]] double Number(std::size_t column) const;
  /// A finite number; an empty cell is refused.
  [[nodiscard]] double RequiredNumber(std::size_t column) const;

  [[nodiscard]] FilePlace Place(std::size_t column) const;
  /// Throws InputError at the current row and this column.
  [[noreturn]] void Fail(std::size_t column, const std::string& problem) const;

 private:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

  CsvReader(std::string name,
            std::unique_ptr<CsvSource> source,
            std::size_t buffer_bytes,
            std::span<const CsvColumn> columns);
  void ReadHeader(std::span<const CsvColumn> columns);
  [[nodiscard]] bool NextLine(std::string_view* line);
  [[nodiscard]] bool Refill();
  [[nodiscard]] std::size_t Split(std::string_view line);
  [[nodiscard]] const char* Unquote(const char* begin, const char* end, std::string_view* cell);
  [[noreturn]] void FailRow(const std::string& problem) const;

  std::string file_;
  std::unique_ptr<CsvSource> source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // of the text in buffer_ not yet used
  std::size_t end_ = 0;
  bool source_ended_ = false;
  std::size_t line_ = 0;
  std::string unquoted_;  // cells whose doubled quotes were made single
  std::vector<std::string_view> cells_;
  std::vector<std::string> names_;  // asked for
  std::vector<std::size_t> place_;  // by asked column: index into cells_
  std::vector<std::string> unknown_;
};

}  // namespace sarblock
