// SPDX-License-Identifier: Apache-2.0
#include "result_page.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "page.h"
#include "shown_result.h"
#include "study_page.h"
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
    {"observations", "Observations (two per look, control components, priors)"},
    {"parameters", "Unknowns (three a point, corrections)"},
    {"datum_defects", "Datum defects fixed by the inner datum"},
    {"redundancy", "Redundancy"},
};

std::string Setting(const files::ResultSummary& summary, const std::string& key) {
  for (const auto& [name, value] : summary.configuration) {
    if (name != key) continue;
    const bool quoted = value.size() >= 2 && value.front() == '"';
    return quoted ? value.substr(1, value.size() - 2) : value;
  }
  return "";
}

PageTable CountTable(const files::ResultSummary& summary) {
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

PageTable SettingTable(const files::ResultSummary& summary) {
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
  table.note = "The whole configuration is at the end of this report.";
  return table;
}

}  // namespace

PageSection CountsSection(const ResultFolder& result) {
  PageSection section{"counts", "Counts and settings", {}};
  section.items.emplace_back(CountTable(result.file.summary));
  section.items.emplace_back(SettingTable(result.file.summary));
  if (!result.unsolved.empty()) {
    constexpr std::size_t kMaxUnsolved = 50;
    const files::ResultPoints& points = result.file.points;
    PageTable table;
    table.title = "Points that were left out";
    table.columns = {{"point", false}, {"status", false}, {"why", false}};
    const std::size_t shown = std::min(result.unsolved.size(), kMaxUnsolved);
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
  const files::ResultSummary& summary = result.file.summary;
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
    for (const files::InputFile& input : summary.inputs) {
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

namespace {

const char* KindOf(const files::ResultSummary& summary) {
  if (summary.command == "intersect") return "Intersection";
  if (summary.command == "predict") return "Prediction";
  return "Block adjustment";
}

std::vector<PageFact> HeadlineFacts(const ResultFolder& result,
                                    const AccuracyFigures& accuracy,
                                    const Headline& headline) {
  std::vector<PageFact> out;
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
  if (accuracy.points > 0) {
    const auto weak = static_cast<std::size_t>(accuracy.weakest);
    out.push_back(
        {"Median sigma " + std::string(axes[0]) + ", " + axes[1] + ", " + axes[2],
         fmt::format("{}, {}, {} m",
                     Shown(accuracy.median_m[0], 3),
                     Shown(accuracy.median_m[1], 3),
                     Shown(accuracy.median_m[2], 3)),
         fmt::format("of {} points", ReadableCount(static_cast<double>(accuracy.points)))});
    out.push_back({"Weakest point",
                   fmt::format("{} m {}", Shown(accuracy.largest_m[weak], 3), axes[weak]),
                   "at " + accuracy.largest_point[weak]});
    if (!headline.would_help.empty()) {
      out.push_back({"Would help most",
                     headline.would_help,
                     std::string("for ") + axes[weak] + ", the weakest component"});
    }
  }
  if (const auto& test = result.file.summary.chi_square) {
    out.push_back({"Variance factor",
                   Shown(test->sigma0_squared),
                   fmt::format("{}: {} to {} allowed",
                               test->passed ? "passed" : "failed",
                               Shown(test->chi_square.lower / test->redundancy, 3),
                               Shown(test->chi_square.upper / test->redundancy, 3))});
  }
  if (const auto& checks = result.file.summary.checks; checks && checks->components > 0) {
    out.push_back({"Check points, error over sigma",
                   Shown(checks->error_ratio, 3),
                   fmt::format("{} point{}, {}",
                               checks->points,
                               checks->points == 1 ? "" : "s",
                               checks->realistic ? "realistic" : "not realistic")});
  }
  out.push_back(
      {"Observations, unknowns",
       fmt::format("{}, {}",
                   ReadableCount(result.file.summary.Count("observations")),
                   ReadableCount(result.file.summary.Count("parameters"))),
       fmt::format("redundancy {}", ReadableCount(result.file.summary.Count("redundancy")))});
  return out;
}

}  // namespace

Page MakeResultPage(const ResultFolder& result) {
  const AccuracyFigures accuracy = DescribeAccuracy(result);
  const Frame& frame = result.file.frame;
  Page page;
  page.title = result.file.summary.block.empty() ? "Result" : result.file.summary.block;
  page.kind = KindOf(result.file.summary);
  page.subtitle = fmt::format("{} passes, {} points, {} looks; {}",
                              ReadableCount(result.file.summary.Count("passes")),
                              ReadableCount(result.file.summary.Count("points")),
                              ReadableCount(result.file.summary.Count("looks")),
                              frame.kind() == FrameKind::kGeocentric
                                  ? "geocentric frame, " + frame.ellipsoid().name
                                  : "local frame");
  page.headline = HeadlineOf(result, accuracy);
  page.facts = HeadlineFacts(result, accuracy, page.headline);
  page.sections = {MapSection(result, accuracy),
                   KnownPointsSection(result),
                   TestSection(result),
                   ResidualSection(result),
                   WorstLooksSection(result),
                   ProfileSection(result),
                   CorrectionSection(result),
                   ModelSection(result),
                   CountsSection(result),
                   CostSection(result),
                   OriginSection(result)};
  return page;
}

namespace {

namespace fs = std::filesystem;

ReportFile WritePage(const Page& page,
                     std::string kind,
                     const fs::path& file,
                     ProgressSink* progress) {
  Step(progress, "write", 0, 0, file.filename().string());
  const std::string html = RenderPage(page);
  if (file.has_parent_path()) MakeFolder(file.parent_path());
  AtomicFile out(file);
  out.Write(html);
  out.Commit();
  return {file, std::move(kind), page.headline.word, html.size()};
}

void RequireResultOrStudy(const fs::path& path) {
  const auto fail = [&](const std::string& what) {
    throw InputError(
        FilePlace{path.string(), 0, ""},
        what +
            "; a result or a study is a folder with summary.json (a result) or with "
            "densification.csv, design.csv, tradeoff.csv or stability.csv (a study), or an HDF5 "
            "file of a result");
  };
  if (!fs::exists(path)) fail("does not exist");
  if (!fs::is_directory(path) && !IsContainer(path)) fail("is a file that is no HDF5 file");
  if (fs::exists(path / "block.toml") && !fs::exists(path / "summary.json")) {
    fail("is a block, not a result or a study");
  }
}

}  // namespace

ReportFile WriteReport(const fs::path& folder, const fs::path& out, ProgressSink* progress) {
  const fs::path file = out.empty() ? FileOf(folder, "report.html") : out;
  RequireResultOrStudy(folder);
  if (!fs::is_directory(folder) || fs::exists(folder / "summary.json")) {
    return WritePage(MakeResultPage(ReadResultFolder(folder, progress)), "result", file, progress);
  }
  const StudyFolder study = ReadStudyFolder(folder);
  if (study.tables.empty()) {
    throw InputError(FilePlace{folder.string(), 0, ""},
                     "has no summary.json (a result) and no densification.csv, design.csv, "
                     "tradeoff.csv or stability.csv (a study)");
  }
  return WritePage(MakeStudyPage(study), study.tables.front().kind, file, progress);
}

ReportFile WriteComparison(const fs::path& a,
                           const fs::path& b,
                           const fs::path& out,
                           ProgressSink* progress) {
  const fs::path file = out.empty() ? FileOf(b, "comparison.html") : out;
  const ResultFolder first = ReadResultFolder(a, progress);
  const ResultFolder second = ReadResultFolder(b, progress);
  return WritePage(MakeComparisonPage(first, second), "comparison", file, progress);
}

}  // namespace sarblock
