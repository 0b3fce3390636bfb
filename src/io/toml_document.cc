// SPDX-License-Identifier: Apache-2.0
#include "toml_document.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

namespace sarblock {
namespace {

/// Index of an array element in a dotted key; npos if `name` is none.
std::size_t IndexOf(std::string_view name, std::size_t size) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  return error == std::errc() && end == name.data() + name.size() && index < size
             ? index
             : std::string::npos;
}

template <typename Node>  // toml::node or const toml::node
Node* Child(Node* parent, std::string_view name) {
  if (auto* table = parent->as_table()) return table->get(name);
  if (auto* array = parent->as_array()) {
    const std::size_t index = IndexOf(name, array->size());
    return index == std::string::npos ? nullptr : array->get(index);
  }
  return nullptr;
}

/// Sets one `KEY=VALUE`.
void Override(const std::string& text, toml::table* root) {
  const std::string source = "--set " + text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InputError(source, "must be KEY=VALUE with a dotted key");
  }
  toml::table parsed;
  try {
    parsed = toml::parse("value = " + text.substr(equals + 1), source);
  } catch (const toml::parse_error&) {
    parsed.insert("value", text.substr(equals + 1));
  }
  toml::node* parent = root;
  std::string_view rest = std::string_view(text).substr(0, equals);
  for (std::size_t dot = rest.find('.'); dot != std::string_view::npos; dot = rest.find('.')) {
    const std::string_view name = rest.substr(0, dot);
    rest.remove_prefix(dot + 1);
    toml::node* child = Child(parent, name);
    if (child == nullptr && parent->is_table()) {
      child = &parent->as_table()->insert_or_assign(name, toml::table{}).first->second;
    }
    if (child == nullptr) throw InputError(source, "has no element " + std::string(name));
    parent = child;
  }
  parsed.get("value")->visit([&](auto& value) {
    if (toml::table* table = parent->as_table()) {
      table->insert_or_assign(rest, std::move(value));  // moved: a copy loses its place
    } else if (toml::array* array = parent->as_array();
               array != nullptr && IndexOf(rest, array->size()) != std::string::npos) {
      const auto index = static_cast<std::ptrdiff_t>(IndexOf(rest, array->size()));
      array->replace(array->cbegin() + index, std::move(value));
    } else {
      throw InputError(source, "names no key of a table");
    }
  });
}

}  // namespace

std::string ReadTomlText(const std::filesystem::path& path, const std::string& what) {
  if (std::filesystem::is_directory(path)) {
    throw InputError(FilePlace{path.string(), 0, ""}, "is a folder; " + what + " is a TOML file");
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw InputError(FilePlace{path.string(), 0, ""},
                     "cannot be read: " + std::generic_category().message(errno));
  }
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::function<std::string(const std::string& name)> SceneTextsBeside(
    const std::filesystem::path& study_file) {
  return [folder = study_file.parent_path()](const std::string& name) {
    return ReadTomlText(folder / name, "a scene");
  };
}

toml::table ParseToml(std::string_view text,
                      const std::string& file,
                      const std::vector<std::string>& overrides) {
  toml::table root = ParseToml(text, file);
  for (const std::string& entry : overrides) Override(entry, &root);
  return root;
}

std::string TextOf(const toml::table& table) {
  std::ostringstream stream;
  stream << table << '\n';
  return stream.str();
}

/// Place of a dotted field, or of the nearest table around it that stands in the file.
FilePlace PlaceOfField(const toml::table& root, const std::string& file, const std::string& field) {
  const toml::node* node = &root;
  std::string_view rest = field;
  while (!rest.empty()) {
    const std::size_t dot = std::min(rest.find('.'), rest.size());
    const toml::node* child = Child(node, rest.substr(0, dot));
    if (child == nullptr) break;
    node = child;
    rest.remove_prefix(std::min(dot + 1, rest.size()));
  }
  FilePlace place = TomlValue(*node, field).Place();
  if (node->source().path == nullptr || node == &root) place = {file, 0, field};
  return place;
}

}  // namespace sarblock
