// SPDX-License-Identifier: Apache-2.0
#include "table.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"

namespace sarblock {

std::string_view UnitOfColumn(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kUnits{{{"m", "m"},
                                                                                 {"s", "s"},
                                                                                 {"mps", "m/s"},
                                                                                 {"m2", "m2"},
                                                                                 {"deg", "degree"},
                                                                                 {"hz", "Hz"},
                                                                                 {"px", "pixel"}}};
  const std::size_t at = name.rfind('_');
  for (const auto& [ending, unit] : kUnits) {
    if (at != name.npos && name.substr(at + 1) == ending) return unit;
  }
  return "1";
}

std::vector<TableColumn> AsTexts(Schema schema) {
  std::vector<TableColumn> texts(schema.begin(), schema.end());
  for (TableColumn& column : texts) column.kind = CellKind::kText;
  return texts;
}

std::span<const TableDescription> TablesOf(FolderContent content) {
  static constexpr std::array<TableDescription, 5> kBlock{{{"trajectories", kPathColumns},
                                                           {"observations", kLookColumns},
                                                           {"points", kPointColumns},
                                                           {"truth", kTruthColumns},
                                                           {"truth_passes", kPathColumns}}};
  static constexpr std::array<TableDescription, 11> kResult{
      {{"points", kResultPointColumns},
       {"passes", kParameterColumns},
       {"passes_covariance", kParameterCovarianceColumns},
       {"selection", kSelectionColumns},
       {"simplifications", kSimplificationColumns},
       {"strips", kStripColumns},
       {"residuals", kResidualColumns},
       {"control_quality", kControlColumns},
       {"pairs", kPairColumns},
       {"montecarlo", kMonteCarloColumns},
       {"trajectories", kPathColumns}}};
  if (content == FolderContent::kBlock) return kBlock;
  return kResult;
}

void Column::AppendText(std::string_view text) {
  // Most tables name their texts in the order of the rows before: these need no search.
  const std::uint32_t last = indices.empty() ? 0 : indices.back();
  for (const std::uint32_t next : {last, last + 1}) {
    if (next < own.size() && own[next] == text) {
      indices.push_back(next);
      return;
    }
  }
  indices.push_back(own.FindOrAppend(text));
}

void Column::SettleNumbers(std::string_view file) {
  bool infinite = false;
  for (double& value : numbers) {
    infinite |= std::isinf(value);
    if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
  }
  if (!infinite) return;
  throw InputError(FilePlace{std::string(file), 0, ""},
                   "a number became infinite and cannot be written: something that was given is "
                   "too large or too small to compute with");
}

void Batch::Begin(Schema schema) {
  rows = 0;
  line.clear();
  error = nullptr;
  columns.resize(schema.size());
  for (std::size_t i = 0; i < schema.size(); ++i) {
    Column& column = columns[i];
    column.numbers.clear();
    column.indices.clear();
    column.own = {};
    column.texts = IsText(schema[i].kind) ? &column.own : nullptr;
  }
}

void Batch::End() {
  for (Column& column : columns) {
    if (column.texts == nullptr || column.indices.size() == rows) continue;
    if (column.texts != &column.own) throw std::logic_error("a row has no id");
    while (column.indices.size() < rows) column.AppendText({});
  }
}

namespace {

constexpr std::uint64_t kUnreadableBits = 0x7ff8'0000'0000'c311u;

}  // namespace

double Row::Unreadable() { return std::bit_cast<double>(kUnreadableBits); }

bool Row::Given(std::size_t column) const {
  const Column& cells = batch_.columns[column];
  if (cells.texts != nullptr) return !Text(column).empty();
  const double value = cells.Number(row_);
  return !std::isnan(value) || std::bit_cast<std::uint64_t>(value) == kUnreadableBits;
}

double NumberOfText(std::string_view cell, CellKind kind) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const bool flag = kind == CellKind::kFlag;
  if ((flag && cell != "0" && cell != "1") || ParseNumber(cell, &value) != nullptr) {
    return Row::Unreadable();
  }
  return value;
}

const char* ProblemOfId(std::string_view id) {
  if (id.empty()) return "is empty, a name is needed";
  for (const char c : id) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f)
      return "the name holds a control character, which is not allowed";
  }
  return nullptr;
}

std::string_view Row::Id(std::size_t column) const {
  const std::string_view id = Text(column);
  if (const char* problem = ProblemOfId(id)) Fail(column, problem);
  return id;
}

void Row::RefuseUnreadable(std::size_t column, double value) const {
  if (std::bit_cast<std::uint64_t>(value) != kUnreadableBits) return;
  const std::string text = batch_.table->TextOfCell(*this, column);
  double ignored = 0.0;
  const char* const problem = ParseNumber(text, &ignored);
  Fail(column, MustBe(problem != nullptr ? problem : "0 or 1", Quoted(text)));
}

