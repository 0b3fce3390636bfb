// SPDX-License-Identifier: Apache-2.0
#include "study_page.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <sstream>

#include "page.h"
#include "shown_result.h"
#include "studies/densification.h"
#include "studies/design.h"
#include "studies/stability.h"
#include "studies/tradeoff.h"
#include "tables/csv.h"
#include "tables/open.h"
#include "tables/toml.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMaxShownRows = 800;      // of a table in the page
constexpr std::size_t kMaxSentenceBytes = 240;  // longer answers are in their list only
constexpr std::size_t kMaxSentences = 3;

/// Messages may be long; the table of the study has them whole.
std::string Shortened(const std::string& text) {
  constexpr std::size_t kMaxBytes = 160;
  if (text.size() <= kMaxBytes) return text;
  return text.substr(0, text.rfind(' ', kMaxBytes)) + " ...";
}

std::string Sentence(const std::string& line) {
  std::string sentence = Capital(line);
  if (!sentence.ends_with('.')) sentence += '.';
  return sentence;
}

}  // namespace

std::string ColumnPhrase(const std::string& column) {
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

PageTable WholeTable(const StudyCsv& table) {
  PageTable out;
  out.title = "All rows";
  for (const StudyColumn& column : table.columns) {
    out.columns.push_back({ColumnPhrase(column.name), column.kind != StudyCellKind::kText});
  }
  for (std::size_t r = 0; r < std::min(table.rows.size(), kMaxShownRows); ++r) {
    std::vector<std::string> row;
    for (const StudyColumn& column : table.columns) {
      const std::string text = table.Text(r, column.name);
      const double value = table.Number(r, column.name);
      const bool whole = text.find_first_not_of("0123456789") == std::string::npos;
      const bool is_text = column.kind == StudyCellKind::kText || std::isnan(value);
      row.push_back(is_text ? Shortened(text) : whole ? ReadableCount(value) : Shown(value));
    }
    out.rows.push_back(std::move(row));
  }
  if (table.rows.size() > kMaxShownRows) {
    out.note =
        fmt::format("The first {} of {} rows.", kMaxShownRows, ReadableCount(table.rows.size()));
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
                     : table.kind == "design"      ? DesignPart(table)
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
    if (page.headline.sentences.size() < kMaxSentences && line.size() <= kMaxSentenceBytes) {
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
      section.items.emplace_back(PagePicture{Capital(ColumnPhrase(picture.name)), picture.svg});
    }
    page.sections.push_back(std::move(section));
  }
  return page;
}

namespace {

constexpr std::size_t kMaxPictureBytes = 1000000;
constexpr std::size_t kMaxStudyRows = 20000;

struct StudyKind {
  std::string name;
  const std::vector<StudyColumn>& columns;
};

/// In the order of the page.
std::array<StudyKind, 4> Kinds() {
  return {{{"densification", DensificationColumns()},
           {"design", DesignColumns()},
           {"tradeoff", TradeoffColumns()},
           {"stability", StabilityColumns()}}};
}

std::vector<StudyPicture> ReadPictures(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& place : {folder, folder / "plots"}) {
    if (!std::filesystem::is_directory(place)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(place)) {
      if (entry.is_regular_file() && entry.path().extension() == ".svg") {
        files.push_back(entry.path());
      }
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<StudyPicture> out;
  std::size_t bytes = 0;
  for (const std::filesystem::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    std::string svg{std::istreambuf_iterator<char>(stream), {}};
    if (bytes + svg.size() > kMaxPictureBytes) continue;
    bytes += svg.size();
    out.push_back({file.stem().string(), std::move(svg)});
  }
  return out;
}

/// Name and goal of the study file, which a study leaves beside its table.
void ReadHeading(const std::filesystem::path& file, StudyFolder* out) {
  if (!std::filesystem::exists(file)) return;
  const toml::table root = ParseToml(ReadTomlText(file, "a study"), file.string(), {});
  out->name = root["name"].value_or(std::string());
  out->purpose = root["purpose"].value_or(std::string());
}

std::vector<std::string> ReadLines(const std::filesystem::path& file) {
  std::vector<std::string> out;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) out.push_back(line);
  }
  return out;
}

}  // namespace

bool StudyCsv::HasNumbers(const std::string& column) const {
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!std::isnan(Number(row, column))) return true;
  }
  return false;
}

std::size_t StudyCsv::Column(const std::string& name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const StudyColumn& column) {
    return column.name == name;
  });
  return static_cast<std::size_t>(found - columns.begin());
}

