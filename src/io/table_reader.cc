// SPDX-License-Identifier: Apache-2.0
#include "table_reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.h"

namespace sarblock {

TableReader::TableReader(std::string file, std::span<const TableColumn> columns)
    : file_(std::move(file)), place_(columns.size(), kAbsent), numbers_(columns.size()) {
  for (const TableColumn& column : columns) names_.emplace_back(column.name);
}

void TableReader::RequireColumn(std::size_t column) const {
  if (Has(column)) return;
  throw InputError(PlaceAt(0, column), "the column is missing; " + ColumnsThere());
}

void TableReader::RequireColumns(std::span<const TableColumn> columns) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].need == ColumnNeed::kRequired) RequireColumn(i);
  }
}

std::string_view TableReader::Id(std::size_t column) const {
  const std::string_view id = Text(column);
  if (const char* problem = ProblemOfId(id)) Fail(column, problem);
  return id;
}

const char* TableReader::ProblemOfId(std::string_view id) {
  if (id.empty()) return "is empty, a name is needed";
  for (const char c : id) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f)
      return "the name holds a control character, which is not allowed";
  }
  return nullptr;
}

std::string_view TableReader::TextOfNumber(double value, std::string* text) {
  if (std::isnan(value)) return {};
  if (value == 0.0 && !std::signbit(value)) return "0";
  if (value == 1.0) return "1";
  *text = NumberText(value);
  return *text;
}

double TableReader::ParsedNumber(std::size_t column) const {
  const std::string_view text = TextOf(column);
  if (text.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  if (const char* problem = ParseNumber(text, &value)) Fail(column, Quoted(text) + problem);
  return value;
}

bool TableReader::IndicesAhead(std::size_t column, std::vector<std::uint32_t>* indices) const {
  const NumberedTexts numbered = TextsAhead(column);
  const std::uint32_t* const memos = MemosAhead(column);
  if (memos == nullptr) return false;
  indices->resize(numbered.rows.size());
  for (std::size_t row = 0; row < numbered.rows.size(); ++row) {
    const std::uint32_t text = numbered.rows[row];
    (*indices)[row] = text < numbered.count ? memos[text] : kUnknown;
  }
  return std::find(indices->begin(), indices->end(), kUnknown) == indices->end();
}

std::span<const std::uint32_t> TableReader::TextNumbersAhead(std::size_t column) const {
  const NumberedTexts numbered = TextsAhead(column);
  const auto has_none = [&](std::uint32_t text) { return text >= numbered.count; };
  if (std::any_of(numbered.rows.begin(), numbered.rows.end(), has_none)) return {};
  return numbered.rows;
}

double TableReader::RequiredNumber(std::size_t column) const {
  const double value = Number(column);
  if (std::isnan(value)) Fail(column, "is empty, a number is needed");
  return value;
}

std::uint32_t TableReader::Count(std::size_t column) const {
  const double value = Number(column);
  if (std::isnan(value)) return 0;
  if (!(value >= 0.0 && value <= 4294967295.0 && value == std::floor(value))) {
    Fail(column, NumberText(value) + " is not allowed, an integer of 0 or more is");
  }
  return static_cast<std::uint32_t>(value);
}

bool TableReader::Flag(std::size_t column) const {
  const std::string_view text = Text(column);
  if (text == "1") return true;
  if (!text.empty() && text != "0") {
    Fail(column, Quoted(text) + " is not allowed, 0 or 1 is");
  }
  return false;
}

void TableReader::Fail(std::size_t column, const std::string& problem) const {
  throw InputError(Place(column), problem);
}

}  // namespace sarblock
