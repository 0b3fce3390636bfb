// SPDX-License-Identifier: Apache-2.0
#include "pvl.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/text.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::uint64_t kLongestLabel = 8U << 20U;

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\0'; }

std::string_view TrimmedLine(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

// Place of the line `End`, at or after the line with `from`.
std::size_t FindEnd(std::string_view text, std::size_t from) {
  std::size_t begin = from == 0 ? 0 : text.rfind('\n', from - 1) + 1;  // npos + 1 is 0
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end < text.size() && SameName(TrimmedLine(text.substr(begin, end - begin)), "End")) {
      return begin;
    }
    begin = end + 1;
  }
  return std::string_view::npos;
}

}  // namespace

bool SameName(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

/// Recursive descent over the text before `End`; depth is bounded.
class PvlParser {
 public:
  PvlParser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  PvlObject Parse() {
    PvlObject root;
    root.file_ = file_;
    root.line_ = 1;
    ParseBody(&root, 0);
    return root;
  }

 private:
  static constexpr std::size_t kDeepest = 16;

  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(FilePlace{file_, line_, "label"}, problem);
  }
  [[nodiscard]] bool AtEnd() const { return at_ >= text_.size(); }
  char Take() {
    if (text_[at_] == '\n') ++line_;
    return text_[at_++];
  }
  void SkipTo(std::string_view mark) {
    while (!AtEnd() && !text_.substr(at_).starts_with(mark)) Take();
  }
  void SkipBlanks() {
    while (!AtEnd()) {
      if (IsBlank(text_[at_])) {
        Take();
      } else if (text_[at_] == '#') {
        SkipTo("\n");
      } else if (text_.substr(at_).starts_with("/*")) {
        SkipTo("*/");
        at_ = std::min(at_ + 2, text_.size());
      } else {
        return;
      }
    }
  }
  void SkipSpaces() {
    while (!AtEnd() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) Take();
  }

  std::string ParseName() {
    const std::size_t begin = at_;
    while (!AtEnd() && !IsBlank(text_[at_]) && text_[at_] != '=') Take();
    return std::string(text_.substr(begin, at_ - begin));
  }

  std::string ParseQuoted() {
    const char quote = Take();
    std::string value;
    while (!AtEnd() && text_[at_] != quote) value += Take();
    if (AtEnd()) Fail("a text in quotation marks does not end");
    Take();
    return value;
  }

  // A word; `-` at the end of a line joins it with the next one.
  std::string ParseWord() {
    std::string value;
    while (!AtEnd()) {
      const char c = text_[at_];
      if (c == ',' || c == '(' || c == ')' || c == '{' || c == '}' || c == '<') break;
      if (IsBlank(c)) {
        if (!value.ends_with('-') || value.size() < 2) break;
        const std::size_t rest = text_.find_first_not_of(" \t\r", at_);
        if (rest == std::string_view::npos || text_[rest] != '\n') break;
        value.pop_back();
        SkipBlanks();
        continue;
      }
      value += Take();
    }
    if (value.empty()) Fail("a value is missing");
    return value;
  }

  void ParseUnit(PvlKey* key) {
    SkipSpaces();
    if (AtEnd() || text_[at_] != '<') return;
    const std::size_t begin = at_ + 1;
    SkipTo(">");
    if (AtEnd()) Fail("a unit does not end, '>' is needed");
    key->unit = std::string(text_.substr(begin, at_ - begin));
    Take();
  }

  void ParseValue(PvlKey* key, std::size_t depth) {
    if (depth > kDeepest) Fail("lists are nested too deep");
    SkipBlanks();
    if (AtEnd()) Fail("a value is missing");
    const char c = text_[at_];
    if (c == '"' || c == '\'') {
      key->values.push_back(ParseQuoted());
    } else if (c == '(' || c == '{') {
      if (depth > 0) ++key->inner_lists;
      ParseList(key, depth);
    } else {
      key->values.push_back(ParseWord());
    }
    ParseUnit(key);
  }

  void ParseList(PvlKey* key, std::size_t depth) {
    Take();
    for (;;) {
      SkipBlanks();
      if (AtEnd()) Fail("a list does not end, ')' is needed");
      if (text_[at_] == ')' || text_[at_] == '}') break;
      if (text_[at_] == ',') {
        Take();
        continue;
      }
      ParseValue(key, depth + 1);
    }
    Take();
  }

  void ParseChild(PvlObject* parent, std::size_t depth, std::size_t line, const std::string& name) {
    if (depth >= kDeepest) Fail("objects are nested too deep");
    PvlObject child;
    child.file_ = file_;
    child.name_ = name;
    child.path_ = parent->path_.empty() ? name : parent->path_ + "." + name;
    child.line_ = line;
    ParseBody(&child, depth + 1);
    parent->children_.push_back(std::move(child));
  }

  void ParseBody(PvlObject* object, std::size_t depth) {
    for (SkipBlanks(); !AtEnd(); SkipBlanks()) {
      PvlKey key;
      key.line = line_;
      key.name = ParseName();
      SkipSpaces();
      const bool valued = !AtEnd() && text_[at_] == '=';
      if (SameName(key.name, "End_Object") || SameName(key.name, "End_Group") ||
          SameName(key.name, "EndObject") || SameName(key.name, "EndGroup")) {
        if (valued) {
          Take();
          ParseValue(&key, 0);
        }
        if (depth == 0) Fail(Quoted(key.name) + " ends nothing");
        return;
      }
      if (!valued) Fail(Quoted(key.name) + " is not followed by '='");
      Take();
      ParseValue(&key, 0);
      if (SameName(key.name, "Object") || SameName(key.name, "Group")) {
        ParseChild(object, depth, key.line, key.values.empty() ? "" : key.values.front());
      } else {
        object->keys_.push_back(std::move(key));
      }
    }
    if (depth > 0) Fail("object " + Quoted(object->name_) + " does not end");
  }

  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0, line_ = 1;
};

