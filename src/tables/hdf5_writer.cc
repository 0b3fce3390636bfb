// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "hdf5_tables.h"
#include "table.h"
#include <hdf5_hl.h>

namespace sarblock {
namespace {

/// That a part has room for at first: it may have few, or fill a slab.
constexpr std::size_t kFirstRows = kSlabRows / 8;
constexpr std::size_t kMostTextBytes = std::size_t{1} << 32;

bool IsText(CellKind kind) {
  return kind == CellKind::kText || kind == CellKind::kPass || kind == CellKind::kPoint;
}

/// What stands in the file for a number that is not given.
std::optional<double> NotGivenOf(CellKind kind) {
  const bool counts = kind == CellKind::kCount || kind == CellKind::kFlag;
  return counts ? -1.0 : std::numeric_limits<double>::quiet_NaN();
}

hid_t FileTypeOf(CellKind kind) {
  if (IsText(kind)) return H5T_STD_U32LE;
  if (kind == CellKind::kCount) return H5T_STD_I64LE;
  if (kind == CellKind::kFlag) return H5T_STD_I8LE;
  return H5T_IEEE_F64LE;
}

class ContainerTableWriter final : public TableWriter {
 public:
  /// Without a group: a part, which keeps its rows.
  ContainerTableWriter(ContainerSink* sink, Hdf5Id group, std::span<const TableColumn> columns)
      : sink_(sink),
        group_(std::move(group)),
        columns_(columns.begin(), columns.end()),
        cells_(columns.size()) {
    numbers_.assign(columns.size(), nullptr);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      cells_[i].name = columns[i].name;
      cells_[i].kind = columns[i].kind;
      const bool text = columns[i].kind == CellKind::kText;
      if (IsText(columns[i].kind)) {
        ContainerSink::Texts* const ids = text ? nullptr : sink->ids(columns[i].kind);
        const bool own = text || (is_part() && ids->given == nullptr);
        cells_[i].texts = own ? &cells_[i].own_texts : ids;
      }
    }
  }

  TableWriter& Text(std::string_view text) override {
    Cells& cells = NextTexts();
    if (cells.texts->given != nullptr) throw std::logic_error("an id without its index");
    cells.indices.push_back(cells.texts->IndexOf(text));
    return *this;
  }
  TableWriter& Id(std::string_view text, std::uint32_t index) override {
    if (next_cell_ >= cells_.size() || cells_[next_cell_].texts == nullptr ||
        cells_[next_cell_].texts->given == nullptr) {
      return Text(text);
    }
    NextTexts().indices.push_back(index);
    return *this;
  }
  using TableWriter::Empty;
  TableWriter& Empty(std::size_t cells) override {
    for (std::size_t i = 0; i < cells; ++i) {
      const bool text = next_cell_ < cells_.size() && cells_[next_cell_].texts != nullptr;
      text ? Text("") : Number(std::nan(""));
    }
    return *this;
  }
  void EndRow() override {
    if (next_cell_ != cells_.size()) {
      throw std::logic_error("a row was about to be written with cells missing");
    }
    next_cell_ = 0;
    if (room_ == 0) MakeRoom(is_part() ? kFirstRows : kSlabRows);  // texts alone
    if (++kept_rows_ < room_) return;
    if (is_part()) {
      MakeRoom(kSlabRows / kFirstRows * room_);
    } else {
      EndPart();
      Flush(kSlabRows);
    }
  }
  std::unique_ptr<TableWriter> Part() override {
    return std::make_unique<ContainerTableWriter>(sink_, Hdf5Id(), columns_);
  }
  std::size_t rows_of_part() const override { return kSlabRows; }
  void EndPart() override {
    for (Cells& cells : cells_) {
      if (cells.texts == nullptr) Settle(&cells);
    }
  }
  void Append(TableWriter* part) override {
    const std::lock_guard<std::mutex> lock(Hdf5Mutex());
    SilenceHdf5();
    auto& rows = dynamic_cast<ContainerTableWriter&>(*part);
    std::vector<std::vector<std::uint32_t>> here(cells_.size());  // by text of the part: its index
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const IdTable& texts = rows.cells_[i].own_texts.own;
      for (std::size_t k = 0; k < texts.size(); ++k) {
        here[i].push_back(cells_[i].texts->IndexOf(texts[k]));
      }
    }
    if (kept_rows_ == 0 && rows.kept_rows_ == kSlabRows) {  // as they stand there
      std::vector<std::uint32_t> indices;
      for (std::size_t i = 0; i < cells_.size(); ++i) {
        const std::uint32_t* texts = rows.cells_[i].indices.data();
        if (!here[i].empty()) {
          indices.clear();
          for (const std::uint32_t text : rows.cells_[i].indices) indices.push_back(here[i][text]);
          texts = indices.data();
        }
        WriteColumn(&cells_[i], rows.cells_[i].Numbers(), texts, kSlabRows, kSlabRows);
      }
      rows_ += kSlabRows;
      rows.Clear();
      return;
    }
    for (std::size_t begin = 0; begin < rows.kept_rows_;) {
      if (room_ < kSlabRows) MakeRoom(kSlabRows);
      const std::size_t end = std::min(rows.kept_rows_, begin + kSlabRows - kept_rows_);
      for (std::size_t i = 0; i < cells_.size(); ++i) {
        cells_[i].Append(rows.cells_[i], begin, end, kept_rows_, here[i]);
      }
      kept_rows_ += end - begin;
      begin = end;
      if (kept_rows_ == kSlabRows) Flush(kSlabRows);
    }
    rows.Clear();
  }
  bool LendNumbers(std::size_t column, std::span<const double> values) override {
    if (cells_[column].texts != nullptr) return false;
    cells_[column].lent = values.data();
    return true;
  }
  std::uint32_t* IndicesOf(std::size_t column, std::size_t rows) override {
    Cells& cells = cells_[column];
    if (cells.texts == nullptr ||
        (cells.kind != CellKind::kText && cells.texts->given == nullptr)) {
      return nullptr;
    }
    cells.indices.resize(rows);
    return cells.indices.data();
  }
  std::uint32_t IndexOf(std::size_t column, std::string_view text) override {
    return cells_[column].own_texts.IndexOf(text);
  }
  void EndRows(std::size_t rows) override { kept_rows_ = rows; }
  void Commit() override {
    const std::uint64_t all = rows_ + kept_rows_;
    const bool begun = rows_ > 0;
    EndPart();
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
    for (Cells& cells : cells_) {
      sink_->Require(H5DSattach_scale(cells.dataset.get(), dimension.get(), 0) >= 0);
      Describe(cells);
    }
  }

