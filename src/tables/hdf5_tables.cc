// SPDX-License-Identifier: Apache-2.0
#include "hdf5_tables.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "hdf5_file.h"
#include <hdf5_hl.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kTextBytesAtOnce = std::size_t{1} << 20;
constexpr std::size_t kMaxTextBytes = std::size_t{1} << 32;
static_assert(kRowsAtOnce == kSlabRows);  // so that most batches are a chunk

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

/// A column of a table: all of its values are in the file, or said not to be given where they are
/// not.
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

/// Texts that columns are indices into: a dataset of strings of equal length, padded with zeros or
/// blanks. Refuses a dataset that is missing or holds anything else.
IdTable ReadTexts(const OpenedHdf5& opened,
                  hid_t group,
                  const std::string& name,
                  const std::string& path) {
  if (!HasMember(opened, group, name, path)) {
    opened.Fail(path, "the dataset is missing, it holds texts");
  }
  const StoredDataset stored = OpenColumn(opened, group, name, path);
  if (stored.type != H5T_STRING || stored.variable_text) {
    opened.Fail(path, "is no dataset of strings of a fixed length, which is needed");
  }
  const Hdf5Id type(H5Dget_type(stored.dataset.get()), H5Tclose);
  const bool blanks = H5Tget_strpad(type.get()) == H5T_STR_SPACEPAD;
  const std::size_t bytes = stored.value_bytes;
  const std::uint64_t at_once = std::max<std::uint64_t>(1, kTextBytesAtOnce / bytes);
  std::vector<char> characters;
  IdTable texts;
  for (std::uint64_t first = 0; first < stored.count; first += at_once) {
    const hsize_t count = std::min(at_once, stored.count - first);
    characters.resize(count * bytes);
    const Hdf5Id from = SelectRows(stored.dataset.get(), first, count);
    const Hdf5Id to(H5Screate_simple(1, &count, nullptr), H5Sclose);
    if (!from.valid() || H5Dread(stored.dataset.get(),
                                 type.get(),
                                 to.get(),
                                 from.get(),
                                 H5P_DEFAULT,
                                 characters.data()) < 0) {
      opened.Fail(path, "cannot be read, the file is damaged");
    }
    for (std::size_t i = 0; i < count; ++i) {
      const char* const begin = characters.data() + i * bytes;
      std::string_view text(begin, strnlen(begin, bytes));
      while (blanks && text.ends_with(' ')) text.remove_suffix(1);
      texts.Append(text);
    }
  }
  return texts;
}

/// A file open for reading, with the ids of its passes and points as long as a table needs them.
class OpenedTables {
 public:
  explicit OpenedTables(const fs::path& path) : file(OpenHdf5(path)) {}
  [[nodiscard]] std::shared_ptr<const IdTable> Ids(CellKind kind) {
    auto& kept = ids_[kind == CellKind::kPass ? 0 : 1];
    std::shared_ptr<const IdTable> ids = kept.lock();
    if (!ids) {
      const std::string name = kind == CellKind::kPass ? kPassIds : kPointIds;
      ids = std::make_shared<const IdTable>(ReadTexts(file, file.file.get(), name, "/" + name));
      kept = ids;
    }
    return ids;
  }
  OpenedHdf5 file;

 private:
  std::array<std::weak_ptr<const IdTable>, 2> ids_;
};

class ContainerReader final : public TableReader {
 public:
  ContainerReader(OpenedTables* tables, const std::string& table, Schema schema)
      : TableReader(tables->file.path + ": /" + table, schema),
        opened_(tables->file),
        path_("/" + table + "/"),
        group_(H5Gopen2(opened_.file.get(), table.c_str(), H5P_DEFAULT), H5Gclose),
        stored_(schema.size()),
        texts_(schema.size()) {
    if (!group_.valid()) opened_.Fail("/" + table, "is no group of datasets");
    ListMembers();
    for (std::size_t i = 0; i < schema.size(); ++i) {
      if (HasMember(opened_, group_.get(), names_[i], path_ + names_[i])) OpenCells(i, tables);
    }
    RequireColumns();
    // Columns without values take no room in the file: another one has to vouch for the rows.
    const auto vouches = [](const StoredDataset& column) {
      return column.dataset.valid() && column.whole;
    };
    if (rows_ > 0 && std::none_of(stored_.begin(), stored_.end(), vouches)) {
      opened_.Fail("/" + table,
                   "has " + std::to_string(rows_) + " rows, of which no column is in the file");
    }
  }

