// SPDX-License-Identifier: Apache-2.0
#include "toml.h"

#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

#include "core/text.h"

namespace sarblock {
namespace {

FilePlace PlaceIn(const toml::source_region& source, const std::string& key) {
  // Tables made by an override come from no file, values of one from "--set KEY".
  const std::string file = source.path != nullptr ? *source.path : std::string("--set");
  return {file, file.starts_with("--set") ? 0 : std::size_t{source.begin.line}, key};
}

const char* TypeOf(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

// toml++ 3.3 takes it for granted that a name follows the bracket of a table header (an assertion
// in its parser); a line such as "[= 1.5" must not reach it.
void RefuseNamelessHeaders(std::string_view text, const std::string& file) {
  constexpr std::string_view kBlank = " \t";
  constexpr std::string_view kNoName = "=.,:;!@$%^&*()<>/?|\\~`";
  for (std::size_t line = 1; !text.empty(); ++line) {
    std::string_view rest = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(rest.size() + 1, text.size()));
    const auto skip = [&rest](std::string_view characters) {
      rest.remove_prefix(std::min(rest.find_first_not_of(characters), rest.size()));
    };
    skip(kBlank);
    if (!rest.starts_with('[')) continue;
    rest.remove_prefix(1);
    if (rest.starts_with('[')) rest.remove_prefix(1);
    skip(kBlank);
    if (!rest.empty() && kNoName.find(rest.front()) != std::string_view::npos) {
      throw InputError(FilePlace{file, line, ""}, "is not valid TOML: a table header needs a name");
    }
  }
}

}  // namespace

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

std::string TomlText(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      std::array<char, 8> code;
      std::snprintf(code.data(), code.size(), "\\u%04X", static_cast<unsigned>(byte));
      quoted += code.data();
    } else {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string TomlKey(std::string_view name) {
  const auto bare = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  };
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), bare);
  return plain ? std::string(name) : TomlText(name);
}

namespace {

/// Keys of more parts than this are no one's; toml++ and what walks through tables go down a level
/// of the stack for each.
constexpr std::size_t kMaxKeyParts = 100;

/// Refuses texts in which so many names, bare or quoted, follow each other with dots between them.
void RefuseDeepKeys(std::string_view text, const std::string& file) {
  const auto is_name = [](char c) {
    return (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '-' || c == '_';
  };
  std::size_t parts = 0, line = 1;
  bool after_dot = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.') {
      after_dot = true;
      continue;
    }
    if (c == ' ' || c == '\t') continue;
    const bool quoted = c == '"' || c == '\'';
    if (quoted || is_name(c)) {
      parts = after_dot ? parts + 1 : 1;
      if (quoted) {
        for (++i; i < text.size() && text[i] != c && text[i] != '\n'; ++i) {
          if (c == '"' && text[i] == '\\') ++i;
        }
        if (i < text.size() && text[i] == '\n') --i;
      } else {
        while (i + 1 < text.size() && is_name(text[i + 1])) ++i;
      }
      if (parts > kMaxKeyParts) {
        throw InputError(FilePlace{file, line, ""},
                         "a key has more than " + std::to_string(kMaxKeyParts) +
                             " parts, which no key of ours has");
      }
    } else {
      parts = 0;
      if (c == '\n') ++line;
    }
    after_dot = false;
  }
}

}  // namespace

toml::table ParseToml(std::string_view text, const std::string& file) {
  RefuseDeepKeys(text, file);
  RefuseNamelessHeaders(text, file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw InputError(FilePlace{file, error.source().begin.line, ""},
                     "is not valid TOML: " + std::string(error.description()));
  }
}

FilePlace TomlValue::Place() const { return PlaceIn(node_->source(), key_); }

void TomlValue::Fail(const std::string& problem) const { throw InputError(Place(), problem); }

std::string TomlValue::Text() const {
  if (const auto text = node_->value_exact<std::string>()) return *text;
  Fail(std::string("is ") + TypeOf(*node_) + ", a text in quotes is needed");
}

bool TomlValue::Flag() const {
  if (const auto flag = node_->value_exact<bool>()) return *flag;
  Fail(std::string("is ") + TypeOf(*node_) + ", true or false is needed");
}

double TomlValue::Number() const {
  if (const auto integer = node_->value_exact<std::int64_t>()) {
    return static_cast<double>(*integer);
  }
  const auto number = node_->value_exact<double>();
  if (!number) Fail(std::string("is ") + TypeOf(*node_) + ", a number is needed");
  if (!std::isfinite(*number)) Fail("is not finite, a finite number is needed");
  if (std::abs(*number) > kLargestNumber) {
    Fail("must be at most " + NumberText(kLargestNumber) + ", got " + NumberText(*number));
  }
  return *number;
}

double TomlValue::Positive() const {
  const double number = Number();
  if (const char* problem = ProblemOfPositive(number)) Fail(MustBe(problem, NumberText(number)));
  return number;
}

int TomlValue::Integer(int lowest, int highest) const {
  const std::string allowed =
      "an integer from " + std::to_string(lowest) + " to " + std::to_string(highest);
  const auto integer = node_->value_exact<std::int64_t>();
  if (!integer) Fail(std::string("is ") + TypeOf(*node_) + ", " + allowed + " is needed");
  if (*integer < lowest || *integer > highest) {
    Fail("must be " + allowed + ", got " + std::to_string(*integer));
  }
  return static_cast<int>(*integer);
}

