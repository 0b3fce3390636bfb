// SPDX-License-Identifier: Apache-2.0
#include "toml_reader.h"

#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

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

toml::table ParseToml(std::string_view text, const std::string& file) {
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
    Fail(NumberText(*number) + " is not allowed, at most " + NumberText(kLargestNumber) + " is");
  }
  return *number;
}

double TomlValue::Positive() const {
  const double number = Number();
  if (const char* problem = ProblemOfPositive(number)) Fail(NumberText(number) + problem);
  return number;
}

int TomlValue::Integer(int lowest, int highest) const {
  const std::string allowed =
      "an integer from " + std::to_string(lowest) + " to " + std::to_string(highest);
  const auto integer = node_->value_exact<std::int64_t>();
  if (!integer) Fail(std::string("is ") + TypeOf(*node_) + ", " + allowed + " is needed");
  if (*integer < lowest || *integer > highest) {
    Fail(std::to_string(*integer) + " is not allowed, " + allowed + " is");
  }
  return static_cast<int>(*integer);
}

std::uint64_t TomlValue::Count() const {
  const auto integer = node_->value_exact<std::int64_t>();
  if (!integer) Fail(std::string("is ") + TypeOf(*node_) + ", an integer of 0 or more is needed");
  if (*integer < 0) Fail(std::to_string(*integer) + " is not allowed, an integer of 0 or more is");
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

}  // namespace sarblock