std::string StudyCsv::Text(std::size_t row, const std::string& column) const {
  const std::size_t at = Column(column);
  return at == columns.size() ? "" : rows[row][at];
}

double StudyCsv::Number(std::size_t row, const std::string& column) const {
  const std::string text = Text(row, column);
  double value = kAbsent;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : kAbsent;
}

bool StudyCsv::Determined(std::size_t row) const { return Text(row, "determined") != "0"; }

std::vector<std::string> StudyCsv::Values(const std::string& column) const {
  std::vector<std::string> out;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    std::string text = Text(row, column);
    if (std::find(out.begin(), out.end(), text) == out.end()) out.push_back(std::move(text));
  }
  return out;
}

StudyFolder ReadStudyFolder(const std::filesystem::path& folder) {
  StudyFolder out;
  out.path = folder.string();
  for (const StudyKind& kind : Kinds()) {
    const auto file = FindTable(folder, kind.name);
    if (!file) continue;
    StudyCsv table;
    table.kind = kind.name;
    std::vector<TableColumn> schema;
    std::vector<const StudyColumn*> shown;
    for (const StudyColumn& column : kind.columns) {
      if (column.report == InReport::kNo) continue;
      const bool needed = column.report == InReport::kNeeded;
      schema.push_back(
          {column.name, needed ? ColumnNeed::kRequired : ColumnNeed::kOptional, CellKind::kText});
      shown.push_back(&column);
    }
    const auto reader = ReadCsv(*file, schema);
    std::vector<std::size_t> there;
    for (std::size_t c = 0; c < schema.size(); ++c) {
      if (!reader->Has(c)) continue;
      there.push_back(c);
      table.columns.push_back(*shown[c]);
    }
    ForRows(reader.get(), [&](const Row& row) {
      if (table.rows.size() == kMaxStudyRows) return;
      std::vector<std::string>& cells = table.rows.emplace_back();
      for (const std::size_t c : there) cells.emplace_back(row.Text(c));
    });
    out.tables.push_back(std::move(table));
    ReadHeading(folder / (kind.name + ".study.toml"), &out);
    for (std::string& line : ReadLines(folder / (kind.name + ".txt"))) {
      out.answers.push_back(std::move(line));
    }
  }
  if (!out.tables.empty()) out.pictures = ReadPictures(folder);
  return out;
}

