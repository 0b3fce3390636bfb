// SPDX-License-Identifier: Apache-2.0
#include "table.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
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

std::span<const TableDescription> TablesOf(FolderContent content) {
  static constexpr std::array<TableDescription, 5> kBlock{{{"trajectories", kPathColumns},
                                                           {"observations", kObservationColumns},
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
  static constexpr std::array<TableDescription, 2> kPart{
      {{"draws", kDrawColumns}, {"sums", kSumColumns}}};
  if (content == FolderContent::kBlock) return kBlock;
  if (content == FolderContent::kPart) return kPart;
  return kResult;
}

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

void WarnOfUnknownColumns(const TableReader& reader, std::vector<std::string>* warnings) {
  if (reader.unknown_columns().empty()) return;
  std::string names;
  for (const std::string& name : reader.unknown_columns()) {
    names += (names.empty() ? "" : ", ") + Quoted(name);
  }
  warnings->push_back(reader.file() + ": columns not known and ignored: " + names);
}

double PositiveNumber(const TableReader& reader, std::size_t column) {
  const double value = reader.Number(column);
  if (std::isnan(value)) return value;
  if (const char* problem = ProblemOfPositive(value)) {
    reader.Fail(column, NumberText(value) + problem);
  }
  return value;
}

void WriteRows(std::size_t count,
               std::size_t per_piece,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, TableWriter*)>& write) {
  using Part = std::unique_ptr<TableWriter>;
  if (count <= per_piece) {
    write(0, count, out);
    return;
  }
  std::vector<Part> free;  // parts that were appended, with their room
  std::mutex mutex;
  const auto next_free = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    if (free.empty()) return out->Part();
    Part part = std::move(free.back());
    free.pop_back();
    return part;
  };
  MakeInOrder<Part>(
      count,
      per_piece,
      [&](std::size_t begin, std::size_t end) {
        Part part = next_free();
        write(begin, end, part.get());
        part->EndPart();
        return part;
      },
      [&](Part* part) {
        out->Append(part->get());
        const std::lock_guard<std::mutex> lock(mutex);
        free.push_back(std::move(*part));
      });
}

void RefuseInfinity(double value, std::string_view file) {
  if (!std::isinf(value)) return;
  throw InputError(FilePlace{std::string(file), 0, ""},
                   "a number became infinite and cannot be written: something that was given is "
                   "too large or too small to compute with");
}

void TableSource::FailMissing(const std::string& file, const char* what) const {
  throw InputError(
      FilePlace{file, 0, ""},
      std::string("is missing, every ") + sarblock::NameOf(content_) + " has this " + what);
}

std::unique_ptr<TableReader> TableSource::Require(std::string_view table,
                                                  std::span<const TableColumn> columns) const {
  auto reader = Open(table, columns);
  if (!reader) FailMissing(NameOf(table), "table (or it as .csv.gz)");
  return reader;
}

}  // namespace sarblock
