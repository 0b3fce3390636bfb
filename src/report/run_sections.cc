// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

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

std::string Setting(const ResultSummary& summary, const std::string& key) {
  for (const auto& [name, value] : summary.configuration) {
    if (name != key) continue;
    const bool quoted = value.size() >= 2 && value.front() == '"';
    return quoted ? value.substr(1, value.size() - 2) : value;
  }
  return "";
}

PageTable CountTable(const ResultSummary& summary) {
  PageTable table;
  table.plain = true;
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

PageTable SettingTable(const ResultSummary& summary) {
  PageTable table;
  table.plain = true;
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
  section.items.emplace_back(CountTable(result.file.summary));
  section.items.emplace_back(SettingTable(result.file.summary));
  if (!result.unsolved.empty()) {
    constexpr std::size_t kMostUnsolved = 50;
    const ResultPoints& points = result.file.points;
    PageTable table;
    table.title = "Points that were left out";
    table.columns = {{"point", false}, {"status", false}, {"why", false}};
    const std::size_t shown = std::min(result.unsolved.size(), kMostUnsolved);
    for (const std::uint32_t point : std::span(result.unsolved).first(shown)) {
      table.rows.push_back({std::string(points.ids[point]),
                            NameOf(points.results.status[point]),
                            points.results.reason.empty() ? "" : points.results.reason[point]});
    }
    if (result.unsolved.size() > shown) {
      table.note = fmt::format(
          "The first {} of {}; all stand in points.csv.", shown, result.unsolved.size());
    }
    section.items.emplace_back(std::move(table));
  }
  if (!result.file.summary.warnings.empty()) {
    section.items.emplace_back(PageText{"Warnings of the run:", ""});
    section.items.emplace_back(PageList{result.file.summary.warnings});
  }
  return section;
}

PageSection CostSection(const ResultFolder& result) {
  PageSection section{"cost", "Time and memory", {}};
  if (result.file.summary.stages.empty()) {
    section.items.emplace_back(PageText{"The result does not say what its stages cost.", "note"});
    return section;
  }
  PageTable table;
  table.plain = true;  // the last row is the sum
  table.columns = {{"stage", false}, {"wall time [s]", true}, {"peak memory [MiB]", true}};
  double total_s = 0.0, peak_mib = 0.0;
  for (const StageCost& stage : result.file.summary.stages) {
    table.rows.push_back({stage.stage, Shown(stage.wall_s, 3), Shown(stage.peak_mib, 3)});
    total_s += stage.wall_s;
    peak_mib = std::max(peak_mib, stage.peak_mib);
  }
  table.rows.push_back({"all", Shown(total_s, 3), Shown(peak_mib, 3)});
  const std::string threads = Setting(result.file.summary, "threads");
  if (!threads.empty()) table.note = "Threads: " + threads + ".";
  section.items.emplace_back(std::move(table));
  return section;
}

PageSection OriginSection(const ResultFolder& result) {
  PageSection section{"origin", "Version, inputs and configuration", {}};
  const ResultSummary& summary = result.file.summary;
  section.items.emplace_back(
      PageText{fmt::format("Result of sarblock {} {}, report by sarblock {}.",
                           summary.version,
                           summary.command,
                           Version()),
               ""});
  if (summary.repetition) {
    section.items.emplace_back(PageText{
        fmt::format("Seed of the repeated adjustments: {}.", summary.repetition->seed), ""});
  }
  if (summary.inputs.empty()) {
    section.items.emplace_back(
        PageText{"The result does not name its input files with checksums.", "note"});
  } else {
    PageTable table;
    table.title = "Input files";
    table.columns = {{"file", false}, {"bytes", true}, {"SHA-256", false}};
    for (const InputFile& input : summary.inputs) {
      table.rows.push_back({input.name, ReadableCount(input.bytes), input.sha256});
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