  bool Next(Batch* batch) override {
    if (next_ == rows_) return false;
    const std::lock_guard<std::mutex> lock(Hdf5Mutex());
    const QuietHdf5 quiet;
    batch->Begin(schema_);
    batch->table = this;
    batch->first = next_;
    batch->rows = std::min(rows_ - next_, kSlabRows);
    const hsize_t count = batch->rows;
    const Hdf5Id memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    for (std::size_t i = 0; i < schema_.size(); ++i) ReadCells(i, memory.get(), batch);
    next_ += batch->rows;
    return true;
  }
  std::size_t RowsLeft() const override { return rows_ - next_; }

  void Parse(Batch* batch) const override {
    for (std::size_t i = 0; i < schema_.size(); ++i) {
      Column& column = batch->columns[i];
      if (column.texts != nullptr) {
        CheckIndices(*batch, i);
        continue;
      }
      if (IsInteger(schema_[i].kind)) {  // those that are not given are -1 in the file
        std::replace(column.numbers.begin(), column.numbers.end(), -1.0, kNan);
      }
      CheckNumbers(*batch, i);
      if (!Has(i) || !IsText(schema_[i].kind)) continue;
      for (std::size_t row = 0; row < batch->rows; ++row) {  // texts are asked for
        column.AppendText(TextOfNumber(column.Number(row)));
      }
      column.numbers.clear();
      column.texts = &column.own;
    }
  }

  std::string TextOfCell(const Row& row, std::size_t column) const override {
    return TextOfNumber(row.batch().columns[column].Number(row.number()));
  }
  FilePlace PlaceAt(std::size_t line, std::size_t column) const override {
    std::string field = path_ + names_[column];
    if (line > 0) field += "[" + std::to_string(line - 1) + "]";
    return {opened_.path, 0, std::move(field)};
  }
  std::string NameOfLine(std::size_t line) const override {
    return "row " + std::to_string(line - 1);
  }

 private:
  static std::string TextOfNumber(double value) {
    return std::isnan(value) ? std::string() : NumberText(value);
  }

  void ListMembers() {
    const std::vector<std::string> all = MembersOf(group_.get());
    for (const std::string& name : all) {
      if (name == kRowDimension || HoldsTexts(name, all)) continue;
      members_ += (members_.empty() ? "" : ",") + name;
      if (std::find(names_.begin(), names_.end(), name) == names_.end()) unknown_.push_back(name);
    }
  }
  static bool HoldsTexts(const std::string& name, const std::vector<std::string>& all) {
    if (!name.ends_with(kValuesEnding)) return false;
    const std::string column = name.substr(0, name.size() - kValuesEnding.size());
    return std::find(all.begin(), all.end(), column) != all.end();
  }

  void OpenCells(std::size_t column, OpenedTables* tables) {
    const std::string path = path_ + names_[column];
    const std::string values = names_[column] + std::string(kValuesEnding);
    const CellKind kind = schema_[column].kind;
    StoredDataset& stored = stored_[column];
    stored = OpenColumn(opened_, group_.get(), names_[column], path);
    const bool integers = stored.type == H5T_INTEGER;
    const bool id = kind == CellKind::kPass || kind == CellKind::kPoint;
    if (id ||
        (kind == CellKind::kText && H5Lexists(group_.get(), values.c_str(), H5P_DEFAULT) > 0)) {
      if (!integers) opened_.Fail(path, "holds no integers, indices into texts are needed");
      texts_[column] = id ? tables->Ids(kind)
                          : std::make_shared<const IdTable>(
                                ReadTexts(opened_, group_.get(), values, path_ + values));
    } else if (!integers && stored.type != H5T_FLOAT) {
      opened_.Fail(path, "holds no numbers, which are needed");
    }
    if (!first_column_.empty() && stored.count != rows_) {
      opened_.Fail(path,
                   "has " + std::to_string(stored.count) + " rows where " + path_ + first_column_ +
                       " has " + std::to_string(rows_) + ", as many are needed");
    }
    if (first_column_.empty()) first_column_ = names_[column];
    rows_ = stored.count;
    place_[column] = column;
  }

