// SPDX-License-Identifier: Apache-2.0
#include "adjust_overrides.h"

#include <charconv>

#include "core/text.h"
#include "toml_reader.h"

namespace sarblock {
namespace {

std::vector<std::string> SplitKey(std::string_view key) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t dot = key.find('.');
    parts.emplace_back(key.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    key.remove_prefix(dot + 1);
  }
}

// The value as TOML; what is no TOML (a bare word) is a text.
toml::table ParseValue(const std::string& value, const std::string& source) {
  if (value.find('\n') == std::string::npos) {
    try {
      toml::table parsed = toml::parse("value = " + value, source);
      if (parsed.size() == 1) return parsed;
    } catch (const toml::parse_error&) {
      // a bare word
    }
  }
  return toml::parse("value = " + TomlText(value), source);
}

// Table `name` inside `parent`, made if it is missing. In an array of tables the name is the index.
toml::node* Descend(toml::node* parent, const std::string& name, const FilePlace& place) {
  if (toml::table* table = parent->as_table()) {
    if (!table->contains(name)) table->insert(name, toml::table{});
    return table->get(name);
  }
  if (toml::array* array = parent->as_array()) {
    std::size_t index = 0;
    const char* const end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data(), end, index);
    if (error == std::errc() && stop == end && index < array->size()) return array->get(index);
    throw InputError(place,
                     Quoted(name) + " is no group of " + std::to_string(array->size()) +
                         ", an index counting from 0 is needed (correction.position.0.degree)");
  }
  throw InputError(place, "there is a value, not a table, before " + Quoted(name));
}

}  // namespace

void ApplyOverrides(const std::vector<std::string>& overrides, toml::table* block_toml) {
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    const FilePlace place{"--set " + text.substr(0, equals), 0, ""};
    if (equals == 0 || equals == std::string::npos) {
      throw InputError(place, "is no KEY=VALUE, for example robust=huber");
    }
    std::string_view key = std::string_view(text).substr(0, equals);
    const bool of_paths = key.starts_with("trajectory.");
    if (key.starts_with("adjust.")) key.remove_prefix(std::string_view("adjust.").size());
    const std::vector<std::string> parts = SplitKey(key);
    toml::node* node = of_paths ? block_toml : Descend(block_toml, "adjust", place);
    for (std::size_t i = 0; i + 1 < parts.size(); ++i) node = Descend(node, parts[i], place);
    toml::table* table = node->as_table();
    if (table == nullptr) {
      throw InputError(place,
                       node->is_array()
                           ? "the key leads to several groups; one is chosen by its index from 0 "
                             "(correction.position.0.degree)"
                           : "there is a value, not a table, before " + Quoted(parts.back()));
    }
    toml::table parsed = ParseValue(text.substr(equals + 1), place.file);
    table->insert_or_assign(parts.back(), std::move(*parsed.get("value")));
  }
}

}  // namespace sarblock
