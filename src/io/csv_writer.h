// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/atomic_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "table_writer.h"

namespace sarblock {

/// Writes a table as text; the file appears whole at Commit() (atomic_file.h).
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
