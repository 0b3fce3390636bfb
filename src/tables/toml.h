// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
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

/// Scenes and studies: a TOML file with the overrides of the command line.

/// The file's text; `what` ("a scene") is for messages.
[[nodiscard]] std::string ReadTomlText(const std::filesystem::path& path, const std::string& what);

/// Reads scenes by the name that a study gives, relative to the study's folder.
[[nodiscard]] std::function<std::string(const std::string& name)> SceneTextsBeside(
    const std::filesystem::path& study_file);

/// Parses a text and sets every `KEY=VALUE`: a dotted key, elements of lists by their index from 0,
/// and a TOML value; what is not a TOML value is taken as a text.
[[nodiscard]] toml::table ParseToml(std::string_view text,
                                    const std::string& file,
                                    const std::vector<std::string>& overrides);

[[nodiscard]] std::string TextOf(const toml::table& table);

/// Place of a dotted field, or of the nearest table around it in the file.
[[nodiscard]] FilePlace PlaceOfField(const toml::table& root,
                                     const std::string& file,
                                     const std::string& field);

/// Applies `KEY=VALUE` overrides to the `[adjust]` table of a block file, and those of
/// `trajectory.` and `reduction.` to its tables of that name; tables that are missing are made.
void ApplyOverrides(const std::vector<std::string>& overrides, toml::table* block_toml);

/// Takes known keys out of one TOML table and refuses the others. Absent keys keep the default.
/// Every error is an InputError with file, line and dotted key.
class SceneTable {
 public:
  explicit SceneTable(TomlTable table) : table_(std::move(table)) {}

  /// Notes the key as known.
  [[nodiscard]] std::optional<TomlValue> Take(const std::string& key);
  [[nodiscard]] bool Has(const std::string& key) const { return table_.Find(key).has_value(); }
  /// Place and dotted key of a field of this table, given or not.
  [[nodiscard]] FilePlace PlaceOf(const std::string& key) const { return table_.PlaceOf(key); }

  void Number(const std::string& key, double* value, double unit = 1.0);
  /// A whole number of at least 0.
  template <typename Integer>
  void Count(const std::string& key, Integer* value) {
    if (const auto taken = Take(key)) *value = static_cast<Integer>(taken->Count());
  }
  void Text(const std::string& key, std::string* value);
  void Truth(const std::string& key, bool* value);

  template <std::size_t N>
  bool Numbers(const std::string& key, std::array<double, N>* values, double unit = 1.0) {
    const auto taken = Take(key);
    if (!taken) return false;
    const std::vector<double> read = NumbersOf(*taken, N);
    for (std::size_t i = 0; i < N; ++i) (*values)[i] = read[i] * unit;
    return true;
  }

  /// One of a set of names.
  template <typename Value>
  void Choice(const std::string& key,
              const std::vector<std::pair<std::string, Value>>& allowed,
              Value* value) {
    const auto taken = Take(key);
    if (!taken) return;
    std::vector<std::string> names;
    for (const auto& entry : allowed) names.push_back(entry.first);
    *value = allowed[taken->OneOf(names)].second;
  }
  /// One of values that have names by NameOf().
  template <typename Value, std::size_t kCount>
  void Choice(const std::string& key, const std::array<Value, kCount>& allowed, Value* value) {
    std::vector<std::pair<std::string, Value>> named;
    for (const Value one : allowed) named.emplace_back(NameOf(one), one);
    Choice<Value>(key, named, value);
  }

  [[nodiscard]] std::optional<SceneTable> Table(const std::string& key);
  /// Tables of an array [[key]]; empty without the key.
  [[nodiscard]] std::vector<SceneTable> Tables(const std::string& key);
  /// Refuses keys never asked for.
  void Finish() const { table_.RefuseOthers(known_); }
  /// Keys asked for so far.
  [[nodiscard]] const std::vector<std::string>& known() const { return known_; }

 private:
  [[nodiscard]] static std::vector<double> NumbersOf(const TomlValue& value, std::size_t count);
  TomlTable table_;
  std::vector<std::string> known_;
};

}  // namespace sarblock