double Row::RequiredNumber(std::size_t column) const {
  const double value = Number(column);
  if (std::isnan(value)) Fail(column, "is empty, a number is needed");
  return value;
}

double Row::PositiveNumber(std::size_t column) const {
  const double value = Number(column);
  if (std::isnan(value)) return value;
  if (const char* problem = ProblemOfPositive(value))
    Fail(column, MustBe(problem, NumberText(value)));
  return value;
}

std::uint32_t Row::Count(std::size_t column) const {
  const double value = Number(column);
  if (std::isnan(value)) return 0;
  if (!(value >= 0.0 && value <= 4294967295.0 && value == std::floor(value))) {
    Fail(column, "must be an integer of 0 or more, got " + NumberText(value));
  }
  return static_cast<std::uint32_t>(value);
}

bool Row::Flag(std::size_t column) const {
  const double value = batch_.columns[column].Number(row_);
  if (value == 1.0) return true;
  if (!Given(column) || (value == 0.0 && !std::signbit(value))) return false;
  Fail(column, MustBe("0 or 1", Quoted(batch_.table->TextOfCell(*this, column))));
}

FilePlace Row::Place(std::size_t column) const { return batch_.table->PlaceAt(line(), column); }

void Row::Fail(std::size_t column, const std::string& problem) const {
  throw InputError(Place(column), problem);
}

TableReader::TableReader(std::string file, Schema schema)
    : file_(std::move(file)),
      schema_(schema.begin(), schema.end()),
      place_(schema.size(), kAbsent) {
  for (const TableColumn& column : schema) names_.emplace_back(column.name);
}

void TableReader::RequireColumn(std::size_t column) const {
  if (Has(column)) return;
  throw InputError(PlaceAt(0, column), "the column is missing; " + ColumnsThere());
}

void TableReader::RequireColumns() const {
  for (std::size_t i = 0; i < schema_.size(); ++i) {
    if (schema_[i].need == ColumnNeed::kRequired) RequireColumn(i);
  }
}

void WarnOfUnknownColumns(const TableReader& reader, std::vector<std::string>* warnings) {
  if (reader.unknown_columns().empty()) return;
  std::string names;
  for (const std::string& name : reader.unknown_columns()) {
    names += (names.empty() ? "" : ", ") + Quoted(name);
  }
  warnings->push_back(reader.file() + ": columns not known and ignored: " + names);
}

void WarnOfDoubts(const TableReader& reader, std::vector<std::string>* warnings) {
  for (const std::string& doubt : reader.doubts()) {
    warnings->push_back(reader.file() + ": " + doubt);
  }
}

void ForRows(TableReader* reader, const std::function<void(const Row&)>& take) {
  struct Nothing {};
  ForBatches<Nothing>(
      reader,
      [](Batch*, Nothing*) {},
      [&](Batch* batch, Nothing*) {
        for (std::size_t row = 0; row < batch->rows; ++row) take(Row(*batch, row));
      });
}

NewRow& NewRow::Text(std::size_t column, std::string_view text) {
  Column& cells = batch_.columns[column];
  while (cells.indices.size() < row_) cells.AppendText({});
  cells.AppendText(text);
  return *this;
}

NewRow& NewRow::Id(std::size_t column, const IdTable& ids, std::uint32_t index) {
  batch_.columns[column].texts = &ids;
  batch_.columns[column].indices.push_back(index);
  return *this;
}

TableWriter::TableWriter(Schema schema, std::span<const std::string_view> left_out)
    : schema_(schema.begin(), schema.end()) {
  for (std::size_t i = 0; i < schema.size(); ++i) {
    if (std::find(left_out.begin(), left_out.end(), schema[i].name) == left_out.end()) {
      written_.push_back(i);
    }
  }
}

void WriteRows(std::size_t count,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, Batch*)>& write,
               std::size_t per_piece) {
  MakeInOrder<Batch>(
      count,
      per_piece,
      [&](std::size_t begin, std::size_t end, Batch* batch) {
        batch->Begin(out->schema());
        batch->first = begin;
        write(begin, end, batch);
        batch->End();
        out->Format(batch);
      },
      [&](Batch* batch) { out->Write(batch); });
}

void TableSource::FailMissing(const std::string& file, const char* what) const {
  throw InputError(
      FilePlace{file, 0, ""},
      std::string("is missing, every ") + sarblock::NameOf(content_) + " has this " + what);
}

std::unique_ptr<TableReader> TableSource::Require(std::string_view table, Schema schema) const {
  auto reader = Open(table, schema);
  if (!reader) FailMissing(NameOf(table), "table (or it as .csv.gz)");
  return reader;
}

}  // namespace sarblock
