// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "hdf5_file.h"
#include "hdf5_tables.h"
#include "table.h"

namespace sarblock {
namespace {

/// That are kept of the texts of some rows; our chunks of texts have as many.
constexpr std::uint64_t kBytesAtOnce = std::uint64_t{1} << 20;
constexpr std::uint64_t kBytesOfPiece = std::uint64_t{1} << 17;  // where no chunk is inflated

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

}  // namespace

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

StoredTexts::StoredTexts(const OpenedHdf5& opened,
                         hid_t group,
                         const std::string& name,
                         std::string path)
    : opened_(opened), path_(std::move(path)) {
  if (!HasMember(opened, group, name, path_))
    opened.Fail(path_, "the dataset is missing, it holds texts");
  stored_ = OpenColumn(opened, group, name, path_);
  if (stored_.type != H5T_STRING || stored_.variable_text) {
    opened.Fail(path_, "is no dataset of strings of a fixed length, which is needed");
  }
  type_ = Hdf5Id(H5Dget_type(stored_.dataset.get()), H5Tclose);
  blanks_ = H5Tget_strpad(type_.get()) == H5T_STR_SPACEPAD;
  const Hdf5Id made(H5Dget_create_plist(stored_.dataset.get()), H5Pclose);
  deflated_ = H5Pget_nfilters(made.get()) > 0;
}

void StoredTexts::ReadPadded(std::uint64_t first,
                             std::uint64_t count,
                             std::vector<char>* characters) const {
  characters->resize(count * stored_.value_bytes);
  const hsize_t size = count;
  const Hdf5Id from = SelectRows(stored_.dataset.get(), first, count);
  const Hdf5Id to(H5Screate_simple(1, &size, nullptr), H5Sclose);
  if (!from.valid() || H5Dread(stored_.dataset.get(),
                               type_.get(),
                               to.get(),
                               from.get(),
                               H5P_DEFAULT,
                               characters->data()) < 0) {
    opened_.Fail(path_, "cannot be read, the file is damaged");
  }
}

std::string_view StoredTexts::Text(const std::vector<char>& characters, std::size_t which) const {
  const char* const begin = characters.data() + which * stored_.value_bytes;
  std::string_view text(begin, strnlen(begin, stored_.value_bytes));
  while (blanks_ && text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

void StoredTexts::ForEach(const std::function<void(std::string_view)>& take) const {
  const std::uint64_t at_once =
      std::max<std::uint64_t>(1, (deflated_ ? kBytesAtOnce : kBytesOfPiece) / stored_.value_bytes);
  std::vector<char> characters;
  for (std::uint64_t first = 0; first < stored_.count; first += at_once) {
    const std::uint64_t count = std::min(at_once, stored_.count - first);
    ReadPadded(first, count, &characters);
    for (std::size_t i = 0; i < count; ++i) take(Text(characters, i));
  }
}

const IdTable& StoredTexts::All() const {
  const std::lock_guard<std::mutex> lock(Hdf5Mutex());
  if (!all_) {
    IdTable all;
    ForEach([&all](std::string_view text) { all.Append(text); });
    all_ = std::make_unique<const IdTable>(std::move(all));
  }
  return *all_;
}

std::string_view TextsOfRows::Of(const StoredTexts& texts,
                                 std::span<const std::uint32_t> rows,
                                 std::uint32_t index) {
  if (kept_ == Kept::kNothing) Read(texts, rows);
  if (kept_ == Kept::kAll) return (*all_)[index];
  return texts.Text(characters_, index - first_);
}

void TextsOfRows::Read(const StoredTexts& texts, std::span<const std::uint32_t> rows) {
  const auto [least, greatest] = std::minmax_element(rows.begin(), rows.end());
  const std::uint64_t count = std::uint64_t{*greatest} - *least + 1;
  // Far apart or long: a table of all of them takes less. Deflated: every read inflates a chunk.
  if (texts.deflated_ || *greatest >= texts.size() || count > 2 * kSlabRows ||
      count > kBytesAtOnce / texts.stored_.value_bytes) {
    all_ = &texts.All();
    kept_ = Kept::kAll;
    return;
  }
  const std::lock_guard<std::mutex> lock(Hdf5Mutex());
  first_ = *least;
  texts.ReadPadded(first_, count, &characters_);
  kept_ = Kept::kThese;
}

StoredIds::Ids StoredIds::Of(CellKind kind) {
  const std::size_t which = kind == CellKind::kPass ? 0 : 1;
  const char* const name = which == 0 ? kPassIds : kPointIds;
  std::shared_ptr<const StoredTexts> texts = texts_[which].lock();
  if (!texts) {
    texts = std::make_shared<const StoredTexts>(
        opened_, opened_.file.get(), name, std::string("/") + name);
    texts_[which] = texts;
  }
  return {std::move(texts), &memo_[which]};
}

namespace {

namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The numbers of a slab none of which is given, one for all columns.
std::span<const double> NothingGiven() {
  static const std::vector<double> nothing(kSlabRows, kNan);
  return nothing;
}

/// A column of a table, and what its values are indices into.
struct StoredColumn {
  StoredDataset stored;
  CellKind kind = CellKind::kNumber;
  std::shared_ptr<const StoredTexts> texts;    // null: a column of numbers
  std::vector<std::uint32_t>* memo = nullptr;  // by text, of Lookup(); empty before
  std::vector<std::uint32_t> own_memo;
};

/// Values of a column in some rows.
struct Cells {
  ColumnBuffer<double> numbers;
  ColumnBuffer<std::uint32_t> indices;
  bool none = false;  // in any of the rows a number: `numbers` is empty
  mutable TextsOfRows texts;
  mutable std::string text;
};
using Slab = std::vector<Cells>;  // as columns were asked for

/// A table that is open.
struct StoredTable {
  const OpenedHdf5& opened;
  std::string path;  // of the group, with a slash at its end
  Hdf5Id group;
  std::string members;
  std::vector<StoredColumn> columns;  // as they were asked for
  std::size_t rows = 0;
  Pool<Slab> slabs;
};

class ContainerTable final : public TableReader {
 public:
  ContainerTable(const OpenedHdf5& opened,
                 StoredIds* ids,
                 std::string_view table,
                 std::span<const TableColumn> columns)
      : TableReader(opened.path + ": /" + std::string(table), columns),
        table_(new StoredTable{
            opened,
            "/" + std::string(table) + "/",
            Hdf5Id(H5Gopen2(opened.file.get(), std::string(table).c_str(), H5P_DEFAULT), H5Gclose),
            {},
            std::vector<StoredColumn>(columns.size()),
            0,
            {}}),
        slab_(table_->slabs.Borrow()) {
    slab_->resize(columns.size());
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
    *slab_ = Slab(slab_->size());  // what follows a table needs room
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
  /// The same table, at the same row, with nothing read of it.
  ContainerTable(const ContainerTable& whole)
      : TableReader(whole), table_(whole.table_), slab_(table_->slabs.Borrow()), end_(whole.end_) {
    slab_->resize(table_->columns.size());
  }

  std::string_view TextOf(std::size_t column) const override {
    const Cells& cells = (*slab_)[column];
    const StoredTexts* const texts = table_->columns[column].texts.get();
    if (texts != nullptr) return cells.texts.Of(*texts, Indices(column), Indices(column)[at_]);
    return TextOfNumber(numbers_[column][at_], &cells.text);
  }
  std::uint32_t IndexOfText(std::size_t column) const override {
    return HasTexts(column) ? Indices(column)[at_] : kUnknown;
  }
  std::uint32_t* Memo(std::size_t column) const override {
    return HasTexts(column) ? MemoOf(column) + Indices(column)[at_] : nullptr;
  }
  NumberedTexts TextsAhead(std::size_t column) const override {
    if (!HasTexts(column)) return {};
    return {Indices(column), table_->columns[column].texts->size()};
  }
  std::uint32_t* MemosAhead(std::size_t column) const override {
    return HasTexts(column) ? MemoOf(column) : nullptr;
  }
  std::string_view TextOfNumbered(std::size_t column, std::uint32_t text) const override {
    const Cells& cells = (*slab_)[column];
    return cells.texts.Of(*table_->columns[column].texts, Indices(column), text);
  }
  std::span<const double> CellsAhead(std::size_t column) const override {
    if (HasTexts(column)) return {};
    const std::size_t rows = slab_end_ - slab_begin_;
    if ((*slab_)[column].none) return NothingGiven().first(rows);
    return (*slab_)[column].numbers.first(rows);
  }
  bool IsUnstored(std::size_t column) const override { return (*slab_)[column].none; }
  std::span<const std::uint32_t> Indices(std::size_t column) const {
    return (*slab_)[column].indices.first(slab_end_ - slab_begin_);
  }
  bool HasTexts(std::size_t column) const {
    return Has(column) && table_->columns[column].texts != nullptr;
  }
  std::uint32_t* MemoOf(std::size_t column) const {
    const StoredColumn& stored = table_->columns[column];
    if (stored.memo->empty()) stored.memo->assign(stored.texts->size(), kUnknown);
    return stored.memo->data();
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
        StoredIds::Ids found = ids->Of(kind);
        cells.texts = std::move(found.texts);
        cells.memo = found.memo;
      } else {
        cells.texts =
            std::make_shared<const StoredTexts>(opened, group, values, table_->path + values);
        cells.memo = &cells.own_memo;
      }
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
    const std::lock_guard<std::mutex> lock(Hdf5Mutex());
    SilenceHdf5();
    slab_begin_ = line_;
    slab_end_ = std::min<std::size_t>(end_, line_ + kSlabRows);
    const hsize_t count = slab_end_ - slab_begin_;
    const Hdf5Id to(H5Screate_simple(1, &count, nullptr), H5Sclose);
    for (std::size_t i = 0; i < slab_->size(); ++i) {
      if (!Has(i)) continue;
      Cells& cells = (*slab_)[i];
      void* target = nullptr;
      const bool text = table_->columns[i].texts != nullptr;
      if (text) {
        cells.texts.Forget();
        cells.indices.MakeRoom(count, 0);
        target = cells.indices.data();
      } else if (!table_->columns[i].stored.none) {
        cells.numbers.MakeRoom(count, 0);
        target = cells.numbers.data();
        numbers_[i] = cells.numbers.data();
      }
      const StoredDataset& stored = table_->columns[i].stored;
      const hid_t type = text ? H5T_NATIVE_UINT32 : H5T_NATIVE_DOUBLE;
      const StoredRows there = ReadRows(stored, slab_begin_, count, to.get(), type, target);
      if (there == StoredRows::kDamaged) {
        table_->opened.Fail(table_->path + names_[i], "cannot be read, the file is damaged");
      }
      cells.none = !text && there == StoredRows::kNone;
      if (cells.none) {
        numbers_[i] = NothingGiven().data();
        continue;
      }
      // Counts and flags that are not given are -1 in the file.
      const CellKind kind = table_->columns[i].kind;
      if (!text && (kind == CellKind::kCount || kind == CellKind::kFlag)) {
        const std::span<double> numbers = cells.numbers.first(count);
        std::replace(numbers.begin(), numbers.end(), -1.0, kNan);
      }
    }
  }
  void CheckSlab() const {
    for (std::size_t i = 0; i < slab_->size(); ++i) {
      if (Has(i)) table_->columns[i].texts != nullptr ? CheckIndices(i) : CheckNumbers(i);
    }
  }
  void CheckIndices(std::size_t column) const {
    const std::span<const std::uint32_t> indices = Indices(column);
    const std::size_t texts = table_->columns[column].texts->size();
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] < texts) continue;
      throw InputError(PlaceAt(slab_begin_ + i + 1, column),
                       std::to_string(indices[i]) + " is not allowed, an index below " +
                           std::to_string(texts) + ", the number of its texts, is");
    }
  }
  void CheckNumbers(std::size_t column) const {
    const std::span<const double> numbers = CellsAhead(column);
    const auto infinite = std::find_if(
        numbers.begin(), numbers.end(), [](double value) { return std::isinf(value); });
    if (infinite == numbers.end()) return;
    const auto row = static_cast<std::size_t>(infinite - numbers.begin());
    throw InputError(PlaceAt(slab_begin_ + row + 1, column),
                     NumberText(*infinite) + " is not allowed, a finite number is");
  }

  std::shared_ptr<StoredTable> table_;  // parts have it too
  Pool<Slab>::Borrowed slab_;
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
  mutable std::array<std::shared_ptr<const StoredTexts>, 2> kept_;  // those that Ids() told
};

}  // namespace

std::unique_ptr<TableSource> TablesOfContainer(const fs::path& file, FolderContent content) {
  return std::make_unique<ContainerSource>(file, content);
}

}  // namespace sarblock
