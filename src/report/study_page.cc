// SPDX-License-Identifier: Apache-2.0
#include "study_page.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "charts.h"
#include "html.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostShownRows = 400;  // of a table in the page
constexpr const char* kStudyColors[] = {
    "blue", "orange", "green", "purple", "yellow", "sky", "ink", "grey"};
constexpr const char* kStudyAxes[] = {"e", "n", "u"};
constexpr const char* kStudyAxisNames[] = {"east", "north", "up"};

std::string ColorOf(std::size_t i) { return kStudyColors[i % std::size(kStudyColors)]; }

/// All rows with the columns as they stand there, numbers shortened.
PageTable WholeTable(const StudyCsv& table, const std::set<std::string>& texts) {
  PageTable out;
  out.title = "All rows";
  out.folded = table.rows.size() > 40;
  for (const std::string& column : table.columns) {
    out.columns.push_back({column, texts.count(column) == 0});
  }
  for (std::size_t r = 0; r < std::min(table.rows.size(), kMostShownRows); ++r) {
    std::vector<std::string> row;
    for (const std::string& column : table.columns) {
      const double value = table.Number(r, column);
      row.push_back(texts.count(column) != 0 || std::isnan(value) ? table.Text(r, column)
                                                                  : Shown(value));
    }
    out.rows.push_back(std::move(row));
  }
  if (table.rows.size() > kMostShownRows) {
    out.note = fmt::format("The first {} of {} rows.",
                           kMostShownRows,
                           ReadableCount(static_cast<double>(table.rows.size())));
  }
  return out;
}

/// Rows of one value of a column, in the order of a number; those without it come last.
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

bool Determined(const StudyCsv& table, std::size_t row) {
  return table.Text(row, "determined") != "0";
}

PageFigure DensificationFigure(const StudyCsv& table, std::size_t axis) {
  const std::string predicted = fmt::format("median_sigma_{}_m", kStudyAxes[axis]);
  const std::string measured = fmt::format("montecarlo_rms_{}_m", kStudyAxes[axis]);
  XyChart chart;
  chart.x.label = "control points";
  chart.y.label = "sigma [m]";
  chart.y.logarithmic = true;
  std::size_t number = 0;
  for (const std::string& variant : table.Values("variant")) {
    for (const std::string& layout : table.Values("layout")) {
      const std::string name = variant.empty() ? layout : layout + ", " + variant;
      ChartSeries line{name, "marks", ColorOf(number), {}, {}, {}, {}, {}};
      ChartSeries runs{name + ", drawn", "points", ColorOf(number), {}, {}, {}, {}, {}};
      for (const std::size_t r : RowsOf(table, "layout", layout, "control_points")) {
        const double x = table.Number(r, "control_points");
        if (!Determined(table, r) || table.Text(r, "variant") != variant) continue;
        line.x.push_back(x);
        line.y.push_back(table.Number(r, predicted));
        if (std::isnan(table.Number(r, measured))) continue;
        runs.x.push_back(x);
        runs.y.push_back(table.Number(r, measured));
      }
      if (line.x.empty()) continue;
      chart.series.push_back(std::move(line));
      if (!runs.x.empty()) chart.series.push_back(std::move(runs));
      ++number;
    }
  }
  const std::string id = fmt::format("densification-{}", kStudyAxes[axis]);
  return {
      id, fmt::format("Median sigma {}", kStudyAxisNames[axis]), "", "half", ChartJson(id, chart)};
}

