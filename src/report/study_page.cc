// SPDX-License-Identifier: Apache-2.0
#include "study_page.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "html.h"
#include "shown.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostShownRows = 800;      // of a table in the page
constexpr std::size_t kMostSentenceBytes = 240;  // longer answers stand in their list only
constexpr std::size_t kMostSentences = 3;

/// Messages may be long; the table of the study has them whole.
std::string Shortened(const std::string& text) {
  constexpr std::size_t kMostBytes = 160;
  if (text.size() <= kMostBytes) return text;
  return text.substr(0, text.rfind(' ', kMostBytes)) + " ...";
}

std::string Sentence(std::string line) {
  line = Capital(std::move(line));
  if (!line.ends_with('.')) line += '.';
  return line;
}

}  // namespace

std::string InWords(const std::string& column) {
  static const std::map<std::string, std::string> kWords{{"e", "east"},
                                                         {"n", "north"},
                                                         {"u", "up"},
                                                         {"h", "in plan"},
                                                         {"max", "largest"},
                                                         {"montecarlo", "runs,"},
                                                         {"nees", "normalised error squared"},
                                                         {"pareto", "nothing faster and better"}};
  static const std::map<std::string, std::string> kUnits{
      {"m", "[m]"}, {"m2", "[m2]"}, {"s", "[s]"}, {"mib", "[MiB]"}};
  std::vector<std::string> parts;
  std::istringstream stream(column);
  for (std::string part; std::getline(stream, part, '_');) parts.push_back(part);
  std::string out;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& names = i > 0 && i + 1 == parts.size() ? kUnits : kWords;
    const auto found = names.find(parts[i]);
    out += (i == 0 ? "" : " ") + (found == names.end() ? parts[i] : found->second);
  }
  return out;
}

PageTable WholeTable(const StudyCsv& table, const std::set<std::string>& texts) {
  PageTable out;
  out.title = "All rows";
  for (const std::string& column : table.columns) {
    out.columns.push_back({InWords(column), texts.count(column) == 0});
  }
  for (std::size_t r = 0; r < std::min(table.rows.size(), kMostShownRows); ++r) {
    std::vector<std::string> row;
    for (const std::string& column : table.columns) {
      const std::string text = table.Text(r, column);
      const double value = table.Number(r, column);
      const bool whole = text.find_first_not_of("0123456789") == std::string::npos;
      row.push_back(texts.count(column) != 0 || std::isnan(value) ? Shortened(text)
                    : whole                                       ? ReadableCount(value)
                                                                  : Shown(value));
    }
    out.rows.push_back(std::move(row));
  }
  if (table.rows.size() > kMostShownRows) {
    out.note =
        fmt::format("The first {} of {} rows.", kMostShownRows, ReadableCount(table.rows.size()));
  }
  return out;
}

std::vector<std::size_t> RowsOf(const StudyCsv& table,
                                const std::string& column,
                                const std::string& value,
                                const std::string& order_by) {
  std::vector<std::size_t> rows;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (table.Text(r, column) == value) rows.push_back(r);
  }
  const auto key = [&](std::size_t row) {
    const double number = table.Number(row, order_by);
    return std::isnan(number) ? std::numeric_limits<double>::infinity() : number;
  };
  std::stable_sort(
      rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return rows;
}

Page MakeStudyPage(const StudyFolder& study) {
  Page page;
  page.kind = "Study";
  page.title = "Study";
  for (const StudyCsv& table : study.tables) {
    StudyPart part = table.kind == "densification" ? DensificationPart(table)
                     : table.kind == "tradeoff"    ? TradeoffPart(table)
                                                   : StabilityPart(table);
    if (study.tables.size() == 1) page.title = Capital(table.kind) + " study";
    page.kind += (page.kind == "Study" ? ": " : ", ") + table.kind;
    Headline& headline = page.headline;
    headline.state = std::max(headline.state, part.state, [](HeadlineState a, HeadlineState b) {
      // Neutral says nothing; of the others the graver one counts.
      return a == HeadlineState::kNeutral || (b != HeadlineState::kNeutral && a < b);
    });
    headline.word += (headline.word.empty() ? "" : "; ") + part.word;
    if (study.answers.empty()) {
      headline.sentences.insert(
          headline.sentences.end(), part.sentences.begin(), part.sentences.end());
      headline.attention.push_back("The answers of " + table.kind +
                                   ".txt are missing: the study is not finished.");
    }
    headline.attention.insert(
        headline.attention.end(), part.attention.begin(), part.attention.end());
    page.facts.insert(page.facts.end(), part.facts.begin(), part.facts.end());
    page.sections.push_back(std::move(part.section));
  }
  if (!study.name.empty()) page.title = study.name;
  if (!study.purpose.empty()) page.subtitle = "Goal: " + study.purpose;
  for (const std::string& line : study.answers) {
    if (page.headline.sentences.size() < kMostSentences && line.size() <= kMostSentenceBytes) {
      page.headline.sentences.push_back(Sentence(line));
    }
  }
  if (study.answers.size() > page.headline.sentences.size()) {
    PageSection section{"answers", "All answers", {}};
    PageList list;
    for (const std::string& line : study.answers) list.items.push_back(Sentence(line));
    section.items.emplace_back(std::move(list));
    page.sections.push_back(std::move(section));
  }
  if (!study.pictures.empty()) {
    PageSection section{"plots", "Plots of the study", {}};
    for (const StudyPicture& picture : study.pictures) {
      section.items.emplace_back(PagePicture{Capital(InWords(picture.name)), picture.svg});
    }
    page.sections.push_back(std::move(section));
  }
  return page;
}

}  // namespace sarblock
