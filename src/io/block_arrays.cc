// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/block_arrays.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "block_reader.h"
#include "core/text.h"

namespace sarblock {
namespace {

/// By texts, what TableReader::Lookup() found for each.
using TextMemos = std::map<const IdTable*, std::vector<std::uint32_t>>;

class ArrayReader final : public TableReader {
 public:
  ArrayReader(const ArrayTable& table, std::span<const TableColumn> columns, TextMemos* memos)
      : TableReader(table.name, columns),
        table_(table),
        end_(table.columns.empty() ? 0 : table.columns.front().rows()),
        columns_(columns.size()),
        memos_(columns.size()),
        buffers_(columns.size()) {
    for (const ArrayColumn& column : table.columns) {
      const auto asked = std::find(names_.begin(), names_.end(), column.name);
      if (asked == names_.end()) {
        unknown_.push_back(column.name);
        continue;
      }
      OpenColumn(static_cast<std::size_t>(asked - names_.begin()), column, columns, memos);
    }
    RequireColumns(columns);
  }

  bool Next() override {
    if (line_ == end_) return false;
    at_ = line_++;
    return true;
  }
  std::unique_ptr<TableReader> Part() override {
    if (line_ == end_) return nullptr;
    auto part = std::make_unique<ArrayReader>(*this);
    part->end_ = std::min(end_, line_ + kPartRows);
    line_ = part->end_;
    return part;
  }
  std::size_t RowCount() const override { return end_ - line_; }
  FilePlace PlaceAt(std::size_t line, std::size_t column) const override {
    std::string field = file_ + "." + names_[column];
    if (line > 0) field += "[" + std::to_string(line - 1) + "]";
    return {{}, 0, std::move(field)};
  }
  std::string NameOfLine(std::size_t line) const override {
    return "row " + std::to_string(line - 1);
  }

 private:
  static constexpr std::size_t kPartRows = 16384;

  void OpenColumn(std::size_t index,
                  const ArrayColumn& column,
                  std::span<const TableColumn> columns,
                  TextMemos* memos) {
    const FilePlace place = PlaceAt(0, index);
    if (Has(index)) throw InputError(place, "stands twice, one column is allowed");
    if (column.rows() != RowCount()) {
      throw InputError(place,
                       "has " + std::to_string(column.rows()) + " rows where " + file_ + "." +
                           table_.columns.front().name + " has " + std::to_string(RowCount()) +
                           ", as many are needed");
    }
    columns_[index] = &column;
    place_[index] = index;
    if (column.texts != nullptr) {
      memos_[index] = &(*memos)[column.texts.get()];
      memos_[index]->resize(column.texts->size(), kUnknown);
      for (std::size_t row = 0; row < column.indices.size(); ++row) {
        if (column.indices[row] < column.texts->size()) continue;
        throw InputError(PlaceAt(row + 1, index),
                         std::to_string(column.indices[row]) + " is not allowed, an index below " +
                             std::to_string(column.texts->size()) + ", the number of texts, is");
      }
      return;
    }
    const CellKind kind = columns[index].kind;
    if (kind == CellKind::kPass || kind == CellKind::kPoint || kind == CellKind::kText) {
      throw InputError(place, "holds numbers, texts are needed");
    }
    for (std::size_t row = 0; row < column.cells.size(); ++row) {
      if (!std::isinf(column.cells[row])) continue;
      throw InputError(PlaceAt(row + 1, index),
                       NumberText(column.cells[row]) + " is not allowed, a finite number is");
    }
    numbers_[index] = column.cells.data();
  }

  std::string_view TextOf(std::size_t column) const override {
    const ArrayColumn& cells = *columns_[column];
    if (cells.texts != nullptr) return (*cells.texts)[cells.indices[at_]];
    return TextOfNumber(cells.cells[at_], &buffers_[column]);
  }
  std::uint32_t* Memo(std::size_t column) const override {
    if (!Has(column) || memos_[column] == nullptr) return nullptr;
    return &(*memos_[column])[columns_[column]->indices[at_]];
  }
  NumberedTexts TextsAhead(std::size_t column) const override {
    if (!Has(column) || memos_[column] == nullptr) return {};
    const ArrayColumn& cells = *columns_[column];
    return {cells.indices.subspan(line_, end_ - line_), cells.texts->size()};
  }
  std::uint32_t* MemosAhead(std::size_t column) const override {
    return Has(column) && memos_[column] != nullptr ? memos_[column]->data() : nullptr;
  }
  std::string_view TextOfNumbered(std::size_t column, std::uint32_t text) const override {
    return (*columns_[column]->texts)[text];
  }
  std::span<const double> CellsAhead(std::size_t column) const override {
    const ArrayColumn& cells = *columns_[column];
    if (cells.texts != nullptr) return {};
    return cells.cells.subspan(line_, end_ - line_);
  }
  std::string ColumnsThere() const override {
    std::string text = "there are ";
    for (const ArrayColumn& column : table_.columns) {
      text += (&column == &table_.columns.front() ? "" : ",") + column.name;
    }
    return text;
  }

  const ArrayTable& table_;
  std::size_t end_;                                 // of the rows of this reader
  std::vector<const ArrayColumn*> columns_;         // by asked column; null: not there
  std::vector<std::vector<std::uint32_t>*> memos_;  // null: numbers
  mutable std::vector<std::string> buffers_;
};

class ArraySource final : public TableSource {
 public:
  explicit ArraySource(const BlockArrays& arrays)
      : TableSource(FolderContent::kBlock), arrays_(arrays) {}
  std::pair<std::string, std::string> Read(std::string_view file) const override {
    return {std::string(file), std::string(arrays_.block_toml)};
  }
  std::unique_ptr<TableReader> Open(std::string_view table,
                                    std::span<const TableColumn> columns) const override {
    for (const ArrayTable& held : arrays_.tables) {
      if (held.name == table) return std::make_unique<ArrayReader>(held, columns, &memos_);
    }
    return nullptr;
  }
  std::string NameOf(std::string_view table) const override { return std::string(table); }
  std::string DefaultName() const override { return "block"; }

 private:
  const BlockArrays& arrays_;
  mutable TextMemos memos_;
};

}  // namespace

BlockFile ReadBlockArrays(const BlockArrays& arrays, const ReadOptions& options) {
  return ReadBlockFrom(ArraySource(arrays), options);
}

}  // namespace sarblock