void AddDensification(const StudyCsv& table, Page* page) {
  PageSection section{"densification", "Control against accuracy", {}};
  std::size_t best = table.rows.size();
  double least = kAbsent, worst_nees = 0.0;
  std::size_t open = 0, tested = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!Determined(table, r)) {
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
  std::vector<std::string>& said = page->headline.sentences;
  said.push_back(fmt::format("{} arrangements of control were compared.", table.rows.size()));
  if (best < table.rows.size()) {
    said.push_back(fmt::format(
        "The best height, a median sigma of {} m, has the layout {} with {} control points.",
        Shown(least, 3),
        table.Text(best, "layout"),
        table.Text(best, "control_points")));
  }
  if (tested > 0) {
    said.push_back(
        fmt::format("Where runs with drawn noise tested the prediction, the normalised error "
                    "squared was at worst {} (1 is expected).",
                    Shown(worst_nees, 3)));
  }
  if (open > 0) {
    page->headline.attention.push_back(
        fmt::format("{} arrangements do not determine the block.", open));
  }
  PageFigures figures;
  for (const std::size_t axis : {2U, 0U, 1U}) {
    if (table.Column(fmt::format("median_sigma_{}_m", kStudyAxes[axis])) < table.columns.size()) {
      figures.figures.push_back(DensificationFigure(table, axis));
    }
  }
  section.items.emplace_back(std::move(figures));
  section.items.emplace_back(
      PageText{"Lines: predicted by the covariance. Single dots: scatter of repeated adjustments "
               "with drawn noise.",
               "note"});
  section.items.emplace_back(WholeTable(table, {"layout", "variant"}));
  page->sections.push_back(std::move(section));
}

/// The error that a stage trades for speed: of covariances where the stage changes them.
std::string ErrorColumn(const StudyCsv& table, const std::vector<std::size_t>& rows) {
  for (const std::size_t r : rows) {
    if (table.Number(r, "covariance_error") > 0.0) return "covariance_error";
  }
  return "position_error_sigma";
}

PageFigure TradeoffFigure(const StudyCsv& table, const std::string& stage, std::size_t number) {
  const std::vector<std::size_t> rows = RowsOf(table, "stage", stage, "wall_s");
  const std::string column = ErrorColumn(table, rows);
  // The reference has no error: it stands a decade below the smallest.
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
  for (const std::size_t r : rows) {
    if (std::isnan(table.Number(r, "wall_s"))) continue;  // was not run
    ChartSeries& series = table.Text(r, "pareto") == "1" ? front : other;
    const double error = table.Number(r, column);
    series.x.push_back(table.Number(r, "wall_s"));
    series.y.push_back(error > 0.0 ? error : floor);
    series.names.push_back(table.Text(r, "choice") + ", " + table.Text(r, "looks") + " looks");
  }
  for (ChartSeries* series : {&other, &front}) {
    if (!series->x.empty()) chart.series.push_back(std::move(*series));
  }
  const std::string id = fmt::format("tradeoff-{}", number);
  return {id,
          "Stage " + stage,
          std::isnan(least) ? "No choice of this stage has an error."
                            : "Choices without an error stand at the lower edge.",
          "half",
          ChartJson(id, chart)};
}

void AddTradeoff(const StudyCsv& table, Page* page) {
  PageSection section{"tradeoff", "Speed against accuracy", {}};
  std::size_t run = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!std::isnan(table.Number(r, "wall_s"))) ++run;
  }
  page->headline.sentences.push_back(
      fmt::format("{} choices in {} stages were run against their references.",
                  run,
                  table.Values("stage").size()));
  PageFigures figures;
  for (const std::string& stage : table.Values("stage")) {
    std::size_t fastest = table.rows.size();
    for (const std::size_t r : RowsOf(table, "stage", stage, "wall_s")) {
      if (table.Text(r, "pareto") == "1" &&
          (fastest == table.rows.size() ||
           table.Number(r, "speed_ratio") > table.Number(fastest, "speed_ratio"))) {
        fastest = r;
      }
    }
    if (fastest < table.rows.size()) {
      page->headline.sentences.push_back(
          fmt::format("{}: {} is {} times as fast as the reference, with points moved by {} sigma "
                      "and covariances by {}.",
                      Capital(stage),
                      table.Text(fastest, "choice"),
                      Shown(table.Number(fastest, "speed_ratio"), 3),
                      Shown(table.Number(fastest, "position_error_sigma"), 2),
                      Shown(table.Number(fastest, "covariance_error"), 2)));
    }
    figures.figures.push_back(TradeoffFigure(table, stage, figures.figures.size()));
  }
  section.items.emplace_back(std::move(figures));
  PageTable whole = WholeTable(table, {"stage", "choice"});
  for (std::size_t r = 0; r < whole.rows.size(); ++r) {
    if (table.Text(r, "pareto") == "1") whole.marked.push_back(r);
  }
  whole.note += whole.note.empty() ? "" : " ";
  whole.note += "Marked: nothing is both faster and more accurate.";
  section.items.emplace_back(std::move(whole));
  page->sections.push_back(std::move(section));
}

