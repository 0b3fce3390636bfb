// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/atomic_file.h"

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "block_ids.h"
#include "hdf5_file.h"
#include "table_sink.h"

namespace sarblock {

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
