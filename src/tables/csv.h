// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/tables/output.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "table.h"

namespace sarblock {

/// Reads a table of a text file, plain or gzip by the name's ending `.gz` (docs/formats.md).
///
/// UTF-8, comma, one header row, columns in any order; empty cell = not given; lines that begin
/// with `#` and empty lines are skipped; CRLF and a byte order mark are tolerated; a cell may be
/// quoted ("a,b", quotes inside doubled) but not run over the end of a line. Spaces and tabs
/// around a cell do not count.
///
/// Everything that is wrong throws InputError with file, line and column; at once a file that
/// cannot be opened, a required column that is missing and a known one that is there twice.
///
/// Where `sha256` is given, the text must have this checksum; if not, reading the last row throws.
[[nodiscard]] std::unique_ptr<TableReader> ReadCsv(const std::filesystem::path& file,
                                                   Schema schema,
                                                   const std::string& sha256 = {});
/// The same from memory; `name` is the file in messages, `text` must outlive the reader.
[[nodiscard]] std::unique_ptr<TableReader> ReadCsvText(std::string name,
                                                       std::string_view text,
                                                       Schema schema);

/// The bytes of a text table.
class TableBytes {
 public:
  virtual ~TableBytes() = default;
  /// Up to `size` bytes; 0 at the end. What went wrong, if anything, goes to `problem`.
  [[nodiscard]] virtual std::size_t Read(char* to, std::size_t size, std::string* problem) = 0;
  /// False for a text in memory.
  [[nodiscard]] virtual bool MayBeCutOff() const { return true; }
};
/// The bytes of a file, inflated. Throws InputError naming it if it cannot be opened. A checksum,
/// where one is given, is compared at the end.
[[nodiscard]] std::unique_ptr<TableBytes> OpenBytes(const std::filesystem::path& file,
                                                    const std::string& sha256 = {});

/// Writes a table as text; the file appears whole at Commit() (output.h). Numbers are the shortest
/// decimals that read back to the same double. Text is quoted where it has to be, so that ReadCsv()
/// reads it back unchanged.
[[nodiscard]] std::unique_ptr<TableWriter> WriteCsv(
    const std::filesystem::path& file,
    Schema schema,
    Compression compression = Compression::kNone,
    std::span<const std::string_view> left_out = {});

/// A cell of text, quoted where it has to be; appended.
void AppendCsvText(std::string_view text, std::string* row);

}  // namespace sarblock
