// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <toml++/toml.h>

namespace sarblock {

/// A value of a TOML file with its dotted key. What has the wrong type or is not allowed throws
/// InputError with file, line and key.
class TomlValue {
 public:
  TomlValue(const toml::node& node, std::string key) : node_(&node), key_(std::move(key)) {}

  [[nodiscard]] const std::string& key() const { return key_; }
  [[nodiscard]] const toml::node& node() const { return *node_; }
  [[nodiscard]] bool IsNumber() const { return node_->is_number(); }
  [[nodiscard]] bool IsText() const { return node_->is_string(); }
  [[nodiscard]] bool IsArray() const { return node_->is_array(); }

  [[nodiscard]] std::string Text() const;
  [[nodiscard]] bool Flag() const;      ///< true or false
  [[nodiscard]] double Number() const;  ///< integer or real, finite
  [[nodiscard]] double Positive() const;
  [[nodiscard]] int Integer(int lowest, int highest) const;
  [[nodiscard]] std::uint64_t Count() const;             ///< an integer of 0 or more
  [[nodiscard]] std::vector<TomlValue> Entries() const;  ///< of an array, keys `key[0]`, ...
  /// Index of the text in `names`; refuses others, naming all and the nearest.
  [[nodiscard]] std::size_t OneOf(const std::vector<std::string>& names) const;

  [[nodiscard]] FilePlace Place() const;
  [[noreturn]] void Fail(const std::string& problem) const;

 private:
  const toml::node* node_;
  std::string key_;
};

/// A table of a TOML file.
class TomlTable {
 public:
  /// `key` is the dotted name of the table, empty for the file itself.
  TomlTable(const toml::table& table, std::string key) : table_(&table), key_(std::move(key)) {}
  /// Refuses a value that is not a table.
  explicit TomlTable(const TomlValue& value);

  [[nodiscard]] const toml::table& table() const { return *table_; }
  [[nodiscard]] const std::string& key() const { return key_; }
  [[nodiscard]] std::optional<TomlValue> Find(std::string_view name) const;
  [[nodiscard]] TomlValue Require(std::string_view name, const std::string& allowed) const;
  [[nodiscard]] std::optional<double> FindPositive(std::string_view name) const;
  /// Refuses keys that are not among `names`, giving the nearest.
  void RefuseOthers(const std::vector<std::string>& names) const;
  [[nodiscard]] FilePlace PlaceOf(std::string_view name) const;

 private:
  [[nodiscard]] std::string KeyOf(std::string_view name) const;
  const toml::table* table_;
  std::string key_;
};

/// Parses a text; syntax errors become InputError with file and line.
[[nodiscard]] toml::table ParseToml(std::string_view text, const std::string& file);

/// "a, b or c".
[[nodiscard]] std::string Listed(const std::vector<std::string>& names);

/// A text as a TOML basic string, quotes included.
[[nodiscard]] std::string TomlText(std::string_view text);

/// A name as the key of a table: bare where TOML allows it, else quoted.
[[nodiscard]] std::string TomlKey(std::string_view name);

}  // namespace sarblock