namespace {

constexpr const char* kLayoutColors[] = {"blue", "orange", "green", "purple"};
constexpr std::size_t kMaxLayouts = 4;  // of a panel; drawn runs or single layouts are the fifth

/// What a panel shows: a column, and where runs with drawn noise measured the same, theirs.
struct Measure {
  const char* id;
  const char* predicted;
  const char* measured;
  const char* title;
};
/// Heights by their root mean square, which the runs measure, or by their median.
std::vector<Measure> MeasuresOf(const StudyCsv& table) {
  std::vector<Measure> measures{{"max-u", "max_sigma_u_m", "", "Height, the worst point"},
                                {"max-h", "max_sigma_h_m", "", "Plan, the worst point"}};
  measures.insert(measures.begin(),
                  table.HasNumbers("rms_sigma_u_m")
                      ? Measure{"u", "rms_sigma_u_m", "montecarlo_rms_u_m", "Height, all points"}
                      : Measure{"u", "median_sigma_u_m", "", "Height, median of the points"});
  std::erase_if(measures, [&](const Measure& m) { return !table.HasNumbers(m.predicted); });
  return measures;
}

/// Rows of one variant by layout. A block without control starts the line of every layout.
struct LayoutRows {
  std::string layout;
  std::vector<std::size_t> rows;
};

std::vector<LayoutRows> LayoutsOf(const StudyCsv& table, const std::string& variant) {
  std::vector<LayoutRows> out;
  std::vector<std::size_t> without;
  for (const std::string& layout : table.Values("layout")) {
    LayoutRows one{layout, {}};
    for (const std::size_t r : RowsOf(table, "layout", layout, "control_points")) {
      if (table.Determined(r) && table.Text(r, "variant") == variant) one.rows.push_back(r);
    }
    if (layout == "none") without = one.rows;
    if (!one.rows.empty() && layout != "none") out.push_back(std::move(one));
  }
  for (LayoutRows& layout : out) {
    if (layout.rows.size() > 1 && table.Number(layout.rows.front(), "control_points") > 0.0) {
      layout.rows.insert(layout.rows.begin(), without.begin(), without.end());
    }
  }
  if (out.empty() && !without.empty()) out.push_back({"none", without});
  return out;
}

/// Panels of one measure of one variant, five series each at most.
void AddPanels(const StudyCsv& table,
               const std::vector<LayoutRows>& layouts,
               const Measure& measure,
               const std::string& id,
               PageFigures* figures) {
  std::vector<ChartSeries> lines, runs;
  ChartSeries single{"single layouts", "points", "ink", {}, {}, {}, {}, {}};
  single.written = true;
  for (const LayoutRows& layout : layouts) {
    const char* color = kLayoutColors[lines.size() % std::size(kLayoutColors)];
    ChartSeries line{layout.layout, "marks", color, {}, {}, {}, {}, {}};
    ChartSeries dots{"runs with drawn noise", "points", "ink", {}, {}, {}, {}, {}};
    for (const std::size_t r : layout.rows) {
      const double x = table.Number(r, "control_points");
      line.x.push_back(x);
      line.y.push_back(table.Number(r, measure.predicted));
      line.names.push_back(r == layout.rows.back() ? layout.layout : "");
      const double measured = table.Number(r, measure.measured);
      if (std::isnan(measured)) continue;
      dots.x.push_back(x);
      dots.y.push_back(measured);
      dots.names.push_back(layout.layout);
    }
    if (layout.rows.size() == 1) {
      single.x.push_back(line.x.front());
      single.y.push_back(line.y.front());
      single.names.push_back(layout.layout);
      continue;
    }
    line.written = true;
    lines.push_back(std::move(line));
    runs.push_back(std::move(dots));
  }
  for (std::size_t first = 0; first < lines.size() || !single.x.empty(); first += kMaxLayouts) {
    XyChart chart;
    chart.x.label = "control points";
    chart.y = {"sigma [m]", true, kAbsent, kAbsent};
    ChartSeries dots{"runs with drawn noise", "points", "ink", {}, {}, {}, {}, {}};
    const std::size_t end = std::min(lines.size(), first + kMaxLayouts);
    for (std::size_t i = first; i < end; ++i) {
      chart.series.push_back(lines[i]);
      dots.x.insert(dots.x.end(), runs[i].x.begin(), runs[i].x.end());
      dots.y.insert(dots.y.end(), runs[i].y.begin(), runs[i].y.end());
      dots.names.insert(dots.names.end(), runs[i].names.begin(), runs[i].names.end());
    }
    const bool dotted = !dots.x.empty();
    if (dotted) chart.series.push_back(std::move(dots));
    if (end == lines.size() && !single.x.empty() && chart.series.size() <= kMaxLayouts) {
      chart.series.push_back(std::move(single));
      single.x.clear();
    }
    FitY(&chart);
    const std::string panel = first == 0 ? id : fmt::format("{}-{}", id, first / kMaxLayouts + 1);
    figures->figures.push_back(
        {panel,
         std::string(measure.title) + (first == 0 ? "" : ", further layouts"),
         "",
         "half",
         ChartJson(panel, chart)});
  }
}

/// The least and the most control of the layout whose worst height is best: how weak the block is,
/// and what control does about it.
std::vector<PageFact> FactsOf(const StudyCsv& table) {
  constexpr const char* kWorst = "max_sigma_u_m";
  std::size_t best = table.rows.size();
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!table.Determined(r) || std::isnan(table.Number(r, kWorst))) continue;
    if (best == table.rows.size() || table.Number(r, kWorst) < table.Number(best, kWorst)) best = r;
  }
  if (best == table.rows.size()) return {};
  const std::string layout = table.Text(best, "layout");
  const double least_m = table.Number(best, kWorst);
  std::vector<PageFact> facts{
      {"Worst height at best",
       Shown(least_m, 3) + " m",
       fmt::format("{}, {} control points", layout, table.Text(best, "control_points"))}};
  for (const std::size_t first : RowsOf(table, "layout", layout, "control_points")) {
    const double most_m = table.Number(first, kWorst);
    const bool same = table.Text(first, "variant") == table.Text(best, "variant");
    if (!same || !table.Determined(first) || !(most_m > least_m)) continue;
    const double gain = 1.0 - least_m / most_m;
    constexpr double kHardly = 0.1;
    facts.push_back({"More control",
                     gain < kHardly ? "hardly helps" : "helps",
                     fmt::format("from {} to {} points the worst height improves by {} %",
                                 table.Text(first, "control_points"),
                                 table.Text(best, "control_points"),
                                 Shown(100.0 * gain, 2))});
    break;
  }
  return facts;
}

}  // namespace

