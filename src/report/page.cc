// SPDX-License-Identifier: Apache-2.0
#include "page.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "assets.h"
#include "html.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

const char* ClassOf(HeadlineState state) {
  switch (state) {
    case HeadlineState::kAccepted:
      return "accepted";
    case HeadlineState::kTestsFailed:
      return "failed";
    case HeadlineState::kNotAccepted:
      return "refused";
    case HeadlineState::kNeutral:
      break;
  }
  return "neutral";
}

std::string Base64(std::string_view bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group =
          (group << 8U) | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? kDigits[(group >> (18U - 6U * static_cast<unsigned>(k))) & 63U]
                                   : '=';
    }
  }
  return out;
}

class Renderer {
 public:
  std::string Render(const Page& page) {
    std::string contents;
    for (const PageSection& section : page.sections) {
      contents +=
          fmt::format("<li><a href=\"#{}\">{}</a></li>\n", section.id, EscapeHtml(section.title));
      html_ +=
          fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", section.id, EscapeHtml(section.title));
      for (const PageItem& item : section.items) {
        std::visit([this](const auto& value) { Add(value); }, item);
      }
      html_ += "</section>\n";
    }
    const std::map<std::string_view, std::string> values = {
        {"title", EscapeHtml(page.title)},
        {"kind", EscapeHtml(page.kind)},
        {"subtitle", EscapeHtml(page.subtitle)},
        {"state", ClassOf(page.headline.state)},
        {"word", EscapeHtml(page.headline.word)},
        {"verdict", HeadlineText(page)},
        {"contents", contents},
        {"sections", html_},
        {"version", EscapeHtml(Version())},
        {"style", std::string(AssetText("style.css"))},
        {"charts", std::string(AssetText("charts.js"))},
        {"map", std::string(AssetText("map.js"))},
        {"tables", std::string(AssetText("tables.js"))},
        {"script", std::string(AssetText("report.js"))},
        {"chart_library", std::string(AssetText("chart.min.js"))},
        {"chart_licence", EscapeHtml(AssetText("chart_licence.txt"))},
        {"data", EscapeScriptJson("{\"charts\":[" + charts_ + "]}")}};
    return Fill(AssetText("page.html"), values);
  }

 private:
  /// The template with every {{name}} replaced.
  static std::string Fill(std::string_view text,
                          const std::map<std::string_view, std::string>& values) {
    std::string out;
    for (;;) {
      const std::size_t open = text.find("{{");
      out += text.substr(0, open);
      if (open == std::string_view::npos) return out;
      const std::size_t close = text.find("}}", open);
      out += values.at(text.substr(open + 2, close - open - 2));
      text.remove_prefix(close + 2);
    }
  }

  static std::string Facts(const std::vector<PageFact>& facts) {
    if (facts.empty()) return "";
    std::string out = "<dl class=\"facts\">\n";
    for (const PageFact& fact : facts) {
      out += fmt::format("<div><dt>{}</dt><dd><b>{}</b> <span>{}</span></dd></div>\n",
                         EscapeHtml(fact.label),
                         EscapeHtml(fact.value),
                         EscapeHtml(fact.remark));
    }
    return out + "</dl>\n";
  }

  static std::string HeadlineText(const Page& page) {
    std::string out;
    for (const std::string& sentence : page.headline.sentences) {
      out += "<p>" + KeepPercent(EscapeHtml(sentence)) + "</p>\n";
    }
    out += Facts(page.facts);
    if (!page.headline.attention.empty()) {
      out += "<p class=\"attention\">Look at:</p>\n<ul>\n";
      for (const std::string& line : page.headline.attention) {
        out += "<li>" + KeepPercent(EscapeHtml(line)) + "</li>\n";
      }
      out += "</ul>\n";
    }
    return out;
  }

