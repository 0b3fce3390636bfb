// SPDX-License-Identifier: Apache-2.0
#include "page.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

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

namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";
constexpr std::string_view kThinSpace = "\xe2\x80\xaf";  // narrow and not breaking

/// Bytes of the well-formed UTF-8 sequence at `at`; 0 where there is none.
std::size_t SequenceLength(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(at);
  if (lead < 0x80U) return 1;
  const std::size_t length = lead >= 0xf0U ? 4 : (lead >= 0xe0U ? 3 : 2);
  if (lead < 0xc2U || lead > 0xf4U || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0U) != 0x80U) return 0;
  }
  const unsigned second = byte(at + 1);
  const bool overlong = (lead == 0xe0U && second < 0xa0U) || (lead == 0xf0U && second < 0x90U);
  const bool surrogate = lead == 0xedU && second >= 0xa0U;
  const bool beyond = lead == 0xf4U && second >= 0x90U;
  return overlong || surrogate || beyond ? 0 : length;
}

std::string Grouped(const std::string& number) {
  const std::size_t start = number.find_first_of("0123456789");
  std::size_t end = number.find_first_not_of("0123456789", start);
  if (end == std::string::npos) end = number.size();
  if (start == std::string::npos || end - start < 5) return number;
  std::string out = number.substr(0, start);
  for (std::size_t i = start; i < end; ++i) {
    if (i > start && (end - i) % 3 == 0) out += kThinSpace;
    out += number[i];
  }
  return out + number.substr(end);
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = SequenceLength(text, i);
    const char c = text[i];
    if (length == 0 || (static_cast<unsigned char>(c) < 0x20U && c != '\t' && c != '\n') ||
        c == '\x7f') {
      out += kReplacement;
      ++i;
      continue;
    }
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += text.substr(i, length);
    }
    i += length;
  }
  return out;
}

std::string EscapeScriptJson(std::string_view json) {
  std::string out;
  out.reserve(json.size() + json.size() / 64);
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else if (json.substr(i, 3) == "\xe2\x80\xa8" || json.substr(i, 3) == "\xe2\x80\xa9") {
      out += json[i + 2] == '\xa8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else {
      out += c;
    }
  }
  return out;
}

std::string ReadableNumber(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  if (value == 0.0) return "0";
  const double size = std::abs(value);
  if (size < 1e-5 || size >= 1e9) return fmt::format("{:.{}e}", value, digits - 1);
  const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
  return Grouped(fmt::format("{:.{}f}", value, std::max(0, digits - before)));
}

std::string ReadableCount(double count) {
  return std::isnan(count) ? "-" : Grouped(fmt::format("{:.0f}", count));
}

std::string Shown(double value, int digits) { return ReadableNumber(value, digits); }

std::string ShownPercent(double part) {
  return std::isnan(part) ? "-" : ReadableNumber(100.0 * part, 3) + " %";
}

std::string ShownWithSigma(double value, double sigma) {
  return std::isnan(sigma) ? Shown(value) : Shown(value) + " \xc2\xb1 " + Shown(sigma, 2);
}

std::string Capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

}  // namespace sarblock