 protected:
  void PutNumber(double value) override {
    if (next_cell_ < cells_.size() && cells_[next_cell_].texts != nullptr) {
      throw std::logic_error("a number in a column of texts");
    }
    RequireCell();
    MakeRoom(is_part() ? kFirstRows : kSlabRows);
    Number(value);
  }
  void PutInteger(std::int64_t value) override { PutNumber(static_cast<double>(value)); }

 private:
  struct Cells {
    std::string name;
    CellKind kind = CellKind::kNumber;
    ContainerSink::Texts own_texts;
    ContainerSink::Texts* texts = nullptr;
    ColumnBuffer<double> numbers;
    const double* lent = nullptr;  // stand in their place
    std::vector<std::uint32_t> indices;
    Hdf5Id dataset;

    [[nodiscard]] const double* Numbers() const { return lent != nullptr ? lent : numbers.data(); }

    /// Rows [begin, end) of a part behind `kept` rows; `here` are the indices of its own texts.
    void Append(const Cells& part,
                std::size_t begin,
                std::size_t end,
                std::size_t kept,
                const std::vector<std::uint32_t>& here) {
      const auto first = static_cast<std::ptrdiff_t>(begin);
      const auto last = static_cast<std::ptrdiff_t>(end);
      if (texts == nullptr) {
        std::copy(part.Numbers() + first, part.Numbers() + last, numbers.data() + kept);
      } else if (here.empty()) {
        indices.insert(indices.end(), part.indices.begin() + first, part.indices.begin() + last);
      } else {
        for (std::size_t row = begin; row < end; ++row) indices.push_back(here[part.indices[row]]);
      }
    }
  };

  void Clear() {
    kept_rows_ = 0;
    for (Cells& cells : cells_) {
      cells.lent = nullptr;
      cells.indices.clear();
      cells.own_texts = {};
    }
  }
  [[nodiscard]] bool is_part() const { return !group_.valid(); }