  void ReadCells(std::size_t column, hid_t memory, Batch* batch) const {
    Column& cells = batch->columns[column];
    cells.texts = texts_[column].get();
    if (!Has(column)) return;
    void* values = nullptr;
    if (cells.texts != nullptr) {
      cells.indices.resize(batch->rows);
      values = cells.indices.data();
    } else if (!stored_[column].none) {
      cells.numbers.resize(batch->rows);
      values = cells.numbers.data();
    }
    const hid_t type = cells.texts != nullptr ? H5T_NATIVE_UINT32 : H5T_NATIVE_DOUBLE;
    const StoredRows found =
        ReadRows(stored_[column], batch->first, batch->rows, memory, type, values);
    if (found == StoredRows::kDamaged) {
      opened_.Fail(path_ + names_[column], "cannot be read, the file is damaged");
    }
    if (found == StoredRows::kNone) cells.numbers.clear();
  }

  static void CheckIndices(const Batch& batch, std::size_t column) {
    const Column& cells = batch.columns[column];
    const auto wrong =
        std::find_if(cells.indices.begin(), cells.indices.end(), [&](std::uint32_t index) {
          return index >= cells.texts->size();
        });
    if (wrong == cells.indices.end()) return;
    Row(batch, static_cast<std::size_t>(wrong - cells.indices.begin()))
        .Fail(column,
              "must be an index below " + std::to_string(cells.texts->size()) +
                  ", the number of its texts, got " + std::to_string(*wrong));
  }
  static void CheckNumbers(const Batch& batch, std::size_t column) {
    const std::vector<double>& numbers = batch.columns[column].numbers;
    const auto infinite = std::find_if(
        numbers.begin(), numbers.end(), [](double value) { return std::isinf(value); });
    if (infinite == numbers.end()) return;
    Row(batch, static_cast<std::size_t>(infinite - numbers.begin()))
        .Fail(column, "must be a finite number, got " + NumberText(*infinite));
  }
  std::string ColumnsThere() const override { return "the group has " + members_; }

  const OpenedHdf5& opened_;
  std::string path_;  // of the group, with a slash at its end
  Hdf5Id group_;
  std::string members_, first_column_;
  std::vector<StoredDataset> stored_;                  // by column
  std::vector<std::shared_ptr<const IdTable>> texts_;  // null: a column of numbers
  std::size_t rows_ = 0, next_ = 0;
};

class ContainerSource final : public TableSource {
 public:
  ContainerSource(const fs::path& file, FolderContent content)
      : TableSource(content), tables_(file) {}
  std::pair<std::string, std::string> Read(std::string_view name) const override {
    const OpenedHdf5& opened = tables_.file;
    const std::string attribute = AttributeOf(name);
    auto text = ReadTextAttribute(opened, opened.file.get(), attribute, attribute);
    if (!text) FailMissing(opened.path + ": " + attribute, "attribute");
    return {opened.path + ": " + attribute, std::move(*text)};
  }
  std::unique_ptr<TableReader> Open(std::string_view table, Schema schema) const override {
    const std::string name(table);
    if (!HasMember(tables_.file, tables_.file.file.get(), name, "/" + name)) return nullptr;
    return std::make_unique<ContainerReader>(&tables_, name, schema);
  }
  BlockIds Ids() const override {
    const auto keep = [this](CellKind kind, const std::string& name, auto* kept) {
      if (HasMember(tables_.file, tables_.file.file.get(), name, "/" + name)) {
        *kept = tables_.Ids(kind);
      }
      return kept->get();
    };
    return {keep(CellKind::kPass, kPassIds, &kept_[0]),
            keep(CellKind::kPoint, kPointIds, &kept_[1])};
  }
  std::string NameOf(std::string_view table) const override {
    return tables_.file.path + ": /" + std::string(table);
  }
  std::string DefaultName() const override { return NameAt(tables_.file.path); }

 private:
  mutable OpenedTables tables_;
  mutable std::array<std::shared_ptr<const IdTable>, 2> kept_;  // those that Ids() gave
};

}  // namespace

std::unique_ptr<TableSource> TablesOfContainer(const fs::path& file, FolderContent content) {
  return std::make_unique<ContainerSource>(file, content);
}