std::uint64_t TomlValue::Count() const {
  const auto integer = node_->value_exact<std::int64_t>();
  if (!integer) Fail(std::string("is ") + TypeOf(*node_) + ", an integer of 0 or more is needed");
  if (*integer < 0) Fail("must be an integer of 0 or more, got " + std::to_string(*integer));
  return static_cast<std::uint64_t>(*integer);
}

std::vector<TomlValue> TomlValue::Entries() const {
  const toml::array* array = node_->as_array();
  if (array == nullptr) Fail(std::string("is ") + TypeOf(*node_) + ", a list [...] is needed");
  std::vector<TomlValue> entries;
  for (std::size_t i = 0; i < array->size(); ++i) {
    entries.emplace_back((*array)[i], key_ + "[" + std::to_string(i) + "]");
  }
  return entries;
}

std::size_t TomlValue::OneOf(const std::vector<std::string>& names) const {
  const std::string text = Text();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) {
    Fail(Quoted(text) + " is not known, " + Listed(names) + " is allowed" +
         DidYouMean(NearestName(text, names)));
  }
  return static_cast<std::size_t>(found - names.begin());
}

TomlTable::TomlTable(const TomlValue& value) : table_(value.node().as_table()), key_(value.key()) {
  if (table_ == nullptr) {
    value.Fail(std::string("is ") + TypeOf(value.node()) + ", a table is needed");
  }
}

std::string TomlTable::KeyOf(std::string_view name) const {
  return key_.empty() ? std::string(name) : key_ + "." + std::string(name);
}

FilePlace TomlTable::PlaceOf(std::string_view name) const {
  return PlaceIn(table_->source(), KeyOf(name));
}

std::optional<TomlValue> TomlTable::Find(std::string_view name) const {
  const toml::node* node = table_->get(name);
  if (node == nullptr) return std::nullopt;
  return TomlValue(*node, KeyOf(name));
}

TomlValue TomlTable::Require(std::string_view name, const std::string& allowed) const {
  const auto value = Find(name);
  if (!value) throw InputError(PlaceOf(name), "is missing, " + allowed + " is needed");
  return *value;
}

std::optional<double> TomlTable::FindPositive(std::string_view name) const {
  const auto value = Find(name);
  return value ? std::optional<double>(value->Positive()) : std::nullopt;
}

void TomlTable::RefuseOthers(const std::vector<std::string>& names) const {
  for (const auto& [name, node] : *table_) {
    const std::string text(name.str());
    if (std::find(names.begin(), names.end(), text) != names.end()) continue;
    FilePlace place = PlaceIn(node.source(), KeyOf(text));
    if (name.source().begin.line > 0) place.line = name.source().begin.line;
    throw InputError(place,
                     "the key is not known, " + Listed(names) + " is allowed" +
                         DidYouMean(NearestName(text, names)));
  }
}

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
    throw InputError(FilePlace{source, 0, ""}, "must be KEY=VALUE with a dotted key");
  }
  RefuseDeepKeys(text, "--set");
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
    if (child == nullptr) {
      throw InputError(FilePlace{source, 0, ""}, "has no element " + std::string(name));
    }
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
      throw InputError(FilePlace{source, 0, ""}, "names no key of a table");
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

/// Place of a dotted field, or of the nearest table around it in the file.
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
    if (equals == 0 || equals == std::string::npos) {
      throw InputError(FilePlace{"--set " + text, 0, ""},
                       "is no KEY=VALUE, for example robust=huber");
    }
    const FilePlace place{"--set " + text.substr(0, equals), 0, ""};
    RefuseDeepKeys(text, "--set");
    std::string_view key = std::string_view(text).substr(0, equals);
    const bool of_block = key.starts_with("trajectory.") || key.starts_with("reduction.");
    if (key.starts_with("adjust.")) key.remove_prefix(std::string_view("adjust.").size());
    const std::vector<std::string> parts = SplitKey(key);
    toml::node* node = of_block ? block_toml : Descend(block_toml, "adjust", place);
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

std::optional<TomlValue> SceneTable::Take(const std::string& key) {
  known_.push_back(key);
  return table_.Find(key);
}

void SceneTable::Number(const std::string& key, double* value, double unit) {
  if (const auto taken = Take(key)) *value = taken->Number() * unit;
}

void SceneTable::Text(const std::string& key, std::string* value) {
  if (const auto taken = Take(key)) *value = taken->Text();
}

void SceneTable::Truth(const std::string& key, bool* value) {
  if (const auto taken = Take(key)) *value = taken->Flag();
}

std::vector<double> SceneTable::NumbersOf(const TomlValue& value, std::size_t count) {
  std::vector<double> numbers;
  for (const TomlValue& entry : value.Entries()) numbers.push_back(entry.Number());
  if (numbers.size() != count) {
    value.Fail("is a list of " + std::to_string(numbers.size()) + ", a list of " +
               std::to_string(count) + " numbers is needed");
  }
  return numbers;
}

std::optional<SceneTable> SceneTable::Table(const std::string& key) {
  const auto taken = Take(key);
  return taken ? std::optional<SceneTable>(TomlTable(*taken)) : std::nullopt;
}

std::vector<SceneTable> SceneTable::Tables(const std::string& key) {
  std::vector<SceneTable> tables;
  const auto taken = Take(key);
  if (!taken) return tables;
  const std::vector<TomlValue> entries = taken->Entries();
  if (entries.empty()) taken->Fail("is empty, a list of tables [[" + key + "]] is needed");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    // Dotted as in --set: flight.0.height_m.
    const TomlValue entry(entries[i].node(), taken->key() + "." + std::to_string(i));
    tables.emplace_back(TomlTable(entry));
  }
  return tables;
}

}  // namespace sarblock
