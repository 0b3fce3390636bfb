// SPDX-License-Identifier: Apache-2.0
#include "tradeoff_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/core.h>

namespace sarblock {
namespace {

std::string FigureAs(double value, const char* format = "{:.2g}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "";
}

std::string Seconds(double value_s) {
  if (!std::isfinite(value_s)) return "";
  return value_s < 0.1 ? fmt::format("{:.2g} ms", 1e3 * value_s) : fmt::format("{:.3g} s", value_s);
}

/// "3.1 (2.9 to 3.3)"; one number where nothing was repeated.
std::string Ratio(const TradeoffRow& row) {
  if (!std::isfinite(row.speed_ratio_1)) return "";
  if (row.reference) return "1";
  if (row.repeats == 1) return FigureAs(row.speed_ratio_1);
  return fmt::format(
      "{:.2g} ({:.2g} to {:.2g})", row.speed_ratio_1, row.speed_low_1, row.speed_high_1);
}

std::string Missing(const AnswerErrors& errors) {
  if (errors.points_missing > 0)
    return fmt::format("{} points without position", errors.points_missing);
  if (errors.points_unjudged > 0 && std::isfinite(errors.covariance_error_1)) {
    return fmt::format("{} points without covariance", errors.points_unjudged);
  }
  return "";
}

std::string Remark(const TradeoffRow& row) {
  std::string text;
  for (const std::string& part :
       {std::string(row.reference ? "reference" : ""),
        std::string(row.accepted || row.repeats == 0 ? "" : "not accepted"),
        Missing(row.errors),
        row.note}) {
    if (!part.empty()) text += (text.empty() ? "" : "; ") + part;
  }
  std::replace(text.begin(), text.end(), '|', '/');
  return text;
}

std::string Line(const TradeoffRow& row) {
  const char* mark = row.pareto ? "**" : "";
  return fmt::format("| {} | {}{}{} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
                     NameOf(row.stage),
                     mark,
                     row.choice,
                     mark,
                     row.threads,
                     Seconds(row.wall_s),
                     Seconds(row.cpu_s),
                     Ratio(row),
                     FigureAs(row.peak_mib, "{:.1f}"),
                     FigureAs(row.errors.position_error_1, "{:.1e}"),
                     FigureAs(row.errors.covariance_error_1, "{:.1e}"),
                     FigureAs(row.errors.nees_1),
                     Remark(row));
}

}  // namespace

std::vector<std::size_t> SizesOf(const std::vector<TradeoffRow>& rows) {
  std::set<std::size_t> sizes;
  for (const TradeoffRow& row : rows) sizes.insert(row.points);
  return {sizes.begin(), sizes.end()};
}

std::string TradeoffPage(const std::vector<TradeoffRow>& rows, const TradeoffGoal& goal) {
  std::string page = "# Speed against accuracy: the rows\n\n";
  for (const std::size_t points : SizesOf(rows)) {
    page += "- " + Recommend(rows, points, goal) + ".\n";
  }
  for (const std::size_t points : SizesOf(rows)) {
    std::vector<TradeoffRow> of_size;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(of_size), [&](const auto& row) {
      return row.points == points;
    });
    std::stable_sort(of_size.begin(), of_size.end(), [](const auto& a, const auto& b) {
      return a.stage < b.stage;
    });
    std::size_t corrections = 0, looks = 0;
    for (const TradeoffRow& row : of_size) {
      if (row.reference) corrections = row.corrections;
      looks = std::max(looks, row.looks);
    }
    page += fmt::format(
        "\n## {} points\n\n{} looks, {} corrections in the reference.\n\n"
        "| stage | choice | threads | wall | CPU | speed by {} time, reference = 1 | MiB | "
        "position, sigmas | covariance | NEES | |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        points,
        looks,
        corrections,
        of_size.front().clock == TradeoffClock::kWall ? "wall" : "CPU");
    for (const TradeoffRow& row : of_size) page += Line(row);
  }
  return page;
}

}  // namespace sarblock
