// SPDX-License-Identifier: Apache-2.0
#include "container_reader.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "folder_content.h"
#include "hdf5_input.h"
#include "number.h"

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Whether chunks that are not stored read as numbers that are not given: NaN, or -1 of integers.
bool FillsWithNothing(hid_t creation, H5T_class_t type) {
  H5D_fill_value_t defined = H5D_FILL_VALUE_UNDEFINED;
  double fill = 0.0;
  if (type == H5T_STRING || H5Pfill_value_defined(creation, &defined) < 0 ||
      defined != H5D_FILL_VALUE_USER_DEFINED ||
      H5Pget_fill_value(creation, H5T_NATIVE_DOUBLE, &fill) < 0) {
    return false;
  }
  return type == H5T_FLOAT ? std::isnan(fill) : fill == -1.0;
}

/// A column of a table: all of its values stand in the file, or are said not to be given where they
/// do not.
StoredDataset OpenColumn(const OpenedHdf5& opened,
                         hid_t group,
                         const std::string& name,
                         const std::string& path) {
  StoredDataset column = OpenStored(opened, group, name, path, 1);
  if (!column.whole) {
    const Hdf5Id made(H5Dget_create_plist(column.dataset.get()), H5Pclose);
    if (!FillsWithNothing(made.get(), column.type)) {
      opened.Fail(
          path, "has " + std::to_string(column.count) + " rows, not all of which are in the file");
    }
  }
  return column;
}

/// Texts of equal length, padded with zeros or blanks.
IdTable ReadTexts(const OpenedHdf5& opened,
                  hid_t group,
                  const std::string& name,
                  const std::string& path) {
  if (!HasMember(opened, group, name, path))
    opened.Fail(path, "the dataset is missing, it holds texts");
  const StoredDataset column = OpenColumn(opened, group, name, path);
  if (column.type != H5T_STRING || column.variable_text) {
    opened.Fail(path, "is no dataset of strings of a fixed length, which is needed");
  }
  const Hdf5Id type(H5Dget_type(column.dataset.get()), H5Tclose);
  const bool blanks = H5Tget_strpad(type.get()) == H5T_STR_SPACEPAD;
  const std::uint64_t at_once =
      std::max<std::uint64_t>(1, (std::uint64_t{1} << 20) / column.value_bytes);
  std::vector<char> buffer;
  IdTable texts;
  for (std::uint64_t first = 0; first < column.count; first += at_once) {
    const hsize_t count = std::min(at_once, column.count - first);
    buffer.resize(count * column.value_bytes);
    const Hdf5Id from = SelectRows(column.dataset.get(), first, count);
    const Hdf5Id to(H5Screate_simple(1, &count, nullptr), H5Sclose);
    if (!from.valid() ||
        H5Dread(
            column.dataset.get(), type.get(), to.get(), from.get(), H5P_DEFAULT, buffer.data()) <
            0) {
      opened.Fail(path, "cannot be read, the file is damaged");
    }
    for (hsize_t i = 0; i < count; ++i) {
      std::string_view text(buffer.data() + i * column.value_bytes, column.value_bytes);
      text = text.substr(0, text.find('\0'));
      while (blanks && text.ends_with(' ')) text.remove_suffix(1);
      texts.Append(text);
    }
  }
  return texts;
}

/// Texts that columns are indices into, and what TableReader::Lookup() found for each.
struct StoredTexts {
  std::shared_ptr<const IdTable> texts;
  std::vector<std::uint32_t>* memo = nullptr;
};

/// Ids of passes and points. They are kept while a table needs them, what was found for them
/// longer.
class StoredIds {
 public:
  explicit StoredIds(const OpenedHdf5& opened) : opened_(opened) {}
  StoredTexts Of(CellKind kind) {
    const std::size_t which = kind == CellKind::kPass ? 0 : 1;
    const char* const name = which == 0 ? kPassIds : kPointIds;
    std::shared_ptr<const IdTable> texts = texts_[which].lock();
    if (!texts) {
      texts = std::make_shared<const IdTable>(
          ReadTexts(opened_, opened_.file.get(), name, std::string("/") + name));
      texts_[which] = texts;
    }
    memo_[which].resize(texts->size(), IdTable::kNone);
    return {std::move(texts), &memo_[which]};
  }

