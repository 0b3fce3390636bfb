// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace sarblock {

/// A value of a JSON file with its dotted key; a view that must not outlive the parsed text. What
/// has the wrong type throws InputError with file and key.
class JsonValue {
 public:
  JsonValue(const nlohmann::ordered_json& node, const std::string& file, std::string key)
      : node_(&node), file_(&file), key_(std::move(key)) {}

  [[nodiscard]] std::string Text() const;
  [[nodiscard]] bool Flag() const;
  [[nodiscard]] double Number() const;  ///< NaN for null: a figure that does not exist
  [[nodiscard]] std::uint64_t Count() const;
  [[nodiscard]] std::vector<JsonValue> Entries() const;  ///< of a list
  [[nodiscard]] std::vector<std::pair<std::string, JsonValue>> Members() const;
  [[nodiscard]] bool IsObject() const { return node_->is_object(); }
  [[nodiscard]] std::string Dump() const { return node_->dump(); }  ///< as JSON
  /// The member of an object, or nothing if it does not stand there or is null.
  [[nodiscard]] std::optional<JsonValue> Find(const char* name) const;
  [[nodiscard]] JsonValue Require(const char* name) const;
  /// Index of the text in `names`; refuses others, naming all.
  [[nodiscard]] std::size_t OneOf(const std::vector<std::string>& names) const;

  [[noreturn]] void Fail(const std::string& problem) const;

 private:
  const nlohmann::ordered_json* node_;
  const std::string* file_;
  std::string key_;
};

/// Parses a text; syntax errors become InputError with file and line.
[[nodiscard]] nlohmann::ordered_json ParseJson(std::string_view text, const std::string& file);

}  // namespace sarblock
