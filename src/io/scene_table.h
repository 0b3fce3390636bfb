// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "toml_reader.h"

namespace sarblock {

/// Takes known keys out of one TOML table and refuses what is left. Keys that do not stand leave
/// the value as it is. Every error is an InputError with file, line and dotted key.
class SceneTable {
 public:
  explicit SceneTable(TomlTable table) : table_(std::move(table)) {}

  /// Notes the key as known.
  [[nodiscard]] std::optional<TomlValue> Take(const std::string& key);
  [[nodiscard]] bool Has(const std::string& key) const { return table_.Find(key).has_value(); }
  /// Place and dotted key of a field of this table, standing or not.
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
  /// Of an array of tables [[key]]; empty where the key does not stand.
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
