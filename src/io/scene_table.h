// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <toml++/toml.h>

namespace sarblock {

/// Place of a TOML node for messages; `file` where the node does not know its own.
[[nodiscard]] FilePlace PlaceOf(const toml::node& node,
                                const std::string& file,
                                const std::string& field);

/// Takes known keys out of one TOML table and refuses what is left. Keys that do not stand leave
/// the value as it is. Every error is an InputError with file, line and dotted key.
class SceneTable {
 public:
  /// `prefix` is the dotted key of the table with a dot at its end; empty for the root.
  SceneTable(const toml::table& table, std::string prefix, std::string file);

  [[nodiscard]] bool Has(const std::string& key) const { return table_->contains(key); }
  void Number(const std::string& key, double* value, double unit = 1.0);
  /// A whole number of at least 0.
  template <typename Integer>
  void Count(const std::string& key, Integer* value) {
    if (const toml::node* node = Take(key)) *value = static_cast<Integer>(CountOf(*node, key));
  }
  void Text(const std::string& key, std::string* value);
  void Truth(const std::string& key, bool* value);

  template <std::size_t N>
  bool Numbers(const std::string& key, std::array<double, N>* values, double unit = 1.0) {
    const toml::node* node = Take(key);
    if (node == nullptr) return false;
    const std::vector<double> read = NumbersOf(*node, key, N);
    for (std::size_t i = 0; i < N; ++i) (*values)[i] = read[i] * unit;
    return true;
  }

  /// One of a set of names.
  template <typename Value>
  void Choice(const std::string& key,
              const std::vector<std::pair<std::string, Value>>& allowed,
              Value* value) {
    const toml::node* node = Take(key);
    if (node == nullptr) return;
    std::vector<std::string> names;
    for (const auto& entry : allowed) names.push_back(entry.first);
    *value = allowed[ChoiceOf(*node, key, names)].second;
  }

  [[nodiscard]] std::vector<std::string> Texts(const std::string& key);
  /// Null where the key does not stand.
  [[nodiscard]] const toml::table* Table(const std::string& key);
  [[nodiscard]] const toml::array* Tables(const std::string& key);
  [[nodiscard]] const toml::node* Take(const std::string& key);
  [[noreturn]] void Fail(const toml::node& node,
                         const std::string& key,
                         const std::string& problem) const;
  [[nodiscard]] const std::string& prefix() const { return prefix_; }
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Refuses keys never asked for.
  void Finish() const;

 private:
  [[nodiscard]] std::size_t CountOf(const toml::node& node, const std::string& key) const;
  [[nodiscard]] std::size_t ChoiceOf(const toml::node& node,
                                     const std::string& key,
                                     const std::vector<std::string>& names) const;
  [[nodiscard]] std::vector<double> NumbersOf(const toml::node& node,
                                              const std::string& key,
                                              std::size_t count) const;
  const toml::table* table_;
  std::string prefix_;
  std::string file_;
  std::vector<std::string> known_;
};

}  // namespace sarblock
