// SPDX-License-Identifier: Apache-2.0
#include "csv_writer.h"

#include <cmath>
#include <stdexcept>

#include "number.h"

namespace sarblock {

void AppendCsvText(std::string_view text, std::string* row) {
  const bool blank_end = !text.empty() && (text.front() == ' ' || text.front() == '\t' ||
                                           text.back() == ' ' || text.back() == '\t');
  const bool byte_order_mark = text.starts_with("\xEF\xBB\xBF");
  if (!blank_end && !byte_order_mark && !text.starts_with('#') &&
      text.find_first_of(",\"\r\n") == std::string_view::npos) {
    *row += text;
    return;
  }
  *row += '"';
  for (const char c : text) {
    if (c == '"') *row += '"';
    *row += c;
  }
  *row += '"';
}

CsvWriter::CsvWriter(const std::filesystem::path& file,
                     const std::vector<std::string_view>& columns,
                     Compression compression)
    : file_(file, compression), name_(file.string()), columns_(columns.size()) {
  for (const std::string_view column : columns) Text(column);
  EndRow();
}

void CsvWriter::Separate() {
  if (cells_++ > 0) row_ += ',';
}

CsvWriter& CsvWriter::Text(std::string_view text) {
  Separate();
  AppendCsvText(text, &row_);
  return *this;
}

CsvWriter& CsvWriter::Number(double value) {
  RefuseInfinity(value, name_);
  Separate();
  if (!std::isnan(value)) AppendNumber(value, &row_);
  return *this;
}

CsvWriter& CsvWriter::Signed(std::int64_t value) {
  Separate();
  row_ += std::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::Empty(std::size_t cells) {
  for (std::size_t i = 0; i < cells; ++i) Separate();
  return *this;
}

void CsvWriter::EndRow() {
  if (cells_ != columns_)
    throw std::logic_error("a row was about to be written with cells missing");
  row_ += '\n';
  file_.Write(row_);
  row_.clear();
  cells_ = 0;
}

void CsvWriter::Commit() { file_.Commit(); }

}  // namespace sarblock