  void RequireCell() const {
    if (next_cell_ >= cells_.size()) throw std::logic_error("a row has more cells than columns");
  }
  Cells& NextTexts() {
    RequireCell();
    Cells& cells = cells_[next_cell_++];
    if (cells.texts == nullptr) throw std::logic_error("a text in a column of numbers");
    return cells;
  }
  void MakeRoom(std::size_t rows) {
    room_ = rows;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].texts != nullptr) {
        cells_[i].indices.reserve(rows);
        continue;
      }
      cells_[i].numbers.MakeRoom(rows, kept_rows_);
      numbers_[i] = cells_[i].numbers.data();
    }
  }
  /// Numbers as they are stored: one NaN of all that there are.
  void Settle(Cells* cells) const {
    double infinite = 0.0;
    for (double& value : cells->numbers.first(kept_rows_)) {
      infinite = std::isinf(value) ? value : infinite;
      value = std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value;
    }
    RefuseInfinity(infinite, sink_->name());
  }

  /// Writes rows of a column behind those in the file: so many numbers or indices.
  void WriteColumn(Cells* column,
                   const double* numbers,
                   const std::uint32_t* indices,
                   std::size_t rows,
                   std::uint64_t chunk_rows) {
    Cells& cells = *column;
    const bool text = cells.texts != nullptr;
    const hsize_t count = rows, extent = rows_ + count;
    if (!cells.dataset.valid()) {
      cells.dataset = sink_->CreateColumn(group_.get(),
                                          cells.name,
                                          FileTypeOf(cells.kind),
                                          chunk_rows == kSlabRows ? 0 : count,
                                          chunk_rows,
                                          text ? std::nullopt : NotGivenOf(cells.kind));
    }
    if (count == 0) return;
    sink_->Require(H5Dset_extent(cells.dataset.get(), &extent) >= 0);
    const auto not_given = [](double value) { return std::isnan(value); };
    if (!text && std::all_of(numbers, numbers + rows, not_given)) return;
    const Stored stored = text ? Stored{H5T_NATIVE_UINT32, sizeof(std::uint32_t), indices}
                               : AsStored(cells.kind, {numbers, rows});
    // A whole chunk needs nothing of libhdf5 but its place.
    const hid_t of_file = FileTypeOf(cells.kind);
    if (count == kSlabRows && rows_ % kSlabRows == 0 && sink_->StoresAsGiven() &&
        H5Tequal(of_file, stored.type) > 0) {
      const hsize_t begin = rows_;
      sink_->Require(H5Dwrite_chunk(cells.dataset.get(),
                                    H5P_DEFAULT,
                                    0,
                                    &begin,
                                    count * stored.value_bytes,
                                    stored.values) >= 0);
      return;
    }
    const Hdf5Id from(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Id to = SelectRows(cells.dataset.get(), rows_, count);
    sink_->Require(
        H5Dwrite(
            cells.dataset.get(), stored.type, from.get(), to.get(), H5P_DEFAULT, stored.values) >=
        0);
  }

  /// Values of a type of the file, in the order of bytes of this machine.
  struct Stored {
    hid_t type;
    std::size_t value_bytes;
    const void* values;
  };
  Stored AsStored(CellKind kind, std::span<const double> numbers) {
    const auto with_absent = [&](auto* integers) {
      integers->clear();
      for (const double value : numbers) {
        using Integer = typename std::remove_reference_t<decltype(*integers)>::value_type;
        integers->push_back(std::isnan(value) ? Integer{-1} : static_cast<Integer>(value));
      }
      return integers->data();
    };
    if (kind == CellKind::kCount) return {H5T_NATIVE_INT64, 8, with_absent(&counts_)};
    if (kind == CellKind::kFlag) return {H5T_NATIVE_INT8, 1, with_absent(&flags_)};
    return {H5T_NATIVE_DOUBLE, sizeof(double), numbers.data()};
  }

  // A table of one slab or less gets datasets of just its size, a longer one datasets that grow.
  void Flush(std::uint64_t chunk_rows) {
    for (Cells& cells : cells_) {
      WriteColumn(&cells, cells.numbers.data(), cells.indices.data(), kept_rows_, chunk_rows);
      cells.indices.clear();
    }
    rows_ += kept_rows_;
    kept_rows_ = 0;
  }

  void Describe(const Cells& cells) {
    const hid_t dataset = cells.dataset.get();
    if (cells.kind == CellKind::kNumber) {
      sink_->WriteAttribute(dataset, "units", UnitOfColumn(cells.name));
    } else if (cells.kind == CellKind::kText) {
      const std::string values = cells.name + std::string(kValuesEnding);
      sink_->WriteTexts(group_.get(), values, TextsOfTable(cells.own_texts.own));
      sink_->WriteAttribute(dataset, "index_of", values);
    } else if (cells.kind == CellKind::kPass || cells.kind == CellKind::kPoint) {
      const char* const ids = cells.kind == CellKind::kPass ? kPassIds : kPointIds;
      sink_->WriteAttribute(dataset, "index_of", std::string("/") + ids);
    }
  }

  ContainerSink* sink_;
  Hdf5Id group_;
  std::vector<TableColumn> columns_;
  std::vector<Cells> cells_;
  std::vector<std::int64_t> counts_;  // of a column that is being written
  std::vector<std::int8_t> flags_;
  std::size_t room_ = 0;    // rows that the columns have room for
  std::uint64_t rows_ = 0;  // in the file
};

}  // namespace

