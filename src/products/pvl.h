// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"

namespace sarblock {

/// `Name = value <unit>` of a label. A list is its values in order, inner lists one after another.
struct PvlKey {
  std::string name;
  std::vector<std::string> values;
  std::size_t inner_lists = 0;
  std::string unit;  ///< that of the last value
  std::size_t line = 0;
};

/// An object or a group of a label (Parameter Value Language as ISIS writes it). What is missing or
/// makes no sense throws InputError with file, line and path (`IsisCube.Instrument.StartTime`).
class PvlObject {
 public:
  [[nodiscard]] const PvlObject* Find(std::string_view name) const;
  [[nodiscard]] const PvlObject& Child(std::string_view name) const;
  [[nodiscard]] const std::vector<PvlObject>& children() const { return children_; }
  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] const PvlKey* FindKey(std::string_view name) const;
  [[nodiscard]] const PvlKey& Key(std::string_view name) const;
  [[nodiscard]] const std::vector<PvlKey>& keys() const { return keys_; }
  [[nodiscard]] std::string Text(std::string_view key) const;  ///< of a single value
  [[nodiscard]] double Number(std::string_view key) const;
  [[nodiscard]] double Positive(std::string_view key) const;
  /// An integer of `least` to 2^53.
  [[nodiscard]] std::uint64_t Count(std::string_view key, std::uint64_t least) const;
  [[nodiscard]] std::vector<double> Numbers(std::string_view key, std::size_t count) const;
  [[nodiscard]] double NumberOf(const PvlKey& key, std::size_t index) const;

  [[noreturn]] void Fail(std::string_view key, const std::string& problem) const;

 private:
  friend class PvlParser;
  std::string file_, name_, path_;
  std::size_t line_ = 0;
  std::vector<PvlKey> keys_;
  std::vector<PvlObject> children_;
};

/// Whether two names are equal without regard to case, as in labels.
[[nodiscard]] bool SameName(std::string_view a, std::string_view b);

/// The label at the beginning of a file, up to its line `End`; the root has no name. It is read in
/// pieces, 8 MiB at most.
[[nodiscard]] PvlObject ReadPvlLabel(ByteSource* source);

}  // namespace sarblock