  /// With spaces before percent signs that do not break.
  static std::string KeepPercent(std::string text) {
    constexpr std::string_view kBreaking = " %", kKept = "&#160;%";
    for (std::size_t at = text.find(kBreaking); at != std::string::npos;
         at = text.find(kBreaking, at)) {
      text.replace(at, kBreaking.size(), kKept);
    }
    return text;
  }

  void Add(const PageText& text) {
    if (text.kind == "heading") {
      html_ += fmt::format("<h3>{}</h3>\n", EscapeHtml(text.text));
      return;
    }
    html_ += fmt::format("<p{}>{}</p>\n",
                         text.kind.empty() ? "" : " class=\"" + text.kind + "\"",
                         EscapeHtml(text.text));
  }

  void Add(const PageTable& table) {
    if (table.folded) {
      html_ += fmt::format("<details>\n<summary>{}</summary>\n", EscapeHtml(table.title));
    } else if (!table.title.empty()) {
      html_ += fmt::format("<h3>{}</h3>\n", EscapeHtml(table.title));
    }
    html_ += fmt::format("<div class=\"scroll\"><table{}>\n<thead><tr>",
                         table.plain ? " class=\"plain\"" : "");
    for (const PageColumn& column : table.columns) {
      html_ += fmt::format(
          "<th{}>{}</th>", column.number ? " class=\"n\"" : "", EscapeHtml(column.title));
    }
    html_ += "</tr></thead>\n<tbody>\n";
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const bool marked =
          std::find(table.marked.begin(), table.marked.end(), r) != table.marked.end();
      html_ += marked ? "<tr class=\"marked\">" : "<tr>";
      for (std::size_t c = 0; c < table.rows[r].size(); ++c) {
        const bool number = c < table.columns.size() && table.columns[c].number;
        html_ += fmt::format(
            "<td{}>{}</td>", number ? " class=\"n\"" : "", EscapeHtml(table.rows[r][c]));
      }
      html_ += "</tr>\n";
    }
    html_ += "</tbody>\n</table></div>\n";
    if (!table.note.empty()) Add(PageText{table.note, "note"});
    if (table.folded) html_ += "</details>\n";
  }

  void Add(const PageFigure& figure) {
    html_ += fmt::format(
        "<figure class=\"{0}\"><h3>{1}</h3>\n<div class=\"canvas\"><canvas id=\"{2}\" role=\"img\" "
        "aria-label=\"{1}\"></canvas></div>\n",
        figure.size,
        EscapeHtml(figure.title),
        EscapeHtml(figure.id));
    if (!figure.caption.empty()) {
      html_ += fmt::format("<figcaption>{}</figcaption>\n", EscapeHtml(figure.caption));
    }
    html_ += "</figure>\n";
    charts_ += (charts_.empty() ? "" : ",\n") + figure.json;
  }

  void Add(const PageFigures& group) {
    html_ += "<div class=\"figures\">\n";
    for (const PageFigure& figure : group.figures) Add(figure);
    html_ += "</div>\n";
  }

  void Add(const PagePicture& picture) {
    html_ += fmt::format(
        "<figure class=\"wide\"><h3>{0}</h3>\n<img alt=\"{0}\" "
        "src=\"data:image/svg+xml;base64,{1}\"></figure>\n",
        EscapeHtml(picture.title),
        Base64(picture.svg));
  }

  void Add(const PageFacts& facts) { html_ += Facts(facts.facts); }

  void Add(const PageList& list) {
    html_ += "<ul>\n";
    for (const std::string& item : list.items) html_ += "<li>" + EscapeHtml(item) + "</li>\n";
    html_ += "</ul>\n";
  }

  void Add(const PagePre& pre) {
    html_ += fmt::format("<details>\n<summary>{}</summary>\n<pre>{}</pre>\n</details>\n",
                         EscapeHtml(pre.title),
                         EscapeHtml(pre.text));
  }

  std::string html_;
  std::string charts_;
};

}  // namespace

std::string RenderPage(const Page& page) { return Renderer().Render(page); }

}  // namespace sarblock