const PvlObject* PvlObject::Find(std::string_view name) const {
  for (const PvlObject& child : children_) {
    if (SameName(child.name_, name)) return &child;
  }
  return nullptr;
}

const PvlObject& PvlObject::Child(std::string_view name) const {
  const PvlObject* const child = Find(name);
  if (child == nullptr) Fail(name, "is missing in the label");
  return *child;
}

const PvlKey* PvlObject::FindKey(std::string_view name) const {
  for (const PvlKey& key : keys_) {
    if (SameName(key.name, name)) return &key;
  }
  return nullptr;
}

const PvlKey& PvlObject::Key(std::string_view name) const {
  const PvlKey* const key = FindKey(name);
  if (key == nullptr) Fail(name, "is missing in the label");
  return *key;
}

std::string PvlObject::Text(std::string_view key) const {
  const PvlKey& found = Key(key);
  if (found.values.size() != 1 || found.values.front().empty()) Fail(key, "one value is needed");
  return found.values.front();
}

double PvlObject::NumberOf(const PvlKey& key, std::size_t index) const {
  const std::string& text = key.values[index];
  const char* begin = text.data();
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') ++begin;
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) {
    Fail(key.name, Quoted(text) + " is not a finite number");
  }
  return value;
}

double PvlObject::Number(std::string_view key) const { return Numbers(key, 1).front(); }

double PvlObject::Positive(std::string_view key) const {
  const double value = Number(key);
  if (!(value > 0.0)) Fail(key, "must be a number above 0, got " + NumberText(value));
  return value;
}

std::uint64_t PvlObject::Count(std::string_view key, std::uint64_t least) const {
  constexpr double kMax = 9007199254740992.0;  // 2^53: every integer up to it is a double
  const double value = Number(key);
  if (value != std::floor(value) || value < static_cast<double>(least) || value > kMax) {
    Fail(key, fmt::format("must be an integer of {1} or more, got {0}", NumberText(value), least));
  }
  return static_cast<std::uint64_t>(value);
}

std::vector<double> PvlObject::Numbers(std::string_view key, std::size_t count) const {
  const PvlKey& found = Key(key);
  if (found.values.size() != count) {
    Fail(key, fmt::format("has {} values, {} is needed", found.values.size(), count));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(NumberOf(found, i));
  return numbers;
}

void PvlObject::Fail(std::string_view key, const std::string& problem) const {
  const PvlKey* const found = FindKey(key);
  throw InputError(FilePlace{file_,
                             found != nullptr ? found->line : line_,
                             (path_.empty() ? "" : path_ + ".") + std::string(key)},
                   problem);
}

PvlObject ReadPvlLabel(ByteSource* source) {
  constexpr std::uint64_t kPiece = 64U << 10U;
  const std::uint64_t most = std::min(source->size(), kLongestLabel);
  std::string text;
  while (text.size() < most) {
    const std::size_t seen = text.size();
    text +=
        source->Read(seen, std::min(most - seen, std::max<std::uint64_t>(kPiece, seen)), "label");
    if (seen == 0 && text.find('=') == std::string::npos) break;
    if (text.size() == source->size()) text += '\n';  // of a last line without one
    const std::size_t end = FindEnd(text, seen);
    if (end == std::string_view::npos) continue;
    return PvlParser(std::string_view(text).substr(0, end), source->file()).Parse();
  }
  throw InputError(
      FilePlace{source->file(), 0, "label"},
      text.find('=') == std::string::npos ? "is no label: the file does not begin with NAME = VALUE"
      : source->size() < kLongestLabel ? "the file ends before its label does: a line End is needed"
                                       : "is longer than 8 MiB, which no label of ISIS is");
}

}  // namespace sarblock