namespace {

/// What is in the file for a number that is not given.
double NotGivenOf(CellKind kind) { return IsInteger(kind) ? -1.0 : kNan; }

hid_t FileTypeOf(CellKind kind) {
  if (IsText(kind)) return H5T_STD_U32LE;
  if (kind == CellKind::kCount) return H5T_STD_I64LE;
  if (kind == CellKind::kFlag) return H5T_STD_I8LE;
  return H5T_IEEE_F64LE;
}

/// The tables of a block or a result in one HDF5 file (docs/container.md), which appears under its
/// name at Commit(). Without one the destructor removes what was written.
class ContainerSink final : public TableSink {
 public:
  ContainerSink(const fs::path& target, Compression compression, const BlockIds& ids);

  std::unique_ptr<TableWriter> Open(std::string_view table,
                                    Schema schema,
                                    std::span<const std::string_view> left_out) override;
  void WriteText(std::string_view file, std::string_view text) override {
    WriteAttribute(file_.get(), AttributeOf(file), text);
  }
  std::optional<fs::path> folder() const override { return std::nullopt; }
  /// Writes the ids, closes and renames. Call once.
  void Commit();

  /// Ids of passes or points, which columns are indices into.
  struct Ids {
    const IdTable* given = nullptr;
    IdTable found;  ///< where none are given: those of the tables
  };
  [[nodiscard]] Ids* IdsOf(CellKind kind) { return &ids_[kind == CellKind::kPass ? 0 : 1]; }
  /// A dataset of rows that are deflated where asked for; `rows` 0: as many as will come. Chunks
  /// that are not written read as `fill`, if there is one.
  [[nodiscard]] Hdf5Id CreateColumn(hid_t group,
                                    const std::string& name,
                                    hid_t type,
                                    std::uint64_t rows,
                                    std::uint64_t chunk_rows,
                                    std::optional<double> fill = {}) const;
  /// Values behind the first `first` of a dataset.
  void WriteValues(
      hid_t dataset, hid_t type, hsize_t first, hsize_t count, const void* values) const {
    const Hdf5Id from(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Id to = SelectRows(dataset, first, count);
    Require(H5Dwrite(dataset, type, from.get(), to.get(), H5P_DEFAULT, values) >= 0);
  }
  /// Texts as strings of equal length, a dimension with values of the name `name`.
  void WriteTexts(hid_t group, const std::string& name, const IdTable& texts) const;
  void WriteAttribute(hid_t object, const std::string& name, std::string_view text) const;
  /// Whether values are in the file as they are given: not deflated.
  [[nodiscard]] bool StoresAsGiven() const { return compression_ == Compression::kNone; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(FilePlace{name_, 0, ""}, problem);
  }
  /// Throws where libhdf5 could not write: no space left.
  void Require(bool written) const {
    const int error = disk_.error();
    if (written && error == 0) return;
    Fail(std::string("writing failed") +
         (error != 0 ? std::string(": ") + std::strerror(error) : ""));
  }

 private:
  OutputLock lock_;
  TemporaryName temporary_;
  std::string name_;
  Compression compression_;
  QuietHdf5 quiet_;
  FailingSafely disk_;
  Hdf5Id file_;
  std::array<Ids, 2> ids_;  // of passes, of points
};

class ContainerWriter final : public TableWriter {
 public:
  ContainerWriter(ContainerSink* sink,
                  Hdf5Id group,
                  Schema schema,
                  std::span<const std::string_view> left_out)
      : TableWriter(schema, left_out),
        sink_(sink),
        group_(std::move(group)),
        cells_(schema.size()) {}

  void Format(Batch* batch) const override {
    for (const std::size_t i : written_) {
      Column& column = batch->columns[i];
      if (column.texts != nullptr) continue;
      column.SettleNumbers(sink_->name());
      column.numbers.resize(batch->rows, kNan);
    }
  }