 private:
  const OpenedHdf5& opened_;
  std::array<std::weak_ptr<const IdTable>, 2> texts_;
  std::array<std::vector<std::uint32_t>, 2> memo_;
};

/// A column of a table, and what its values are indices into.
struct StoredColumn {
  StoredDataset stored;
  CellKind kind = CellKind::kNumber;
  StoredTexts stored_texts;
  const IdTable* texts = nullptr;  // null: a column of numbers
  std::vector<std::uint32_t> own_memo;
};

/// A table that is open.
struct StoredTable {
  const OpenedHdf5& opened;
  std::string path;  // of the group, with a slash at its end
  Hdf5Id group;
  std::string members;
  std::vector<StoredColumn> columns;  // as they were asked for
  std::size_t rows = 0;
};

class ContainerTable final : public TableReader {
 public:
  ContainerTable(const OpenedHdf5& opened,
                 StoredIds* ids,
                 std::string_view table,
                 std::span<const TableColumn> columns)
      : TableReader(opened.path + ": /" + std::string(table), columns),
        table_(std::make_shared<StoredTable>(StoredTable{
            opened,
            "/" + std::string(table) + "/",
            Hdf5Id(H5Gopen2(opened.file.get(), std::string(table).c_str(), H5P_DEFAULT), H5Gclose),
            {},
            std::vector<StoredColumn>(columns.size())})),
        slab_(columns.size()) {
    if (!table_->group.valid()) opened.Fail("/" + std::string(table), "is no group of datasets");
    ListMembers();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (HasMember(opened, table_->group.get(), names_[i], table_->path + names_[i]))
        OpenCells(i, columns[i].kind, ids);
    }
    RequireColumns(columns);
    end_ = table_->rows;
    // Columns without values take no room in the file: another one has to vouch for the rows.
    const auto vouches = [](const StoredColumn& column) {
      return column.stored.dataset.valid() && column.stored.whole;
    };
    if (end_ > 0 && std::none_of(table_->columns.begin(), table_->columns.end(), vouches)) {
      opened.Fail("/" + std::string(table),
                  "has " + std::to_string(end_) + " rows, of which no column is in the file");
    }
  }

  bool Next() override {
    if (line_ < end_) {
      if (line_ == slab_end_) ReadSlab();
      if (line_ == slab_begin_) CheckSlab();
      ++line_;
      at_ = line_ - 1 - slab_begin_;
      return true;
    }
    slab_ = std::vector<Cells>(slab_.size());  // what follows a table needs room
    return false;
  }
  std::unique_ptr<TableReader> Part() override {
    if (line_ == end_) return nullptr;
    std::unique_ptr<ContainerTable> part(new ContainerTable(*this));
    part->ReadSlab();
    part->end_ = part->slab_end_;
    line_ = part->end_;
    return part;
  }
  std::size_t RowCount() const override { return end_ - line_; }
  FilePlace PlaceAt(std::size_t line, std::size_t column) const override {
    std::string field = table_->path + names_[column];
    if (line > 0) field += "[" + std::to_string(line - 1) + "]";
    return {table_->opened.path, 0, std::move(field)};
  }
  std::string NameOfLine(std::size_t line) const override {
    return "row " + std::to_string(line - 1);
  }

 private:
  /// Values of the rows of a slab.
  struct Cells {
    std::vector<double> numbers;
    std::vector<std::uint32_t> indices;
    mutable std::string text;
  };

  /// The same table, at the same row, with nothing read of it.
  ContainerTable(const ContainerTable& whole)
      : TableReader(whole), table_(whole.table_), slab_(whole.slab_.size()), end_(whole.end_) {}

  std::string_view TextOf(std::size_t column) const override {
    const Cells& cells = slab_[column];
    const IdTable* const texts = table_->columns[column].texts;
    if (texts != nullptr) return (*texts)[cells.indices[at_]];
    return TextOfNumber(cells.numbers[at_], &cells.text);
  }
  std::uint32_t IndexOfText(std::size_t column) const override {
    return Has(column) && table_->columns[column].texts != nullptr ? slab_[column].indices[at_]
                                                                   : kUnknown;
  }
  std::uint32_t* Memo(std::size_t column) const override {
    const StoredColumn& stored = table_->columns[column];
    if (!Has(column) || stored.texts == nullptr) return nullptr;
    return &(*stored.stored_texts.memo)[slab_[column].indices[at_]];
  }
  NumberedTexts TextsAhead(std::size_t column) const override {
    const StoredColumn& stored = table_->columns[column];
    if (!Has(column) || stored.texts == nullptr) return {};
    return {slab_[column].indices, stored.texts, stored.stored_texts.memo->data()};
  }
  std::string ColumnsThere() const override { return "the group has " + table_->members; }

  void ListMembers() {
    const std::vector<std::string> all = MembersOf(table_->group.get());
    std::string& members = table_->members;
    for (const std::string& name : all) {
      if (name == kRowDimension || IsTexts(name, all)) continue;
      members += (members.empty() ? "" : ",") + name;
      if (std::find(names_.begin(), names_.end(), name) == names_.end()) unknown_.push_back(name);
    }
  }
  static bool IsTexts(const std::string& name, const std::vector<std::string>& all) {
    if (!name.ends_with(kValuesEnding)) return false;
    const std::string base = name.substr(0, name.size() - kValuesEnding.size());
    return std::find(all.begin(), all.end(), base) != all.end();
  }

  void OpenCells(std::size_t column, CellKind kind, StoredIds* ids) {
    const std::string& name = names_[column];
    const OpenedHdf5& opened = table_->opened;
    const hid_t group = table_->group.get();
    const std::string path = table_->path + name;
    StoredColumn& cells = table_->columns[column];
    cells.kind = kind;
    cells.stored = OpenColumn(opened, group, name, path);
    const bool integers = cells.stored.type == H5T_INTEGER;
    const std::string values = name + std::string(kValuesEnding);
    const bool known = kind == CellKind::kPass || kind == CellKind::kPoint;
    if (known || (kind == CellKind::kText && H5Lexists(group, values.c_str(), H5P_DEFAULT) > 0)) {
      if (!integers) opened.Fail(path, "holds no integers, indices into texts are needed");
      if (known) {
        cells.stored_texts = ids->Of(kind);
      } else {
        auto texts = ReadTexts(opened, group, values, table_->path + values);
        cells.own_memo.assign(texts.size(), kUnknown);
        cells.stored_texts = {std::make_shared<const IdTable>(std::move(texts)), &cells.own_memo};
      }
      cells.texts = cells.stored_texts.texts.get();
    } else if (!integers && cells.stored.type != H5T_FLOAT) {
      opened.Fail(path, "holds no numbers, which are needed");
    }
    if (first_ != kAbsent && cells.stored.count != table_->rows) {
      opened.Fail(path,
                  "has " + std::to_string(cells.stored.count) + " rows where " + table_->path +
                      names_[first_] + " has " + std::to_string(table_->rows) +
                      ", as many are needed");
    }
    if (first_ == kAbsent) first_ = column;
    table_->rows = cells.stored.count;
    place_[column] = column;
  }

  void ReadSlab() {
    slab_begin_ = line_;
    slab_end_ = std::min<std::size_t>(end_, line_ + kSlabRows);
    const hsize_t count = slab_end_ - slab_begin_;
    const Hdf5Id to(H5Screate_simple(1, &count, nullptr), H5Sclose);
    for (std::size_t i = 0; i < slab_.size(); ++i) {
      if (!Has(i)) continue;
      Cells& cells = slab_[i];
      const hid_t dataset = table_->columns[i].stored.dataset.get();
      const Hdf5Id from = SelectRows(dataset, slab_begin_, count);
      void* target = nullptr;
      const bool text = table_->columns[i].texts != nullptr;
      if (text) {
        cells.indices.resize(count);
        target = cells.indices.data();
      } else {
        cells.numbers.resize(count);
        target = cells.numbers.data();
        numbers_[i] = cells.numbers.data();
      }
      if (!from.valid() || H5Dread(dataset,
                                   text ? H5T_NATIVE_UINT32 : H5T_NATIVE_DOUBLE,
                                   to.get(),
                                   from.get(),
                                   H5P_DEFAULT,
                                   target) < 0) {
        table_->opened.Fail(table_->path + names_[i], "cannot be read, the file is damaged");
      }
    }
  }
  void CheckSlab() {
    for (std::size_t i = 0; i < slab_.size(); ++i) {
      if (Has(i)) table_->columns[i].texts != nullptr ? CheckIndices(i) : CheckNumbers(i);
    }
  }
  void CheckIndices(std::size_t column) const {
    const Cells& cells = slab_[column];
    const std::size_t texts = table_->columns[column].texts->size();
    for (std::size_t i = 0; i < cells.indices.size(); ++i) {
      if (cells.indices[i] < texts) continue;
      throw InputError(PlaceAt(slab_begin_ + i + 1, column),
                       std::to_string(cells.indices[i]) + " is not allowed, an index below " +
                           std::to_string(texts) + ", the number of its texts, is");
    }
  }
  /// Counts and flags that are not given are -1 in the file.
  void CheckNumbers(std::size_t column) {
    const CellKind kind = table_->columns[column].kind;
    const bool counts = kind == CellKind::kCount || kind == CellKind::kFlag;
    for (std::size_t i = 0; i < slab_[column].numbers.size(); ++i) {
      double& value = slab_[column].numbers[i];
      if (std::isinf(value)) {
        throw InputError(PlaceAt(slab_begin_ + i + 1, column),
                         NumberText(value) + " is not allowed, a finite number is");
      }
      if (counts && value == -1.0) value = kNan;
    }
  }

  std::shared_ptr<StoredTable> table_;  // parts have it too
  std::vector<Cells> slab_;
  std::size_t first_ = kAbsent;
  std::size_t end_ = 0;  // of the rows of this reader
  std::size_t slab_begin_ = 0, slab_end_ = 0;
};

