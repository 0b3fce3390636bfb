// SPDX-License-Identifier: Apache-2.0
#include "json_reader.h"

#include <algorithm>
#include <limits>

#include "number.h"
#include "toml_reader.h"

namespace sarblock {

nlohmann::ordered_json ParseJson(std::string_view text, const std::string& file) {
  try {
    return nlohmann::ordered_json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t end = std::min(error.byte, text.size());
    const auto lines =
        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    throw InputError(FilePlace{file, static_cast<std::size_t>(lines) + 1, ""}, "is not valid JSON");
  } catch (const nlohmann::json::out_of_range&) {
    throw InputError(FilePlace{file, 0, ""}, "is not valid JSON: a number is out of range");
  }
}

void JsonValue::Fail(const std::string& problem) const {
  throw InputError(FilePlace{*file_, 0, key_}, problem);
}

std::string JsonValue::Text() const {
  if (!node_->is_string()) Fail(std::string("is ") + node_->type_name() + ", a text is needed");
  return node_->get<std::string>();
}

bool JsonValue::Flag() const {
  if (!node_->is_boolean()) {
    Fail(std::string("is ") + node_->type_name() + ", true or false is needed");
  }
  return node_->get<bool>();
}

double JsonValue::Number() const {
  if (node_->is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!node_->is_number()) Fail(std::string("is ") + node_->type_name() + ", a number is needed");
  return node_->get<double>();
}

std::uint64_t JsonValue::Count() const {
  if (!node_->is_number_unsigned()) Fail("an integer of 0 or more is needed");
  return node_->get<std::uint64_t>();
}

std::vector<JsonValue> JsonValue::Entries() const {
  if (!node_->is_array()) Fail(std::string("is ") + node_->type_name() + ", a list is needed");
  std::vector<JsonValue> entries;
  for (std::size_t i = 0; i < node_->size(); ++i) {
    entries.emplace_back((*node_)[i], *file_, key_ + "[" + std::to_string(i) + "]");
  }
  return entries;
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::Members() const {
  if (!node_->is_object()) Fail(std::string("is ") + node_->type_name() + ", an object is needed");
  std::vector<std::pair<std::string, JsonValue>> members;
  for (const auto& [name, node] : node_->items()) {
    members.emplace_back(name, JsonValue(node, *file_, key_.empty() ? name : key_ + "." + name));
  }
  return members;
}

std::optional<JsonValue> JsonValue::Find(const char* name) const {
  if (!node_->is_object()) Fail(std::string("is ") + node_->type_name() + ", an object is needed");
  const auto found = node_->find(name);
  if (found == node_->end() || found->is_null()) return std::nullopt;
  return JsonValue(*found, *file_, key_.empty() ? name : key_ + "." + name);
}

JsonValue JsonValue::Require(const char* name) const {
  if (!node_->is_object()) Fail(std::string("is ") + node_->type_name() + ", an object is needed");
  const auto found = node_->find(name);
  const std::string key = key_.empty() ? name : key_ + "." + name;
  if (found == node_->end()) throw InputError(FilePlace{*file_, 0, key}, "is missing");
  return {*found, *file_, key};
}

std::size_t JsonValue::OneOf(const std::vector<std::string>& names) const {
  const std::string text = Text();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) Fail(Quoted(text) + " is not known, " + Listed(names) + " is allowed");
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace sarblock