void AddStability(const StudyCsv& table, Page* page) {
  PageSection section{"stability", "Where numbers give out", {}};
  const std::vector<std::string> outcomes{"ok", "warned", "refused", "wrong"};
  const std::vector<std::string> colors{"blue", "yellow", "grey", "orange"};
  std::vector<std::size_t> of_outcome(outcomes.size(), 0);
  PageTable counts;
  counts.columns = {{"family", false}};
  for (const std::string& outcome : outcomes) counts.columns.push_back({outcome, true});
  counts.columns.push_back({"fewest digits of covariances, where ok", true});
  for (const std::string& family : table.Values("family")) {
    std::vector<std::size_t> here(outcomes.size(), 0);
    double digits = kAbsent;
    for (const std::size_t r : RowsOf(table, "family", family, "condition")) {
      for (std::size_t o = 0; o < outcomes.size(); ++o) {
        if (table.Text(r, "outcome") != outcomes[o]) continue;
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
  page->headline.state = of_outcome[3] > 0 ? HeadlineState::kNotAccepted : HeadlineState::kAccepted;
  page->headline.word =
      of_outcome[3] > 0 ? "Wrong answers were given" : "No wrong answer was given";
  page->headline.sentences.push_back(
      fmt::format("Of {} blocks made to break the numbers, {} were solved, {} solved with a "
                  "warning, {} refused and {} answered wrongly without a word.",
                  table.rows.size(),
                  of_outcome[0],
                  of_outcome[1],
                  of_outcome[2],
                  of_outcome[3]));
  PageFigures figures;
  for (const char* what : {"covariance_digits", "position_digits"}) {
    if (table.Column(what) == table.columns.size()) continue;
    XyChart chart;
    chart.x = {"condition", true, kAbsent, kAbsent};
    chart.y.label = "correct digits";
    for (std::size_t o = 0; o < outcomes.size(); ++o) {
      ChartSeries dots{outcomes[o], "points", colors[o], {}, {}, {}, {}, {}};
      for (std::size_t r = 0; r < table.rows.size(); ++r) {
        const double digits = table.Number(r, what), condition = table.Number(r, "condition");
        if (table.Text(r, "outcome") != outcomes[o] || std::isnan(digits) || !(condition > 0.0))
          continue;
        dots.x.push_back(condition);
        dots.y.push_back(digits);
        dots.names.push_back(table.Text(r, "family") + " " + table.Text(r, "value"));
      }
      if (!dots.x.empty()) chart.series.push_back(std::move(dots));
    }
    const std::string id = std::string("stability-") + what;
    figures.figures.push_back({id,
                               what[0] == 'c' ? "Digits of covariances" : "Digits of positions",
                               "",
                               "half",
                               ChartJson(id, chart)});
  }
  section.items.emplace_back(std::move(counts));
  section.items.emplace_back(std::move(figures));
  section.items.emplace_back(WholeTable(table, {"family", "parameter", "outcome", "message"}));
  page->sections.push_back(std::move(section));
}

}  // namespace

Page MakeStudyPage(const StudyFolder& study) {
  Page page;
  page.kind = "Study";
  page.title = "Study";
  page.headline.word = "In short";
  for (const StudyCsv& table : study.tables) {
    if (study.tables.size() == 1) page.title = Capital(table.kind) + " study";
    if (table.kind == "densification") AddDensification(table, &page);
    if (table.kind == "tradeoff") AddTradeoff(table, &page);
    if (table.kind == "stability") AddStability(table, &page);
  }
  if (!study.pictures.empty()) {
    PageSection section{"plots", "Plots of the study", {}};
    for (const StudyPicture& picture : study.pictures) {
      section.items.emplace_back(PagePicture{picture.name, picture.svg});
    }
    page.sections.push_back(std::move(section));
  }
  return page;
}

}  // namespace sarblock
