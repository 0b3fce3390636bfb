// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/atomic_file.h"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// Writes a table cell by cell; the file appears whole at Commit() (atomic_file.h).
/// Numbers are the shortest decimals that read back to the same double; NaN is an empty cell.
/// Text is quoted where it has to be, so that CsvReader reads it back unchanged.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& file,
            const std::vector<std::string_view>& columns,
            Compression compression = Compression::kNone);

  CsvWriter& Text(std::string_view text);
  CsvWriter& Number(double);  ///< refuses infinity (InputError): no table holds one
  template <std::integral T>
  CsvWriter& Integer(T value) {
    return Signed(static_cast<std::int64_t>(value));
  }
  CsvWriter& Empty(std::size_t cells = 1);
  /// Ends the row; std::logic_error unless it has as many cells as the header.
  void EndRow();
  void Commit();

 private:
  CsvWriter& Signed(std::int64_t value);
  void Separate();
  AtomicFile file_;
  std::string name_;
  std::string row_;
  std::size_t columns_ = 0;
  std::size_t cells_ = 0;
};

/// A cell of text as CSV, quoted where it has to be, so that CsvReader reads it back unchanged;
/// appended.
void AppendCsvText(std::string_view text, std::string* row);

}  // namespace sarblock
