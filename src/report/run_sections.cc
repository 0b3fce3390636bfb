// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/version.h"

#include <algorithm>
#include <cmath>

#include "html.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

struct NamedCount {
  const char* key;
  const char* label;
};
constexpr NamedCount kCounts[] = {
    {"passes", "Passes"},
    {"points", "Points"},
    {"tie_points", "Tie points"},
    {"control_points", "Control points"},
    {"check_points", "Check points"},
    {"looks", "Looks in the block"},
    {"looks_used", "Looks used"},
    {"looks_not_evaluated", "Looks without a model value"},
    {"observations", "Observations (two a look, control components, priors)"},
    {"parameters", "Unknowns (three a point, corrections)"},
    {"datum_defects", "Datum defects fixed by the inner datum"},
    {"redundancy", "Redundancy"},
};

std::string Setting(const ReportSummary& summary, const std::string& key) {
  for (const auto& [name, value] : summary.configuration) {
    if (name != key) continue;
    const bool quoted = value.size() >= 2 && value.front() == '"';
    return quoted ? value.substr(1, value.size() - 2) : value;
  }
  return "";
}

PageTable CountTable(const ReportSummary& summary) {
  PageTable table;
  table.columns = {{"", false}, {"count", true}};
  for (const NamedCount& count : kCounts) {
    const bool there = std::any_of(summary.counts.begin(),
                                   summary.counts.end(),
                                   [&](const auto& c) { return c.first == count.key; });
    const double value = summary.Count(count.key);
    const std::string_view key = count.key;
    const bool always = key != "datum_defects" && key != "looks_not_evaluated";
    if (there && (always || value != 0.0)) {
      table.rows.push_back({count.label, ReadableCount(value)});
    }
  }
  return table;
}

PageTable SettingTable(const ReportSummary& summary) {
  PageTable table;
  table.columns = {{"setting", false}, {"value", false}};
  for (const char* key : {"corrections",
                          "robust",
                          "covariance",
                          "datum",
                          "variance_components",
                          "scale_by_posterior",
                          "quality.snooping",
                          "pairs"}) {
    const std::string value = Setting(summary, key);
    if (!value.empty()) table.rows.push_back({key, value});
  }
  table.note = "The whole configuration stands at the end of this report.";
  return table;
}

}  // namespace

PageSection CountsSection(const ResultFolder& result) {
  PageSection section{"counts", "Counts and settings", {}};
  section.items.emplace_back(CountTable(result.summary));
  section.items.emplace_back(SettingTable(result.summary));
  if (result.points.unsolved_count > 0) {
    PageTable table;
    table.title = "Points that were left out";
    table.columns = {{"point", false}, {"status", false}, {"why", false}};
    for (const ReportPoints::Unsolved& point : result.points.unsolved) {
      table.rows.push_back(
          {std::string(result.points.ids[point.point]), point.status, point.reason});
    }
    if (result.points.unsolved_count > result.points.unsolved.size()) {
      table.note = fmt::format("The first {} of {}; all stand in points.csv.",
                               result.points.unsolved.size(),
                               result.points.unsolved_count);
    }
    section.items.emplace_back(std::move(table));
  }
  if (!result.summary.warnings.empty()) {
    section.items.emplace_back(PageText{"Warnings of the run:", ""});
    section.items.emplace_back(PageList{result.summary.warnings});
  }
  return section;
}

PageSection CostSection(const ResultFolder& result) {
  PageSection section{"cost", "Time and memory", {}};
  if (result.summary.stages.empty()) {
    section.items.emplace_back(PageText{"The result does not say what its stages cost.", "note"});
    return section;
  }
  PageTable table;
  table.columns = {{"stage", false}, {"wall time [s]", true}, {"peak memory [MiB]", true}};
  double total_s = 0.0, peak_mib = 0.0;
  for (const StageFigures& stage : result.summary.stages) {
    table.rows.push_back({stage.name, Shown(stage.wall_s, 3), Shown(stage.peak_mib, 3)});
    total_s += stage.wall_s;
    peak_mib = std::max(peak_mib, stage.peak_mib);
  }
  table.rows.push_back({"all", Shown(total_s, 3), Shown(peak_mib, 3)});
  const std::string threads = Setting(result.summary, "threads");
  if (!threads.empty()) table.note = "Threads: " + threads + ".";
  section.items.emplace_back(std::move(table));
  return section;
}

PageSection OriginSection(const ResultFolder& result) {
  PageSection section{"origin", "Version, inputs and configuration", {}};
  const ReportSummary& summary = result.summary;
  section.items.emplace_back(
      PageText{fmt::format("Result of sarblock {} {}, report by sarblock {}.",
                           summary.version,
                           summary.command,
                           Version()),
               ""});
  if (summary.montecarlo) {
    section.items.emplace_back(
        PageText{"Seed of the repeated adjustments: " + summary.montecarlo->seed + ".", ""});
  }
  if (summary.inputs.empty()) {
    section.items.emplace_back(
        PageText{"The result does not name its input files with checksums.", "note"});
  } else {
    PageTable table;
    table.title = "Input files";
    table.columns = {{"file", false}, {"bytes", true}, {"SHA-256", false}};
    for (const InputFigures& input : summary.inputs) {
      table.rows.push_back({input.file, ReadableCount(input.bytes_1), input.sha256});
    }
    table.note = "sha256sum of the same files gives the same digits.";
    section.items.emplace_back(std::move(table));
  }
  std::string text;
  for (const auto& [key, value] : summary.configuration) text += key + " = " + value + "\n";
  if (!text.empty()) section.items.emplace_back(PagePre{"Configuration of the run", text});
  return section;
}

}  // namespace sarblock
