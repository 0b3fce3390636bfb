// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "charts.h"
#include "result_folder.h"
#include "shown.h"
#include "study_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::array kOutcomes{"ok", "warned", "refused", "wrong"};
constexpr std::array kOutcomeWords{
    "solved", "solved with a warning", "refused", "wrong without a word"};
constexpr std::array kOutcomeColors{"blue", "yellow", "grey", "orange"};
constexpr std::size_t kNamedRows = 8;

/// Correct digits against the condition; the rows with the fewest that were accepted are named.
PageFigure DigitFigure(const StudyCsv& table, const std::string& column, const std::string& title) {
  XyChart chart;
  chart.x = {"condition of the column-scaled Jacobian", true, kAbsent, kAbsent};
  chart.y.label = "correct digits";
  for (std::size_t o = 0; o < kOutcomes.size(); ++o) {
    ChartSeries dots{kOutcomeWords[o], "points", kOutcomeColors[o], {}, {}, {}, {}, {}};
    std::vector<std::size_t> order;
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const double digits = table.Number(r, column), condition = table.Number(r, "condition");
      if (table.Text(r, "outcome") != kOutcomes[o] || std::isnan(digits) || !(condition > 0.0)) {
        continue;
      }
      order.push_back(r);
    }
    const bool named = o == 0 || o == 3;
    if (named) {
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return table.Number(a, column) < table.Number(b, column);
      });
    }
    for (const std::size_t r : order) {
      dots.x.push_back(table.Number(r, "condition"));
      dots.y.push_back(table.Number(r, column));
      dots.names.push_back(!named || dots.names.size() < kNamedRows
                               ? table.Text(r, "family") + " " + Shown(table.Number(r, "value"), 3)
                               : "");
    }
    dots.written = named;
    if (!dots.x.empty()) chart.series.push_back(std::move(dots));
  }
  const std::string id = "stability-" + column;
  return {id, title, "", "wide", ChartJson(id, chart)};
}

}  // namespace

StudyPart StabilityPart(const StudyCsv& table) {
  StudyPart out;
  out.section = {"stability", "Where numbers give out", {}};
  std::array<std::size_t, 4> of_outcome{};
  PageTable counts;
  counts.title = "Outcomes by family";
  counts.columns = {{"family", false}};
  for (const char* outcome : kOutcomeWords) counts.columns.push_back({outcome, true});
  counts.columns.push_back({"fewest digits of covariances, where solved", true});
  for (const std::string& family : table.Values("family")) {
    std::array<std::size_t, 4> here{};
    double digits = kAbsent;
    for (const std::size_t r : RowsOf(table, "family", family, "condition")) {
      for (std::size_t o = 0; o < kOutcomes.size(); ++o) {
        if (table.Text(r, "outcome") != kOutcomes[o]) continue;
        ++here[o];
        ++of_outcome[o];
        if (o == 0) digits = std::fmin(digits, table.Number(r, "covariance_digits"));
      }
    }
    if (here[3] > 0) counts.marked.push_back(counts.rows.size());
    std::vector<std::string> row{family};
    for (const std::size_t count : here) row.push_back(std::to_string(count));
    row.push_back(Shown(digits, 3));
    counts.rows.push_back(std::move(row));
  }
  const bool wrong = of_outcome[3] > 0;
  out.state = wrong ? HeadlineState::kNotAccepted : HeadlineState::kAccepted;
  out.word = wrong ? "Wrong answers were given" : "No wrong answer was given";
  out.sentences.push_back(
      fmt::format("Of {} blocks made to break the numbers, {} were solved, {} solved with a "
                  "warning, {} refused and {} answered wrongly without a word.",
                  table.rows.size(),
                  of_outcome[0],
                  of_outcome[1],
                  of_outcome[2],
                  of_outcome[3]));
  for (const auto& [column, title] :
       {std::pair<std::string, std::string>{"covariance_digits", "Correct digits of covariances"},
        {"position_digits", "Correct digits of positions"}}) {
    if (table.HasNumbers(column)) {
      out.section.items.emplace_back(DigitFigure(table, column, title));
    }
  }
  out.section.items.emplace_back(std::move(counts));
  out.section.items.emplace_back(WholeTable(table, {"family", "parameter", "outcome", "message"}));
  return out;
}

}  // namespace sarblock
