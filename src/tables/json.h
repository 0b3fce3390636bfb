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

class JsonFile;

/// A value of a JSON file with its dotted key; a view that must not outlive the file. What has the
/// wrong type throws InputError with file, line and key.
class JsonValue {
 public:
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] bool Flag() const;
  [[nodiscard]] double Number() const;  ///< NaN for null: a figure that does not exist
  [[nodiscard]] std::uint64_t Count() const;
  [[nodiscard]] std::vector<JsonValue> Entries() const;  ///< of a list
  [[nodiscard]] std::vector<std::pair<std::string, JsonValue>> Members() const;
  [[nodiscard]] bool IsObject() const { return node_->is_object(); }
  [[nodiscard]] const nlohmann::ordered_json& Node() const { return *node_; }
  /// The member of an object, or nothing if there is none or it is null.
  [[nodiscard]] std::optional<JsonValue> Find(const char* name) const;
  [[nodiscard]] JsonValue Require(const char* name) const;
  /// Index of the text in `names`; refuses others, naming all.
  [[nodiscard]] std::size_t OneOf(const std::vector<std::string>& names) const;

  [[noreturn]] void Fail(const std::string& problem) const;

 private:
  friend class JsonFile;
  JsonValue(const nlohmann::ordered_json& node, const JsonFile& file, std::string key)
      : node_(&node), file_(&file), key_(std::move(key)) {}
  [[nodiscard]] std::string KeyOf(const std::string& member) const;
  [[nodiscard]] const nlohmann::ordered_json* Member(const char* name) const;

  const nlohmann::ordered_json* node_;
  const JsonFile* file_;
  std::string key_;
};

/// A JSON file as it was read. It keeps a view of its text, which must outlive it: the lines of
/// keys are looked for there once something is wrong.
class JsonFile {
 public:
  /// Parses a text; syntax errors become InputError with file and line.
  JsonFile(std::string_view text, std::string name);
  JsonFile(const JsonFile&) = delete;
  JsonFile& operator=(const JsonFile&) = delete;

  [[nodiscard]] JsonValue Root() const { return {root_, *this, ""}; }
  /// The place of a dotted key ("passes[2].id"), its line 0 where the file has no such key.
  [[nodiscard]] FilePlace PlaceOf(const std::string& key) const;

 private:
  std::string_view text_;
  std::string name_;
  nlohmann::ordered_json root_;
};

}  // namespace sarblock
