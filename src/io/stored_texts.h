// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "block_ids.h"
#include "hdf5_input.h"
#include "table_columns.h"

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

}  // namespace sarblock