  void Write(Batch* batch) override {
    const std::lock_guard<std::mutex> lock(Hdf5Mutex());
    const QuietHdf5 quiet;
    for (const std::size_t i : written_) {
      if (batch->columns[i].texts != nullptr) NumberTexts(*batch, i, &batch->columns[i].indices);
    }
    if (kept_rows_ == 0 && batch->rows == kSlabRows) {  // a chunk as it is
      for (const std::size_t i : written_) {
        WriteColumn(i, batch->columns[i].numbers, batch->columns[i].indices, kSlabRows, kSlabRows);
      }
      rows_ += kSlabRows;
      return;
    }
    for (std::size_t begin = 0; begin < batch->rows;) {
      const std::size_t end = std::min(batch->rows, begin + kSlabRows - kept_rows_);
      const auto keep = [&](const auto& from, auto* to) {
        if (from.empty()) return;
        to->insert(to->end(),
                   from.begin() + static_cast<std::ptrdiff_t>(begin),
                   from.begin() + static_cast<std::ptrdiff_t>(end));
      };
      for (const std::size_t i : written_) {
        keep(batch->columns[i].numbers, &cells_[i].numbers);
        keep(batch->columns[i].indices, &cells_[i].indices);
      }
      kept_rows_ += end - begin;
      begin = end;
      if (kept_rows_ == kSlabRows) Flush(kSlabRows);
    }
  }

  // A table of one slab or less gets datasets of just its size, a longer one datasets that grow.
  void Commit() override {
    const std::uint64_t all = rows_ + kept_rows_;
    const bool begun = rows_ > 0;
    Flush(std::max<std::uint64_t>(1, kept_rows_));
    // A dimension without values, as netCDF-4 writes it.
    const Hdf5Id dimension =
        sink_->CreateColumn(group_.get(),
                            kRowDimension,
                            H5T_IEEE_F32BE,
                            begun ? 0 : all,
                            begun ? kSlabRows : std::max<std::uint64_t>(1, all));
    const hsize_t extent = all;
    sink_->Require(H5Dset_extent(dimension.get(), &extent) >= 0);
    std::string title = std::to_string(all);
    title.insert(0, 10 - std::min<std::size_t>(10, title.size()), ' ');
    title.insert(0, "This is a netCDF dimension but not a netCDF variable. ");
    sink_->Require(H5DSset_scale(dimension.get(), title.c_str()) >= 0);
    for (const std::size_t i : written_) {
      sink_->Require(H5DSattach_scale(cells_[i].dataset.get(), dimension.get(), 0) >= 0);
      Describe(i);
    }
  }

 private:
  /// A column of the file, with the rows that are not written yet.
  struct Cells {
    Hdf5Id dataset;
    std::vector<double> numbers;
    std::vector<std::uint32_t> indices;
    IdTable texts;  // of a column of text
    FoundTexts found;
  };

  /// Indices of texts of a batch become those of the file.
  void NumberTexts(const Batch& batch, std::size_t column, std::vector<std::uint32_t>* indices) {
    Cells& cells = cells_[column];
    IdTable* texts = &cells.texts;
    if (schema_[column].kind != CellKind::kText) {
      ContainerSink::Ids* const ids = sink_->IdsOf(schema_[column].kind);
      if (ids->given != nullptr && batch.columns[column].texts != ids->given) {
        throw std::logic_error("an id that is not one of the block's");
      }
      if (ids->given != nullptr) return;
      texts = &ids->found;
    }
    for (std::size_t row = 0; row < batch.rows; ++row) {
      const Row read(batch, row);
      (*indices)[row] =
          cells.found.Of(read, column, [&] { return texts->FindOrAppend(read.Text(column)); });
    }
  }

