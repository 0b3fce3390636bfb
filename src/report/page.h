// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "headline_struct.h"

namespace sarblock {

/// A report before it is written: plain text everywhere, escaped only by RenderPage.

/// A paragraph. `kind` is a class of style.css: "", "note", "answer"; or it is a "heading".
struct PageText {
  std::string text;
  std::string kind;
};

struct PageColumn {
  std::string title;
  bool number = false;  ///< aligned to the right
};
/// The script shows the first ten rows, more on demand, sorts by a column and filters.
struct PageTable {
  std::string title;
  std::vector<PageColumn> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> marked;  ///< rows to be noticed
  std::string note;
  bool folded = false;  ///< behind its title until asked for; open on paper
  bool plain = false;   ///< all rows, in their order: figures by name, not a list
};

/// A chart: `json` is what charts.h makes. `size` is a class of style.css: "map", "wide", "half",
/// "small".
struct PageFigure {
  std::string id;
  std::string title;
  std::string caption;
  std::string size = "wide";
  std::string json;
};
/// Figures side by side where there is room.
struct PageFigures {
  std::vector<PageFigure> figures;
};
/// A picture in SVG as it stands in a file, shown as an image (scripts in it do not run).
struct PagePicture {
  std::string title;
  std::string svg;
};
/// Label, value and a remark, as tiles.
struct PageFact {
  std::string label, value, remark;
};
struct PageFacts {
  std::vector<PageFact> facts;
};
struct PageList {
  std::vector<std::string> items;
};
/// Text with its line breaks, such as TOML.
struct PagePre {
  std::string title, text;
};

using PageItem = std::variant<PageText,
                              PageTable,
                              PageFigure,
                              PageFigures,
                              PagePicture,
                              PageFacts,
                              PageList,
                              PagePre>;

struct PageSection {
  std::string id;
  std::string title;
  std::vector<PageItem> items;
};

struct Page {
  std::string title;     ///< of the document
  std::string kind;      ///< "Adjustment", above the title
  std::string subtitle;  ///< below it
  Headline headline;
  std::vector<PageFact> facts;  ///< beside the headline
  std::vector<PageSection> sections;
};

/// The page as one HTML file that needs no other.
[[nodiscard]] std::string RenderPage(const Page& page);

}  // namespace sarblock
