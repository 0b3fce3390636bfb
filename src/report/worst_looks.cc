// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "html.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

double ResidualOf_m(const ResultLooks& looks, std::size_t look, std::size_t component) {
  return component == 0 ? looks.range_residual_m[look] : looks.azimuth_residual_m[look];
}

/// The largest |w| by point: the looks of one point share a blunder, so they are one row.
PageTable WorstTable(const ResultFolder& result, double critical) {
  PageTable table;
  table.title = "Worst looks by point";
  table.columns = {{"point", false},
                   {"largest w", true},
                   {"of", false},
                   {"residual [m]", true},
                   {"redundancy", true},
                   {"minimal detectable blunder [m]", true},
                   {"its influence on the point [m]", true},
                   {"further w of the point", false}};
  const ResultFile& file = result.file;
  const ResultLooks& looks = file.looks;
  std::vector<std::vector<ReportLook>> by_point;
  std::unordered_map<std::uint32_t, std::size_t> row_of;
  for (const ReportLook& look : result.looks.worst) {
    const auto [found, added] = row_of.emplace(looks.point[look.look], by_point.size());
    if (added) by_point.emplace_back();
    by_point[found->second].push_back(look);
  }
  constexpr std::size_t kMostRows = 100, kMostFurther = 4;
  const auto name = [&](const ReportLook& look) {
    return file.passes[looks.pass[look.look]].id + " " + kLookComponents[look.component];
  };
  const auto w_of = [&](const ReportLook& look) {
    return static_cast<double>(looks.w_1[look.component][look.look]);
  };
  for (std::size_t p = 0; p < std::min(by_point.size(), kMostRows); ++p) {
    const ReportLook& first = by_point[p].front();
    const auto figure = [&](const std::array<std::vector<float>, 2>& of_looks) {
      const std::vector<float>& values = of_looks[first.component];
      return Shown(values.empty() ? kAbsent : static_cast<double>(values[first.look]), 3);
    };
    std::string further;
    for (std::size_t i = 1; i < by_point[p].size(); ++i) {
      if (i > kMostFurther) {
        further += fmt::format(" and {} more", by_point[p].size() - i);
        break;
      }
      further += fmt::format(
          "{}{} {}", i == 1 ? "" : ", ", name(by_point[p][i]), Shown(w_of(by_point[p][i]), 3));
    }
    if (std::abs(w_of(first)) > critical) table.marked.push_back(p);
    table.rows.push_back({std::string(file.points.ids[looks.point[first.look]]),
                          Shown(w_of(first), 3),
                          name(first),
                          Shown(ResidualOf_m(looks, first.look, first.component), 3),
                          figure(looks.redundancy_1),
                          figure(looks.mdb_m),
                          figure(looks.influence_m),
                          further});
  }
  table.note = fmt::format(
      "The {} largest |w| whose redundancy is {} at least, by point; beyond the critical value "
      "they "
      "are marked. The minimal detectable blunder is found with a power of {}; smaller ones may "
      "stay, and move the point by up to the influence.",
      result.looks.worst.size(),
      ReportLooks::kLeastTested_1,
      ShownPercent(file.summary.tests ? file.summary.tests->power_1 : kAbsent));
  return table;
}

PageTable FindingTable(const ResultSummary& summary) {
  constexpr std::size_t kRows = 300;
  PageTable table;
  table.title = "What the search for blunders found";
  table.columns = {{"round", true},
                   {"point", false},
                   {"passes", false},
                   {"component", false},
                   {"w", true},
                   {"located", false},
                   {"done", false},
                   {"note", false}};
  for (std::size_t i = 0; i < std::min(kRows, summary.findings.size()); ++i) {
    const ResultFinding& f = summary.findings[i];
    table.rows.push_back({std::to_string(f.round),
                          f.point,
                          f.passes,
                          f.component,
                          Shown(f.w_1, 3),
                          f.located ? "yes" : "no",
                          f.action,
                          f.note});
  }
  table.note =
      fmt::format("{} findings in {} rounds{}.",
                  summary.findings.size(),
                  *summary.snooping_rounds,
                  summary.findings.size() > kRows ? "; the others stand in summary.json" : "");
  return table;
}

}  // namespace

PageSection WorstLooksSection(const ResultFolder& result) {
  PageSection section{"worst", "Worst looks", {}};
  const ReportLooks& looks = result.looks;
  const auto& tests = result.file.summary.tests;
  if (looks.worst.empty()) {
    section.items.emplace_back(PageText{"No look was tested.", "note"});
  } else {
    if (tests) {
      section.items.emplace_back(PageText{
          fmt::format("{} observations were tested one by one at level {}: |w| above {} is rare. "
                      "{} range, {} azimuth and {} control components are above it, {} "
                      "are expected by chance. {} looks belong to points with one degree of "
                      "freedom, where a blunder shows but cannot be located.",
                      ReadableCount(tests->tests),
                      Shown(tests->alpha_1, 2),
                      Shown(tests->critical_w_1, 3),
                      tests->above[0],
                      tests->above[1],
                      tests->above[2],
                      Shown(tests->expected_above_1, 2),
                      ReadableCount(tests->not_localisable)),
          ""});
    }
    section.items.emplace_back(WorstTable(result, tests ? tests->critical_w_1 : kAbsent));
  }
  if (result.file.summary.snooping_rounds && !result.file.summary.findings.empty()) {
    section.items.emplace_back(FindingTable(result.file.summary));
  }
  if (!looks.left_out.empty()) {
    PageTable table;
    table.title = "Looks that were left out";
    table.columns = {
        {"pass", false}, {"point", false}, {"reason", false}, {"largest residual [m]", true}};
    const ResultLooks& all = result.file.looks;
    for (const auto& [look, k] : looks.left_out) {
      table.rows.push_back({result.file.passes[all.pass[look]].id,
                            std::string(result.file.points.ids[all.point[look]]),
                            NameOf(all.reason[look]),
                            Shown(ResidualOf_m(all, look, k), 3) + " " + kLookComponents[k]});
    }
    table.note = fmt::format(
        "{} of {}, the largest residuals first. A list to use again: --rejections with "
        "residuals.csv.",
        looks.left_out.size(),
        ReadableCount(looks.rejected));
    section.items.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace sarblock