std::uint32_t ContainerSink::Texts::IndexOf(std::string_view text) {
  // Most tables name their texts in the order of the one before: neither needs a search.
  for (const std::uint32_t next : {last, last + 1}) {
    if (next < own.size() && own[next] == text) return last = next;
  }
  return last = own.FindOrAppend(text);
}

ContainerSink::ContainerSink(const std::filesystem::path& target,
                             Compression compression,
                             const BlockIds& ids)
    : temporary_(target), name_(target.string()), compression_(compression) {
  SilenceHdf5();
  ids_[0].given = ids.passes;
  ids_[1].given = ids.points;
  if (target.has_parent_path()) MakeFolder(target.parent_path());
  RemoveAbandoned(target);
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // From 1.10 on a chunk costs a number in memory, before a key of 33 dimensions.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_LATEST);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  const Hdf5Id creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_obj_track_times(creation.get(), 0);  // the same bytes whenever it is written
  errno = 0;
  file_ = Hdf5Id(H5Fcreate(temporary_.name().c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                 H5Fclose);
  if (!file_.valid()) {
    Fail("cannot be written" + (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
  }
  WriteAttribute(file_.get(), "written_by", std::string("sarblock ") + Version());
}

ContainerSink::~ContainerSink() = default;

std::unique_ptr<TableWriter> ContainerSink::Open(std::string_view table,
                                                 std::span<const TableColumn> columns) {
  const Hdf5Id creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_obj_track_times(creation.get(), 0);
  Hdf5Id group(
      H5Gcreate2(file_.get(), std::string(table).c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
      H5Gclose);
  Require(group.valid());
  return std::make_unique<ContainerTableWriter>(this, std::move(group), columns);
}

void ContainerSink::WriteText(std::string_view file, std::string_view text) {
  WriteAttribute(file_.get(), AttributeOf(file), text);
}

void ContainerSink::Commit() {
  for (const char* name : {kPassIds, kPointIds}) {
    const Texts& texts = ids_[name == kPassIds ? 0 : 1];
    const TextsOfTable own(texts.own);
    WriteTexts(file_.get(), name, texts.given != nullptr ? *texts.given : own);
  }
  errno = 0;
  if (file_.Release() < 0) Require(false);
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

void ContainerSink::WriteTexts(hid_t group, const std::string& name, const TextList& texts) const {
  std::size_t longest = 1;
  texts.ForEach([&](std::string_view text) { longest = std::max(longest, text.size()); });
  if (longest > kMostTextBytes / std::max<std::size_t>(1, texts.size())) {
    Fail("the texts of " + name + " need " + std::to_string(texts.size()) + " times " +
         std::to_string(longest) + " bytes, at most 4 GB are allowed: a shorter longest one is");
  }
  const Hdf5Id type = StringType(longest);
  const std::size_t at_once = std::max<std::size_t>(1, (std::size_t{1} << 20) / longest);
  const std::size_t chunk = std::max<std::size_t>(1, std::min(texts.size(), at_once));
  const Hdf5Id dataset = CreateColumn(group, name, type.get(), texts.size(), chunk);
  std::string buffer;
  std::size_t written = 0;
  const auto write = [&] {
    const hsize_t count = buffer.size() / longest;
    const Hdf5Id from(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Id to = SelectRows(dataset.get(), written, count);
    Require(H5Dwrite(dataset.get(), type.get(), from.get(), to.get(), H5P_DEFAULT, buffer.data()) >=
            0);
    written += count;
    buffer.clear();
  };
  texts.ForEach([&](std::string_view text) {
    buffer += text;
    buffer.append(longest - text.size(), '\0');
    if (buffer.size() == at_once * longest) write();
  });
  if (!buffer.empty()) write();
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

void ContainerSink::Fail(const std::string& problem) const {
  throw InputError(FilePlace{name_, 0, ""}, problem);
}

void ContainerSink::Require(bool written) const {
  if (written) return;
  Fail(std::string("writing failed") +
       (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
}

}  // namespace sarblock