  /// Writes rows of a column behind those in the file: so many numbers or indices.
  void WriteColumn(std::size_t column,
                   const std::vector<double>& numbers,
                   const std::vector<std::uint32_t>& indices,
                   std::size_t rows,
                   std::uint64_t chunk_rows) {
    const CellKind kind = schema_[column].kind;
    Hdf5Id& dataset = cells_[column].dataset;
    if (!dataset.valid()) {
      dataset = sink_->CreateColumn(group_.get(),
                                    std::string(schema_[column].name),
                                    FileTypeOf(kind),
                                    chunk_rows == kSlabRows ? 0 : rows,
                                    chunk_rows,
                                    IsText(kind) ? std::nullopt : std::optional(NotGivenOf(kind)));
    }
    if (rows == 0) return;
    const hsize_t extent = rows_ + rows;
    sink_->Require(H5Dset_extent(dataset.get(), &extent) >= 0);
    const auto not_given = [](double value) { return std::isnan(value); };
    if (IsText(kind)) {
      Put(dataset.get(), H5T_NATIVE_UINT32, H5T_STD_U32LE, indices);
    } else if (std::all_of(numbers.begin(), numbers.end(), not_given)) {
      return;
    } else if (kind == CellKind::kCount) {
      Put(dataset.get(), H5T_NATIVE_INT64, H5T_STD_I64LE, AsIntegers<std::int64_t>(numbers));
    } else if (kind == CellKind::kFlag) {
      Put(dataset.get(), H5T_NATIVE_INT8, H5T_STD_I8LE, AsIntegers<std::int8_t>(numbers));
    } else {
      Put(dataset.get(), H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, numbers);
    }
  }
  template <typename Integer>
  static std::vector<Integer> AsIntegers(const std::vector<double>& numbers) {
    std::vector<Integer> integers;
    integers.reserve(numbers.size());
    for (const double value : numbers) {
      integers.push_back(std::isnan(value) ? Integer{-1} : static_cast<Integer>(value));
    }
    return integers;
  }
  template <typename Value>
  void Put(hid_t dataset, hid_t type, hid_t file_type, const std::vector<Value>& values) const {
    // A whole chunk needs nothing of libhdf5 but its place.
    if (values.size() == kSlabRows && rows_ % kSlabRows == 0 && sink_->StoresAsGiven() &&
        H5Tequal(file_type, type) > 0) {
      const hsize_t begin = rows_;
      sink_->Require(
          H5Dwrite_chunk(
              dataset, H5P_DEFAULT, 0, &begin, values.size() * sizeof(Value), values.data()) >= 0);
      return;
    }
    sink_->WriteValues(dataset, type, rows_, values.size(), values.data());
  }

  void Flush(std::uint64_t chunk_rows) {
    for (const std::size_t i : written_) {
      WriteColumn(i, cells_[i].numbers, cells_[i].indices, kept_rows_, chunk_rows);
      cells_[i].numbers.clear();
      cells_[i].indices.clear();
    }
    rows_ += kept_rows_;
    kept_rows_ = 0;
  }

  void Describe(std::size_t column) const {
    const std::string name(schema_[column].name);
    const CellKind kind = schema_[column].kind;
    const hid_t dataset = cells_[column].dataset.get();
    if (kind == CellKind::kNumber) {
      sink_->WriteAttribute(dataset, "units", UnitOfColumn(name));
    } else if (kind == CellKind::kText) {
      const std::string values = name + std::string(kValuesEnding);
      sink_->WriteTexts(group_.get(), values, cells_[column].texts);
      sink_->WriteAttribute(dataset, "index_of", values);
    } else if (IsText(kind)) {
      const char* const ids = kind == CellKind::kPass ? kPassIds : kPointIds;
      sink_->WriteAttribute(dataset, "index_of", std::string("/") + ids);
    }
  }

