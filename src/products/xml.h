// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/utc.h"
#include <pugixml.hpp>

namespace sarblock {

class XmlElement;

/// Numbers separated by blanks, all of the text; nothing where it is something else.
[[nodiscard]] std::optional<std::vector<double>> NumbersOf(std::string_view text);

/// A parsed XML text that knows its lines. Every refusal is an InputError with file, line and the
/// path of the element (`product.imageAnnotation.imageInformation.slantRangeTime`).
class XmlFile {
 public:
  /// `root` is the element the file must have outermost.
  XmlFile(std::string_view text, std::string file, const char* root);
  XmlFile(const XmlFile&) = delete;
  XmlFile& operator=(const XmlFile&) = delete;

  [[nodiscard]] XmlElement Root() const;
  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] std::size_t LineOf(std::ptrdiff_t offset) const;

 private:
  std::string file_;
  std::vector<std::size_t> line_begin_;  // offsets
  pugi::xml_document document_;
  pugi::xml_node root_;
};

/// An element of such a file; a view that must not outlive it.
class XmlElement {
 public:
  XmlElement(const XmlFile* file, pugi::xml_node node) : file_(file), node_(node) {}

  [[nodiscard]] std::optional<XmlElement> Find(const char* name) const;
  /// The child of this name; refuses where there is none.
  [[nodiscard]] XmlElement Child(const char* name) const;
  [[nodiscard]] std::vector<XmlElement> Children(const char* name) const;

  [[nodiscard]] std::string Text() const;  ///< refused if empty
  [[nodiscard]] std::string Name() const;  ///< short and without blanks: it becomes part of an id
  [[nodiscard]] double Number() const;     ///< all of the text, finite
  [[nodiscard]] double Positive() const;
  [[nodiscard]] int Count() const;  ///< an integer of 0 or more
  /// Refuses any other text; `why` is for people.
  void RequireText(const std::string& needed, const char* why) const;
  /// A number of lines or samples of an image: 2 to 10,000,000.
  [[nodiscard]] std::size_t Pixels() const;
  [[nodiscard]] bool Has(const char* attribute) const;
  /// An attribute, an integer of 0 to `most`.
  [[nodiscard]] int Attribute(const char* name, int most) const;
  [[nodiscard]] std::vector<double> Numbers() const;  ///< separated by blanks
  [[nodiscard]] UtcTime Time() const;

  /// Empty where there is none.
  [[nodiscard]] std::string AttributeText(const char* name) const;

  [[nodiscard]] std::size_t line() const;
  [[nodiscard]] std::string Path() const;  ///< `SICD.Position.ARPPoly`
  [[noreturn]] void Fail(const std::string& problem) const;

 private:
  const XmlFile* file_;
  pugi::xml_node node_;
};

}  // namespace sarblock
