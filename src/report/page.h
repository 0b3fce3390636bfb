// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sarblock {

enum class HeadlineState {
  kAccepted,
  kTestsFailed,
  kNotAccepted,
  kNeutral,  ///< nothing to accept: a prediction, a study, a comparison
};

/// The first thing a reader sees: is it accepted and why, how accurate, what limits it.
struct Headline {
  HeadlineState state = HeadlineState::kNeutral;
  std::string word;                    ///< "Accepted"
  std::vector<std::string> sentences;  ///< three at most: verdict, accuracy, what would help
  std::string would_help;              ///< in a few words; may be empty
  std::vector<std::string> attention;  ///< what a careful reader should look at; may be empty
};

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
/// The text of an SVG file, shown as an image (scripts in it do not run).
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

/// Text escaped for use between tags and in quoted attributes: & < > " ' become references, control
/// characters other than tab and newline the replacement character, and so does what is not UTF-8.
[[nodiscard]] std::string EscapeHtml(std::string_view text);

/// JSON escaped for use inside a script element: < > & and the two line separators that a script
/// would take for line ends become \u escapes. They occur in strings only, so the value is the
/// same.
[[nodiscard]] std::string EscapeScriptJson(std::string_view json);

/// A number for people with `digits` significant digits and without an exponent between 1e-5 and
/// 1e9; "-" for NaN. A thin space parts thousands from five digits before the point on.
[[nodiscard]] std::string ReadableNumber(double value, int digits = 4);

/// A count with thin spaces between groups of three from five digits on.
[[nodiscard]] std::string ReadableCount(double count);
[[nodiscard]] inline std::string ReadableCount(std::size_t count) {
  return ReadableCount(static_cast<double>(count));
}

/// A number with four significant digits; a probability or a part of one as percent.
[[nodiscard]] std::string Shown(double value, int digits = 4);
[[nodiscard]] std::string ShownPercent(double part);
/// "1.2 +- 0.3"
[[nodiscard]] std::string ShownWithSigma(double value, double sigma);
/// The first letter in capitals.
[[nodiscard]] std::string Capital(std::string text);

/// A file of src/report/assets, or the chart library, as it was when the program was built
/// (cmake/embed_files.cmake writes the definition). std::out_of_range for another name.
[[nodiscard]] std::string_view AssetText(std::string_view name);

}  // namespace sarblock