StudyPart DensificationPart(const StudyCsv& table) {
  StudyPart out;
  out.section = {"densification", "Control against accuracy", {}};
  out.word = "Control against accuracy";
  out.facts = FactsOf(table);
  std::size_t best = table.rows.size();
  double least = kAbsent, worst_nees = 0.0;
  std::size_t open = 0, tested = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!table.Determined(r)) {
      ++open;
      continue;
    }
    const double sigma = table.Number(r, "median_sigma_u_m");
    if (sigma < least || std::isnan(least)) {
      least = sigma;
      best = r;
    }
    const double nees = table.Number(r, "nees");
    if (std::isnan(nees)) continue;
    ++tested;
    if (std::abs(nees - 1.0) > std::abs(worst_nees - 1.0) || worst_nees == 0.0) worst_nees = nees;
  }
  out.sentences.push_back(
      fmt::format("{} arrangements of control were compared.", table.rows.size()));
  if (best < table.rows.size()) {
    out.sentences.push_back(fmt::format(
        "The best height, a median sigma of {} m, has the layout {} with {} control points.",
        Shown(least, 3),
        table.Text(best, "layout"),
        table.Text(best, "control_points")));
  }
  if (tested > 0) {
    out.sentences.push_back(
        fmt::format("Where runs with drawn noise tested the prediction, the normalised error "
                    "squared was at worst {} (1 is expected).",
                    Shown(worst_nees, 3)));
  }
  if (open > 0) {
    out.attention.push_back(fmt::format("{} arrangements do not determine the block.", open));
  }
  std::size_t number = 0;
  for (const std::string& variant : table.Values("variant")) {
    const std::vector<LayoutRows> layouts = LayoutsOf(table, variant);
    ++number;
    if (layouts.empty()) continue;
    if (!variant.empty()) out.section.items.emplace_back(PageText{Capital(variant), "heading"});
    PageFigures figures;
    for (const Measure& measure : MeasuresOf(table)) {
      AddPanels(table,
                layouts,
                measure,
                number == 1 ? fmt::format("densification-{}", measure.id)
                            : fmt::format("densification-{}-variant-{}", measure.id, number),
                &figures);
    }
    out.section.items.emplace_back(std::move(figures));
  }
  out.section.items.emplace_back(
      PageText{"Lines: predicted by the covariance; of all points their root mean square. Black "
               "dots: root mean square errors of repeated adjustments with drawn noise.",
               "note"});
  out.section.items.emplace_back(WholeTable(table));
  return out;
}

namespace {

/// What a stage decides, in words.
std::string StageInWords(const std::string& stage) {
  if (stage == "model") return "Model of the block";
  if (stage == "solver") return "Solver";
  if (stage == "covariance") return "Covariance";
  return Capital(stage);
}

/// The error that a stage trades for speed: of covariances where the stage changes them.
std::string ErrorColumn(const StudyCsv& table, const std::vector<std::size_t>& rows) {
  for (const std::size_t r : rows) {
    if (table.Number(r, "covariance_error") > 0.0) return "covariance_error";
  }
  return "position_error_sigma";
}

/// One stage at one size of the block; every choice is named beside its point.
PageFigure TradeoffFigure(const StudyCsv& table,
                          const std::string& stage,
                          const std::string& points,
                          const std::vector<std::size_t>& rows,
                          std::size_t number) {
  const std::string column = ErrorColumn(table, rows);
  // The reference has no error: it is drawn a decade below the smallest.
  double least = kAbsent;
  for (const std::size_t r : rows) {
    const double error = table.Number(r, column);
    if (error > 0.0) least = std::fmin(least, error);
  }
  const double floor = std::isnan(least) ? 1e-16 : least / 10.0;
  XyChart chart;
  chart.x = {"wall time [s]", true, kAbsent, kAbsent};
  chart.y = {
      column == "covariance_error" ? "relative error of covariances" : "shift of points [sigma]",
      true,
      kAbsent,
      kAbsent};
  ChartSeries front{"nothing is faster and better", "points", "blue", {}, {}, {}, {}, {}};
  ChartSeries other{"others", "points", "grey", {}, {}, {}, {}, {}};
  front.written = other.written = true;
  for (const std::size_t r : rows) {
    if (std::isnan(table.Number(r, "wall_s"))) continue;  // was not run
    ChartSeries& series = table.Text(r, "pareto") == "1" ? front : other;
    const double error = table.Number(r, column);
    series.x.push_back(table.Number(r, "wall_s"));
    series.y.push_back(error > 0.0 ? error : floor);
    series.names.push_back(table.Text(r, "choice"));
  }
  for (ChartSeries* series : {&other, &front}) {
    if (!series->x.empty()) chart.series.push_back(std::move(*series));
  }
  FitY(&chart);
  const std::string id = fmt::format("tradeoff-{}", number);
  return {id,
          StageInWords(stage) +
              (points.empty() ? "" : ", " + ReadableCount(std::atof(points.c_str())) + " points"),
          std::isnan(least) ? "No choice of this stage has an error."
                            : "Choices without an error stand at the lower edge.",
          "half",
          ChartJson(id, chart)};
}

/// The ends of the bargain: what is fastest, and what it costs at most.
std::vector<PageFact> FactsOfChoices(const StudyCsv& table) {
  std::vector<PageFact> facts;
  const auto largest = [&table](const char* column) {
    std::size_t most = table.rows.size();
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const double value = table.Number(r, column);
      if (value > (most == table.rows.size() ? 0.0 : table.Number(most, column))) most = r;
    }
    return most;
  };
  const auto named = [&table](std::size_t r) {
    return table.Text(r, "choice") + ", " + ReadableCount(table.Number(r, "points")) + " points";
  };
  const std::size_t fastest = largest("speed_ratio"), weakest = largest("position_error_sigma");
  if (fastest < table.rows.size()) {
    facts.push_back({"Fastest",
                     Shown(table.Number(fastest, "speed_ratio"), 3) + " times the reference",
                     named(fastest)});
  }
  if (weakest < table.rows.size()) {
    facts.push_back({"Largest shift of a point",
                     Shown(table.Number(weakest, "position_error_sigma"), 2) + " sigma",
                     named(weakest)});
  }
  return facts;
}

}  // namespace