class ContainerSource final : public TableSource {
 public:
  ContainerSource(const fs::path& file, FolderContent content)
      : TableSource(content), opened_(OpenHdf5(file)), ids_(opened_) {}
  std::pair<std::string, std::string> Read(std::string_view name) const override {
    const std::string attribute = AttributeOf(name);
    auto text = ReadTextAttribute(opened_, opened_.file.get(), attribute, attribute);
    if (!text) FailMissing(opened_.path + ": " + attribute, "attribute");
    return {opened_.path + ": " + attribute, std::move(*text)};
  }
  std::unique_ptr<TableReader> Open(std::string_view table,
                                    std::span<const TableColumn> columns) const override {
    if (!HasMember(opened_, opened_.file.get(), std::string(table), "/" + std::string(table)))
      return nullptr;
    return std::make_unique<ContainerTable>(opened_, &ids_, table, columns);
  }
  BlockIds Ids() const override {
    const auto keep = [this](CellKind kind, const char* name, auto* kept) {
      if (HasMember(opened_, opened_.file.get(), name, std::string("/") + name)) {
        *kept = ids_.Of(kind).texts;
      }
      return kept->get();
    };
    return {keep(CellKind::kPass, kPassIds, &kept_[0]),
            keep(CellKind::kPoint, kPointIds, &kept_[1])};
  }
  std::string NameOf(std::string_view table) const override {
    return opened_.path + ": /" + std::string(table);
  }
  std::string DefaultName() const override { return NameAt(opened_.path); }

 private:
  OpenedHdf5 opened_;
  mutable StoredIds ids_;
  mutable std::array<std::shared_ptr<const IdTable>, 2> kept_;  // those that Ids() told
};

}  // namespace

std::unique_ptr<TableSource> TablesOfContainer(const fs::path& file, FolderContent content) {
  return std::make_unique<ContainerSource>(file, content);
}

}  // namespace sarblock