  ContainerSink* sink_;
  Hdf5Id group_;
  std::vector<Cells> cells_;  // by column of the schema
  std::size_t kept_rows_ = 0;
  std::uint64_t rows_ = 0;  // in the file
};

ContainerSink::ContainerSink(const fs::path& target, Compression compression, const BlockIds& ids)
    : lock_(target), temporary_(target), name_(target.string()), compression_(compression) {
  ids_[0].given = ids.passes;
  ids_[1].given = ids.points;
  const Hdf5Id access = disk_.Access();
  // From 1.10 on a chunk costs a number in memory, before a key of 33 dimensions.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_LATEST);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  const Hdf5Id creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_obj_track_times(creation.get(), 0);  // the same bytes whenever it is written
  file_ = Hdf5Id(H5Fcreate(temporary_.name().c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                 H5Fclose);
  if (!file_.valid()) {
    const int error = disk_.error();
    Fail("cannot be written" + (error != 0 ? std::string(": ") + std::strerror(error) : ""));
  }
  WriteAttribute(file_.get(), "written_by", std::string("sarblock ") + Version());
}

std::unique_ptr<TableWriter> ContainerSink::Open(std::string_view table,
                                                 Schema schema,
                                                 std::span<const std::string_view> left_out) {
  const Hdf5Id creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_obj_track_times(creation.get(), 0);
  Hdf5Id group(
      H5Gcreate2(file_.get(), std::string(table).c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
      H5Gclose);
  Require(group.valid());
  return std::make_unique<ContainerWriter>(this, std::move(group), schema, left_out);
}

void ContainerSink::Commit() {
  for (const CellKind kind : {CellKind::kPass, CellKind::kPoint}) {
    const Ids& ids = *IdsOf(kind);
    WriteTexts(file_.get(),
               kind == CellKind::kPass ? kPassIds : kPointIds,
               ids.given != nullptr ? *ids.given : ids.found);
  }
  Require(file_.Release() >= 0);
  temporary_.Commit();
}

Hdf5Id ContainerSink::CreateColumn(hid_t group,
                                   const std::string& name,
                                   hid_t type,
                                   std::uint64_t rows,
                                   std::uint64_t chunk_rows,
                                   std::optional<double> fill) const {
  const hsize_t extent = rows, chunk = chunk_rows;
  const bool grows = chunk_rows == kSlabRows && rows == 0;
  const hsize_t most = grows ? H5S_UNLIMITED : extent;
  const Hdf5Id space(H5Screate_simple(1, &extent, &most), H5Sclose);
  const Hdf5Id creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(creation.get(), 1, &chunk);
  // So that the rest of a last chunk is the same bytes in every run.
  H5Pset_fill_time(creation.get(), H5D_FILL_TIME_ALLOC);
  // Chunks without a value are not stored; readers find this in their place.
  if (fill) H5Pset_fill_value(creation.get(), H5T_NATIVE_DOUBLE, &*fill);
  H5Pset_attr_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  // libhdf5 notes the time otherwise, and the same tables would not be the same bytes.
  H5Pset_obj_track_times(creation.get(), 0);
  if (compression_ == Compression::kGzip) {
    H5Pset_shuffle(creation.get());
    H5Pset_deflate(creation.get(), 4);
  }
  const Hdf5Id access = ColumnAccess(0);
  Hdf5Id dataset(
      H5Dcreate2(group, name.c_str(), type, space.get(), H5P_DEFAULT, creation.get(), access.get()),
      H5Dclose);
  Require(dataset.valid());
  return dataset;
}

void ContainerSink::WriteTexts(hid_t group, const std::string& name, const IdTable& texts) const {
  std::size_t longest = 1;
  for (std::size_t i = 0; i < texts.size(); ++i) longest = std::max(longest, texts[i].size());
  if (longest > kMaxTextBytes / std::max<std::size_t>(1, texts.size())) {
    Fail("the texts of " + name + " need " + std::to_string(texts.size()) + " times " +
         std::to_string(longest) + " bytes, at most 4 GB are allowed: a shorter longest one is");
  }
  const Hdf5Id type = StringType(longest);
  const std::size_t at_once = std::max<std::size_t>(1, kTextBytesAtOnce / longest);
  const std::size_t chunk = std::max<std::size_t>(1, std::min(texts.size(), at_once));
  const Hdf5Id dataset = CreateColumn(group, name, type.get(), texts.size(), chunk);
  std::string padded;
  for (std::size_t first = 0; first < texts.size(); first += at_once) {
    const std::size_t count = std::min(at_once, texts.size() - first);
    padded.assign(count * longest, '\0');
    for (std::size_t i = 0; i < count; ++i) {
      texts[first + i].copy(padded.data() + i * longest, longest);
    }
    WriteValues(dataset.get(), type.get(), first, count, padded.data());
  }
  Require(H5DSset_scale(dataset.get(), name.c_str()) >= 0);
}

void ContainerSink::WriteAttribute(hid_t object,
                                   const std::string& name,
                                   std::string_view text) const {
  const std::string ended(text);
  const char* const value = ended.c_str();
  const Hdf5Id type = StringType(H5T_VARIABLE);
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Id attribute(
      H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  Require(attribute.valid() && H5Awrite(attribute.get(), type.get(), &value) >= 0);
}

}  // namespace

void WriteContainer(const fs::path& target,
                    Compression compression,
                    const BlockIds& ids,
                    const std::function<void(TableSink*)>& write) {
  ContainerSink sink(target, compression, ids);
  write(&sink);
  sink.Commit();
}

}  // namespace sarblock