StudyPart TradeoffPart(const StudyCsv& table) {
  StudyPart out;
  out.section = {"tradeoff", "Speed against accuracy", {}};
  out.word = "Speed against accuracy";
  out.facts = FactsOfChoices(table);
  std::size_t run = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!std::isnan(table.Number(r, "wall_s"))) ++run;
  }
  out.sentences.push_back(fmt::format("{} choices in {} stages were run against their references.",
                                      run,
                                      table.Values("stage").size()));
  PageFigures figures;
  for (const std::string& stage : table.Values("stage")) {
    const std::vector<std::size_t> of_stage = RowsOf(table, "stage", stage, "wall_s");
    std::size_t fastest = table.rows.size();
    for (const std::size_t r : of_stage) {
      if (table.Text(r, "pareto") == "1" &&
          (fastest == table.rows.size() ||
           table.Number(r, "speed_ratio") > table.Number(fastest, "speed_ratio"))) {
        fastest = r;
      }
    }
    if (fastest < table.rows.size()) {
      out.sentences.push_back(
          fmt::format("{}: {} is {} times as fast as the reference, with points moved by {} sigma "
                      "and covariances by {}.",
                      Capital(stage),
                      table.Text(fastest, "choice"),
                      Shown(table.Number(fastest, "speed_ratio"), 3),
                      Shown(table.Number(fastest, "position_error_sigma"), 2),
                      Shown(table.Number(fastest, "covariance_error"), 2)));
    }
    for (const std::string& points : table.Values("points")) {
      std::vector<std::size_t> rows;
      for (const std::size_t r : of_stage) {
        if (table.Text(r, "points") == points && !std::isnan(table.Number(r, "wall_s"))) {
          rows.push_back(r);
        }
      }
      if (rows.empty()) continue;
      figures.figures.push_back(TradeoffFigure(table, stage, points, rows, figures.figures.size()));
    }
  }
  out.section.items.emplace_back(std::move(figures));
  PageTable whole = WholeTable(table);
  for (std::size_t r = 0; r < whole.rows.size(); ++r) {
    if (table.Text(r, "pareto") == "1") whole.marked.push_back(r);
  }
  whole.note += whole.note.empty() ? "" : " ";
  whole.note += "Marked: nothing is both faster and more accurate.";
  out.section.items.emplace_back(std::move(whole));
  return out;
}

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
      fmt::format("{} blocks at numerical extremes: {} were solved, {} solved with a warning, {} "
                  "refused and {} answered wrongly without a warning.",
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
  out.section.items.emplace_back(WholeTable(table));
  return out;
}

}  // namespace sarblock
