// SPDX-License-Identifier: Apache-2.0
#include "xml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/text.h"

namespace sarblock {
namespace {

constexpr std::string_view kBlank = " \t\r\n";

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

// A number in front of `text`, which it is taken from; a plus sign may precede it.
std::optional<double> TakeNumber(std::string_view* text) {
  std::string_view digits = *text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  if (digits.starts_with('+') || (text->front() == '+' && digits.starts_with('-'))) {
    return std::nullopt;
  }
  double value = 0.0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  *text = std::string_view(stop, static_cast<std::size_t>(end - stop));
  return value;
}

}  // namespace

std::optional<std::vector<double>> NumbersOf(std::string_view text) {
  std::vector<double> numbers;
  text = Trimmed(text);
  while (!text.empty()) {
    const auto value = TakeNumber(&text);
    const bool separated = text.empty() || kBlank.find(text.front()) != std::string_view::npos;
    if (!value || !separated) return std::nullopt;
    numbers.push_back(*value);
    text = Trimmed(text);
  }
  return numbers;
}

XmlFile::XmlFile(std::string_view text, std::string file, const char* root)
    : file_(std::move(file)), line_begin_{0} {
  for (std::size_t i = text.find('\n'); i != std::string_view::npos; i = text.find('\n', i + 1)) {
    line_begin_.push_back(i + 1);
  }
  // parse_default reads no external entity and no DTD; nothing is fetched.
  const pugi::xml_parse_result result =
      document_.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result) {
    throw InputError(FilePlace{file_, LineOf(result.offset), ""},
                     std::string("is not valid XML: ") + result.description());
  }
  root_ = document_.document_element();
  if (std::string_view(root_.name()) != root) {
    throw InputError(FilePlace{file_, LineOf(root_.offset_debug()), root_.name()},
                     std::string("is not the element expected here, <") + root + "> is");
  }
}

XmlElement XmlFile::Root() const { return {this, root_}; }

std::size_t XmlFile::LineOf(std::ptrdiff_t offset) const {
  const auto at = static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0));
  return static_cast<std::size_t>(std::upper_bound(line_begin_.begin(), line_begin_.end(), at) -
                                  line_begin_.begin());
}

std::optional<XmlElement> XmlElement::Find(const char* name) const {
  const pugi::xml_node child = node_.child(name);
  if (!child) return std::nullopt;
  return XmlElement(file_, child);
}

XmlElement XmlElement::Child(const char* name) const {
  if (const auto child = Find(name)) return *child;
  throw InputError(FilePlace{file_->file(), line(), Path() + "." + name}, "the element is missing");
}

std::vector<XmlElement> XmlElement::Children(const char* name) const {
  std::vector<XmlElement> children;
  for (const pugi::xml_node child : node_.children(name)) children.emplace_back(file_, child);
  return children;
}

std::string XmlElement::Text() const {
  const std::string_view text = Trimmed(node_.text().get());
  if (text.empty()) Fail("is empty");
  return std::string(text);
}

std::string XmlElement::Name() const {
  std::string name = Text();
  const auto odd = [](char c) { return static_cast<unsigned char>(c) <= 0x20 || c == 0x7f; };
  if (name.size() > 20 || std::any_of(name.begin(), name.end(), odd)) {
    Fail("is not a short name without blanks");
  }
  return name;
}

double XmlElement::Number() const {
  const std::string whole = Text();
  std::string_view text = whole;
  const auto value = TakeNumber(&text);
  if (!value || !text.empty()) Fail(Quoted(whole) + " is not a finite number");
  return *value;
}

double XmlElement::Positive() const {
  const double value = Number();
  if (!(value > 0.0)) Fail("must be a number above 0, got " + Quoted(Text()));
  return value;
}

int XmlElement::Count() const {
  const std::string text = Text();
  int value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value < 0) {
    Fail("must be an integer of 0 or more, got " + Quoted(text));
  }
  return value;
}

std::size_t XmlElement::Pixels() const {
  constexpr int kMax = 10'000'000;
  const int count = Count();
  if (count < 2 || count > kMax) {
    Fail("must be 2 to " + std::to_string(kMax) + ", got " + Quoted(Text()));
  }
  return static_cast<std::size_t>(count);
}

void XmlElement::RequireText(const std::string& needed, const char* why) const {
  const std::string text = Text();
  if (text != needed) {
    Fail("must be " + Quoted(needed) + " (" + why + "), got " + Quoted(text));
  }
}

bool XmlElement::Has(const char* attribute) const { return !node_.attribute(attribute).empty(); }

int XmlElement::Attribute(const char* name, int most) const {
  const pugi::xml_attribute attribute = node_.attribute(name);
  const std::string_view text = attribute.value();
  int value = -1;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value < 0 || value > most) {
    Fail(std::string("its attribute ") + name + " must be an integer of 0 to " +
         std::to_string(most) + ", got " + Quoted(text));
  }
  return value;
}

std::string XmlElement::AttributeText(const char* name) const {
  return node_.attribute(name).value();
}

std::vector<double> XmlElement::Numbers() const {
  const std::string text = Text();
  auto numbers = NumbersOf(text);
  if (!numbers) Fail(Quoted(text) + " is not a list of finite numbers");
  return *std::move(numbers);
}

UtcTime XmlElement::Time() const {
  const std::string text = Text();
  const auto time = ParseUtc(text);
  if (!time) {
    Fail(Quoted(text) + " is no UTC time from 1972 on, such as 2022-10-16T01:50:44.577283");
  }
  return *time;
}

std::size_t XmlElement::line() const { return file_->LineOf(node_.offset_debug()); }

std::string XmlElement::Path() const {
  std::string path = node_.path('.');
  if (path.starts_with('.')) path.erase(0, 1);
  return path;
}

void XmlElement::Fail(const std::string& problem) const {
  throw InputError(FilePlace{file_->file(), line(), Path()}, problem);
}

}  // namespace sarblock
