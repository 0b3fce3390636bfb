// SPDX-License-Identifier: Apache-2.0
#include "json.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include "core/text.h"
#include "toml.h"

namespace sarblock {
namespace {

using Json = nlohmann::ordered_json;

/// What was read of a text so far.
struct TextPlace {
  std::size_t line = 1;
  char last = '\0';
};

/// Reads a text and counts its lines.
class CountingIterator {
 public:
  using difference_type = std::ptrdiff_t;
  using value_type = char;
  using pointer = const char*;
  using reference = const char&;
  using iterator_category = std::input_iterator_tag;

  CountingIterator(const char* at, TextPlace* place) : at_(at), place_(place) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    place_->last = *at_++;
    if (place_->last == '\n') ++place_->line;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }

 private:
  const char* at_;
  TextPlace* place_;
};

/// Follows a text to a dotted key and stops there.
class KeySearch : public nlohmann::json_sax<Json> {
 public:
  KeySearch(const std::string& key, const TextPlace& place) : key_(&key), place_(&place) {}
  [[nodiscard]] std::size_t line() const { return found_; }

  bool null() override { return Value(); }
  bool boolean(bool) override { return Value(); }
  bool number_integer(number_integer_t) override { return Number(); }
  bool number_unsigned(number_unsigned_t) override { return Number(); }
  bool number_float(number_float_t, const string_t&) override { return Number(); }
  bool string(string_t&) override { return Value(); }
  bool binary(binary_t&) override { return Value(); }
  bool start_object(std::size_t) override { return Value() && Enter(false); }
  bool start_array(std::size_t) override { return Value() && Enter(true); }
  bool end_object() override { return Leave(); }
  bool end_array() override { return Leave(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }
  bool key(string_t& name) override {
    const std::string& parent = levels_.back().key;
    here_ = parent.empty() ? name : parent + "." + name;
    return here_ != *key_ || Found(place_->line);
  }

 private:
  struct Level {
    std::string key;
    bool is_list = false;
    std::size_t entries = 0;
  };

  bool Value() { return IsElsewhere() || Found(place_->line); }
  // The character behind a number was read to find its end.
  bool Number() { return IsElsewhere() || Found(place_->line - (place_->last == '\n' ? 1 : 0)); }
  // Members of objects were compared by key().
  bool IsElsewhere() {
    if (levels_.empty() || !levels_.back().is_list) return true;
    Level& list = levels_.back();
    here_ = list.key + "[" + std::to_string(list.entries++) + "]";
    return here_ != *key_;
  }
  bool Found(std::size_t line) {
    found_ = line;
    return false;
  }
  bool Enter(bool is_list) {
    levels_.push_back({here_, is_list, 0});
    return true;
  }
  bool Leave() {
    levels_.pop_back();
    return true;
  }

  const std::string* key_;
  const TextPlace* place_;
  std::vector<Level> levels_;
  std::string here_;
  std::size_t found_ = 0;
};

/// Levels below each other; a level takes memory before anything is made of it.
constexpr std::size_t kMaxLevels = 200;

/// The line where a text has more of them; 0: nowhere.
std::size_t LineTooDeep(std::string_view text) {
  std::size_t depth = 0, line = 1;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxLevels) return line;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return 0;
}

Json Parsed(std::string_view text, const std::string& file) {
  if (const std::size_t line = LineTooDeep(text)) {
    throw InputError(FilePlace{file, line, ""},
                     "has more than " + std::to_string(kMaxLevels) +
                         " levels of lists and objects, which no file of ours has");
  }
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t end = std::min(error.byte, text.size());
    const auto lines =
        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    throw InputError(FilePlace{file, static_cast<std::size_t>(lines) + 1, ""}, "is not valid JSON");
  } catch (const nlohmann::json::out_of_range&) {
    throw InputError(FilePlace{file, 0, ""}, "is not valid JSON: a number is out of range");
  }
}

}  // namespace

JsonFile::JsonFile(std::string_view text, std::string name)
    : text_(text), name_(std::move(name)), root_(Parsed(text_, name_)) {}

FilePlace JsonFile::PlaceOf(const std::string& key) const {
  TextPlace place;
  KeySearch search(key, place);
  const char* end = text_.data() + text_.size();
  Json::sax_parse(CountingIterator(text_.data(), &place), CountingIterator(end, &place), &search);
  return {name_, search.line(), key};
}

void JsonValue::Fail(const std::string& problem) const {
  throw InputError(file_->PlaceOf(key_), problem);
}

std::string JsonValue::KeyOf(const std::string& member) const {
  return key_.empty() ? member : key_ + "." + member;
}

const nlohmann::ordered_json* JsonValue::Member(const char* name) const {
  if (!node_->is_object()) Fail(std::string("is ") + node_->type_name() + ", an object is needed");
  const auto found = node_->find(name);
  return found == node_->end() ? nullptr : &*found;
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
    entries.push_back(JsonValue((*node_)[i], *file_, key_ + "[" + std::to_string(i) + "]"));
  }
  return entries;
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::Members() const {
  if (!node_->is_object()) Fail(std::string("is ") + node_->type_name() + ", an object is needed");
  std::vector<std::pair<std::string, JsonValue>> members;
  for (const auto& [name, node] : node_->items()) {
    members.emplace_back(name, JsonValue(node, *file_, KeyOf(name)));
  }
  return members;
}

std::optional<JsonValue> JsonValue::Find(const char* name) const {
  const nlohmann::ordered_json* member = Member(name);
  if (member == nullptr || member->is_null()) return std::nullopt;
  return JsonValue(*member, *file_, KeyOf(name));
}

JsonValue JsonValue::Require(const char* name) const {
  const nlohmann::ordered_json* member = Member(name);
  if (member == nullptr) {
    FilePlace object = file_->PlaceOf(key_);
    object.field = KeyOf(name);
    throw InputError(object, "is missing");
  }
  return {*member, *file_, KeyOf(name)};
}

std::size_t JsonValue::OneOf(const std::vector<std::string>& names) const {
  const std::string text = Text();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) Fail(Quoted(text) + " is not known, " + Listed(names) + " is allowed");
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace sarblock
