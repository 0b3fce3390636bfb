// SPDX-License-Identifier: Apache-2.0
#include "csv_writer.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/text.h"
#include "ordered_pieces.h"

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
    : file_(std::in_place, file, compression), name_(file.string()), columns_(columns.size()) {
  for (const std::string_view column : columns) Text(column);
  EndRow();
}

CsvWriter::CsvWriter(std::string name, std::size_t columns)
    : name_(std::move(name)), columns_(columns) {}

void CsvWriter::Separate() {
  if (cells_++ > 0) row_ += ',';
}

CsvWriter& CsvWriter::Text(std::string_view text) {
  Separate();
  AppendCsvText(text, &row_);
  return *this;
}

void CsvWriter::PutNumber(double value) {
  RefuseInfinity(value, name_);
  Separate();
  if (!std::isnan(value)) AppendNumber(value, &row_);
}

void CsvWriter::PutInteger(std::int64_t value) {
  Separate();
  row_ += std::to_string(value);
}

CsvWriter& CsvWriter::Empty(std::size_t cells) {
  for (std::size_t i = 0; i < cells; ++i) Separate();
  return *this;
}

void CsvWriter::EndRow() {
  if (cells_ != columns_)
    throw std::logic_error("a row was about to be written with cells missing");
  row_ += '\n';
  cells_ = 0;
  if (!file_) return;
  file_->Write(row_);
  row_.clear();
}

void CsvWriter::Commit() { file_.value().Commit(); }

std::unique_ptr<TableWriter> CsvWriter::Part() {
  return std::unique_ptr<TableWriter>(new CsvWriter(name_, columns_));
}

std::size_t CsvWriter::rows_of_part() const { return kRowsPerPiece; }

void CsvWriter::Append(TableWriter* part) {
  std::string& rows = dynamic_cast<CsvWriter&>(*part).row_;
  file_.value().Write(rows);
  rows.clear();
}

}  // namespace sarblock
