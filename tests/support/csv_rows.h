// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/text.h"
#include "tables/csv.h"

namespace sarblock::test {

/// The rows of a text table one after the other, cells as they are in the file.
class CsvRows {
 public:
  CsvRows(const std::filesystem::path& file, Schema columns) {
    const auto table = ReadCsv(file, AsTexts(columns));
    for (std::size_t i = 0; i < columns.size(); ++i) has_.push_back(table->Has(i));
    ForRows(table.get(), [&](const Row& row) {
      std::vector<std::string>& cells = rows_.emplace_back();
      for (std::size_t i = 0; i < columns.size(); ++i) cells.emplace_back(row.Text(i));
    });
  }
  [[nodiscard]] bool Next() { return next_++ < rows_.size(); }
  [[nodiscard]] bool Has(std::size_t column) const { return has_[column]; }
  [[nodiscard]] const std::string& Text(std::size_t column) const {
    return rows_[next_ - 1][column];
  }
  [[nodiscard]] bool Given(std::size_t column) const { return !Text(column).empty(); }
  /// NaN for a cell that is empty or no number.
  [[nodiscard]] double Number(std::size_t column) const {
    double value = 0.0;
    return ParseNumber(Text(column), &value) == nullptr ? value
                                                        : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  std::vector<bool> has_;
  std::vector<std::vector<std::string>> rows_;
  std::size_t next_ = 0;
};

}  // namespace sarblock::test
