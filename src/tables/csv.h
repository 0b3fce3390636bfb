// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/tables/output.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "table.h"

namespace sarblock {

class CsvSource;  ///< where the bytes come from (src/tables/csv.h)

/// Reads a table of a text file, plain or gzip (docs/formats.md).
///
/// UTF-8, comma, one header row, columns in any order; empty cell = not given; lines that begin
/// with `#` and empty lines are skipped; CRLF and a byte order mark are tolerated; a cell may be
/// quoted ("a,b", quotes inside doubled) but not run over the end of a line. Spaces and tabs
/// around a cell do not count. Nothing is allocated per row: cells are views into a buffer, valid
/// until the next call of Next().
///
/// Everything that is wrong throws InputError with file, line and column.
class CsvReader final : public TableReader {
 public:
  /// Opens a file; a name ending in `.gz` is inflated. Reads the header row at once.
  /// Throws if a required column is missing or a known one stands twice.
  CsvReader(const std::filesystem::path& file, std::span<const TableColumn> columns);
  /// The same from memory; `name` stands for the file in messages, `text` must outlive the reader.
  CsvReader(std::string name, std::string_view text, std::span<const TableColumn> columns);
  ~CsvReader() override;
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;

  [[nodiscard]] bool Next() override;
  [[nodiscard]] std::unique_ptr<TableReader> Part() override;
  [[nodiscard]] FilePlace PlaceAt(std::size_t line, std::size_t column) const override;
  [[nodiscard]] std::string NameOfLine(std::size_t line) const override;

 private:
  CsvReader(std::string name,
            std::unique_ptr<CsvSource> source,
            std::size_t buffer_bytes,
            std::span<const TableColumn> columns);
  /// Of whole lines behind line `line`, with the columns of `whole`.
  CsvReader(const CsvReader& whole, std::vector<char> lines, std::size_t line);
  void ReadHeader(std::span<const TableColumn> columns);
  [[nodiscard]] bool NextLine(std::string_view* line);
  [[nodiscard]] bool Refill();
  [[nodiscard]] std::size_t Split(std::string_view line);
  [[nodiscard]] const char* Unquote(const char* begin, const char* end, std::string_view* cell);
  [[noreturn]] void FailRow(const std::string& problem) const;
  [[nodiscard]] std::string ColumnsThere() const override { return "the header has " + header_; }
  [[nodiscard]] std::string_view TextOf(std::size_t column) const override {
    return cells_[place_[column]];
  }

  std::string header_;
  std::size_t header_line_ = 0;
  std::unique_ptr<CsvSource> source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // of the text in buffer_ not yet used
  std::size_t end_ = 0;
  bool source_ended_ = false;
  std::string unquoted_;  // cells whose doubled quotes were made single
  std::vector<std::string_view> cells_;
};

/// Bytes of a plain file, a gzip file or a text in memory.
class CsvSource {
 public:
  virtual ~CsvSource() = default;
  /// Up to `size` bytes; 0 at the end. What went wrong, if anything, goes to `problem`.
  [[nodiscard]] virtual std::size_t Read(char* to, std::size_t size, std::string* problem) = 0;

  /// Throws InputError naming the file if it cannot be opened.
  [[nodiscard]] static std::unique_ptr<CsvSource> Open(const std::filesystem::path& file);
  [[nodiscard]] static std::unique_ptr<CsvSource> InMemory(std::string_view text);
};

/// Writes a table as text; the file appears whole at Commit() (output.h).
/// Numbers are the shortest decimals that read back to the same double.
/// Text is quoted where it has to be, so that CsvReader reads it back unchanged.
class CsvWriter final : public TableWriter {
 public:
  CsvWriter(const std::filesystem::path& file,
            const std::vector<std::string_view>& columns,
            Compression compression = Compression::kNone);

  using TableWriter::Empty;
  CsvWriter& Text(std::string_view text) override;
  CsvWriter& Empty(std::size_t cells) override;
  void EndRow() override;
  void Commit() override;
  [[nodiscard]] std::unique_ptr<TableWriter> Part() override;
  void Append(TableWriter* part) override;
  [[nodiscard]] std::size_t rows_of_part() const override;

 private:
  /// A part of a table, without a file.
  CsvWriter(std::string name, std::size_t columns);
  void PutNumber(double value) override;
  void PutInteger(std::int64_t value) override;
  void Separate();
  std::optional<AtomicFile> file_;
  std::string name_;
  std::string row_;  // of a part: all its rows
  std::size_t columns_ = 0;
  std::size_t cells_ = 0;
};

/// A cell of text as CSV, quoted where it has to be, so that CsvReader reads it back unchanged;
/// appended.
void AppendCsvText(std::string_view text, std::string* row);

}  // namespace sarblock
