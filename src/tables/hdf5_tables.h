// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/tables/output.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hdf5_file.h"
#include "table.h"

namespace sarblock {

/// A column of a table: all of its values stand in the file, or are said not to be given where they
/// do not.
[[nodiscard]] StoredDataset OpenColumn(const OpenedHdf5& opened,
                                       hid_t group,
                                       const std::string& name,
                                       const std::string& path);

/// Texts that columns are indices into: a dataset of strings of equal length, padded with zeros or
/// blanks. They are read when they are asked for, also by several threads.
class StoredTexts final : public TextList {
 public:
  /// Refuses a dataset that is missing or holds anything else.
  StoredTexts(const OpenedHdf5& opened, hid_t group, const std::string& name, std::string path);
  [[nodiscard]] std::size_t size() const override { return stored_.count; }
  void ForEach(const std::function<void(std::string_view)>& take) const override;
  /// All of them, which are then kept.
  [[nodiscard]] const IdTable& All() const;

 private:
  friend class TextsOfRows;
  /// As they stand in the file, padded.
  void ReadPadded(std::uint64_t first, std::uint64_t count, std::vector<char>* characters) const;
  [[nodiscard]] std::string_view Text(const std::vector<char>& characters, std::size_t which) const;

  const OpenedHdf5& opened_;
  std::string path_;
  StoredDataset stored_;
  Hdf5Id type_;
  bool blanks_ = false, deflated_ = false;
  mutable std::unique_ptr<const IdTable> all_;
};

/// The texts of some rows: as most tables are in the order of their texts, these stand close
/// together, and only they are kept.
class TextsOfRows {
 public:
  /// The text of number `index`, one of `rows` and below texts.size(). The rows are the same ones
  /// until Forget().
  [[nodiscard]] std::string_view Of(const StoredTexts& texts,
                                    std::span<const std::uint32_t> rows,
                                    std::uint32_t index);
  void Forget() { kept_ = Kept::kNothing; }

 private:
  enum class Kept { kNothing, kThese, kAll };
  void Read(const StoredTexts& texts, std::span<const std::uint32_t> rows);

  Kept kept_ = Kept::kNothing;
  const IdTable* all_ = nullptr;
  std::uint32_t first_ = 0;
  std::vector<char> characters_;
};

/// Ids of passes and points of a file: open while a table needs them. What was found for them is
/// kept longer.
class StoredIds {
 public:
  explicit StoredIds(const OpenedHdf5& opened) : opened_(opened) {}
  struct Ids {
    std::shared_ptr<const StoredTexts> texts;
    std::vector<std::uint32_t>* memo = nullptr;  ///< of TableReader::Lookup(), empty before
  };
  [[nodiscard]] Ids Of(CellKind kind);

 private:
  const OpenedHdf5& opened_;
  std::array<std::weak_ptr<const StoredTexts>, 2> texts_;
  std::array<std::vector<std::uint32_t>, 2> memo_;
};

/// The tables of an HDF5 file (docs/container.md). Places in messages are those of h5py:
/// `x.h5: /observations/range_m[12]`, rows from 0. What a dataset claims is held against what is
/// stored of it before anything is allocated. Tables must not outlive the source.
[[nodiscard]] std::unique_ptr<TableSource> TablesOfContainer(const std::filesystem::path& file,
                                                             FolderContent content);

/// Writes the tables of a block or a result to one HDF5 file (docs/container.md), which appears
/// under its name at Commit(). Without one the destructor removes what was written.
class ContainerSink final : public TableSink {
 public:
  ContainerSink(const std::filesystem::path& target, Compression compression, const BlockIds& ids);
  ~ContainerSink() override;

  std::unique_ptr<TableWriter> Open(std::string_view table,
                                    std::span<const TableColumn> columns) override;
  void WriteText(std::string_view file, std::string_view text) override;
  std::optional<std::filesystem::path> folder() const override { return std::nullopt; }
  /// Writes the ids, closes and renames. Call once.
  void Commit();

  /// A list of texts that columns are indices into.
  struct Texts {
    IdTable own;
    const TextList* given = nullptr;  // columns are given indices into these
    std::uint32_t last = 0;           // of `own` that was asked for
    /// Index in `own`, where the text is put if it is new.
    [[nodiscard]] std::uint32_t IndexOf(std::string_view text);
  };
  [[nodiscard]] Texts* ids(CellKind kind) { return &ids_[kind == CellKind::kPass ? 0 : 1]; }
  /// A dataset of rows that are deflated where asked for; `rows` 0: as many as will come. Chunks
  /// that are not written read as `fill`, if there is one.
  [[nodiscard]] Hdf5Id CreateColumn(hid_t group,
                                    const std::string& name,
                                    hid_t type,
                                    std::uint64_t rows,
                                    std::uint64_t chunk_rows,
                                    std::optional<double> fill = {}) const;
  /// Texts as strings of equal length, a dimension with values of the name `name`.
  void WriteTexts(hid_t group, const std::string& name, const TextList& texts) const;
  void WriteAttribute(hid_t object, const std::string& name, std::string_view text) const;
  /// Whether values stand in the file as they are given: not deflated.
  [[nodiscard]] bool StoresAsGiven() const { return compression_ == Compression::kNone; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[noreturn]] void Fail(const std::string& problem) const;
  /// Throws where libhdf5 could not write: no space left.
  void Require(bool written) const;

 private:
  TemporaryName temporary_;
  std::string name_;
  Compression compression_;
  Hdf5Id file_;
  std::array<Texts, 2> ids_;  // of passes, of points
};

}  // namespace sarblock
