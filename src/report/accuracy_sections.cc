// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "page.h"
#include "result_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMaxKnownRows = 300;
constexpr std::size_t kMaxChecks = 400;  // in a chart

std::vector<std::string> TestRow(const std::string& name, const files::ResultTest& test) {
  return {name,
          Shown(test.sigma0_squared),
          Shown(test.chi_square.lower / test.redundancy),
          Shown(test.chi_square.upper / test.redundancy),
          ShownPercent(test.level),
          ReadableCount(test.redundancy),
          test.passed ? "passed" : "FAILED"};
}

PageTable GroupTable(const files::ResultSummary& summary) {
  PageTable table;
  table.title = "Groups of observations";
  table.columns = {{"group", false},
                   {"v'Pv", true},
                   {"redundancy", true},
                   {"variance factor", true},
                   {"from", true},
                   {"to", true}};
  for (const ObservationGroup& group : summary.groups) {
    if (group.name != "all" && !group.agrees()) {
      table.marked.push_back(table.rows.size());
    }
    table.rows.push_back({group.name,
                          Shown(group.square_sum),
                          ReadableCount(group.redundancy),
                          ShownWithSigma(group.factor(), group.factor_deviation()),
                          Shown(group.band.lower),
                          Shown(group.band.upper)});
  }
  table.note =
      "Looks and control are tested without the priors. A factor outside its limits says that the "
      "standard deviations of this group are not those of its errors; priors may be wider than "
      "what came out.";
  return table;
}

PageTable ReductionTable(const files::ResultFile& file) {
  PageTable table;
  table.title = "Taken off the measured values";
  table.columns = {{"pass", false},
                   {"term", false},
                   {"mean", true},
                   {"least", true},
                   {"largest", true},
                   {"unit", false}};
  for (const ReductionTerm& term : file.reductions.terms) {
    table.rows.push_back({file.passes[term.pass].id,
                          term.term,
                          Shown(term.mean),
                          Shown(term.least),
                          Shown(term.largest),
                          term.unit == "m" ? "m of range" : "s of time"});
  }
  table.note =
      "Measured less geometric. \"given\" is what the looks say themselves (range_delay_m, "
      "time_shift_s), the rest are the models of [reduction].";
  return table;
}

PageTable VarianceTable(const files::ResultSummary& summary) {
  PageTable table;
  table.title = "Variance components";
  table.columns = {{"group", false},
                   {"component", false},
                   {"looks", true},
                   {"redundancy", true},
                   {"factor of the variance", true},
                   {"sigma before", true},
                   {"sigma after", true},
                   {"unit", false},
                   {"note", false}};
  for (const VarianceComponent& v : summary.variances) {
    table.rows.push_back({v.group,
                          kLookComponents.at(static_cast<std::size_t>(v.component)),
                          ReadableCount(v.looks),
                          Shown(v.redundancy),
                          ShownWithSigma(v.factor, v.factor_deviation),
                          Shown(v.sigma_before),
                          ShownWithSigma(v.sigma_after(), v.sigma_deviation()),
                          v.unit,
                          v.estimated ? v.note : "held: " + v.note});
  }
  table.note =
      "A factor that differs from 1 by more than three of its standard deviations says that the "
      "looks of this group were weighted wrongly. All standard deviations of this result are those "
      "with the weights estimated.";
  return table;
}

void AddMonteCarlo(const files::ResultRepetition& runs, PageSection* section) {
  PageTable table;
  table.title = fmt::format("Repeated adjustments with drawn noise: {} runs", runs.runs);
  table.columns = {{"figure", false},
                   {"expected", true},
                   {"mean", true},
                   {"99 % interval of the mean", true},
                   {"", false}};
  for (const files::ResultRepetition::Figure& row : runs.figures) {
    if (!row.agrees) table.marked.push_back(table.rows.size());
    table.rows.push_back({row.name,
                          Shown(row.expected),
                          Shown(row.mean),
                          Shown(row.lower) + " to " + Shown(row.upper),
                          row.agrees ? "agrees" : "does not agree"});
  }
  table.note = runs.verdict;
  section->items.emplace_back(std::move(table));
}

struct KnownFigure {
  std::vector<double> sigma_m, error_m;
  std::vector<std::string> names;
};

/// Errors of one component, ordered by their predicted standard deviation, between its curves.
PageFigure ErrorFigure(const KnownFigure& known, const char* axis, std::size_t component) {
  std::vector<std::size_t> order(known.error_m.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return known.sigma_m[a] < known.sigma_m[b];
  });
  XyChart chart;
  chart.x.label = "check points, by predicted sigma";
  chart.y.label = "error [m]";
  ChartSeries two{"2 sigma predicted", "band", "sky", {}, {}, {}, {}, {}};
  ChartSeries one{"1 sigma predicted", "band", "blue", {}, {}, {}, {}, {}};
  ChartSeries errors{"error", "points", "ink", {}, {}, {}, {}, {}};
  for (std::size_t n = 0; n < order.size(); ++n) {
    const std::size_t i = order[n];
    const auto x = static_cast<double>(n + 1);
    for (ChartSeries* series : {&two, &one}) {
      const double k = series == &two ? 2.0 : 1.0;
      series->x.push_back(x);
      series->y.push_back(0.0);
      series->low.push_back(-k * known.sigma_m[i]);
      series->high.push_back(k * known.sigma_m[i]);
    }
    errors.x.push_back(x);
    errors.y.push_back(known.error_m[i]);
    errors.names.push_back(known.names[i]);
  }
  chart.series = {two, one, errors};
  const std::string id = fmt::format("checks-{}", component);
  return {id, fmt::format("Errors in {}", axis), "", "third", ChartJson(id, chart)};
}

void AddCheckItems(const ResultFolder& result, PageSection* section) {
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
  const files::ResultPoints& points = result.file.points;
  if (result.file.summary.checks && !result.file.summary.checks->says.empty()) {
    const std::string& says = result.file.summary.checks->says;
    section->items.emplace_back(PageText{Capital(says) + (says.ends_with('.') ? "" : "."), ""});
  }
  PageTable rms;
  rms.title = "Check points: errors against what was predicted";
  rms.columns = {{"component", false},
                 {"points", true},
                 {"mean error [m]", true},
                 {"rms error [m]", true},
                 {"rms predicted [m]", true},
                 {"ratio", true}};
  PageFigures figures;
  const bool predicted_at_all =
      std::any_of(points.checks.begin(), points.checks.end(), [](const CheckResult& check) {
        return !std::isnan(check.chi_square);
      });
  for (std::size_t k = 0; k < 3; ++k) {
    KnownFigure known;
    double sum = 0.0, squares = 0.0, predicted = 0.0, n = 0.0;
    const auto axis = static_cast<Eigen::Index>(k);
    for (const CheckResult& check : points.checks) {
      const double error_m = check.error_enu_m[axis], sigma_m = check.sigma_enu_m[axis];
      // A point without a standard deviation (left out as contradictory) is compared with nothing.
      if (std::isnan(error_m) || (predicted_at_all && std::isnan(sigma_m))) continue;
      n += 1.0;
      sum += error_m;
      squares += error_m * error_m;
      predicted += sigma_m * sigma_m;
      if (known.error_m.size() < kMaxChecks) {
        known.error_m.push_back(error_m);
        known.sigma_m.push_back(sigma_m);
        known.names.emplace_back(points.ids[check.point]);
      }
    }
    if (n == 0.0) continue;
    rms.rows.push_back({axes[k],
                        ReadableCount(n),
                        Shown(sum / n, 3),
                        Shown(std::sqrt(squares / n), 3),
                        Shown(std::sqrt(predicted / n), 3),
                        Shown(std::sqrt(squares / predicted), 3)});
    if (known.error_m.size() > 1) figures.figures.push_back(ErrorFigure(known, axes[k], k));
  }
  rms.note = "Predicted: covariance of the adjusted point and that of the known position together.";
  section->items.emplace_back(std::move(rms));
  if (!figures.figures.empty()) {
    section->items.emplace_back(std::move(figures));
    section->items.emplace_back(
        PageText{"About 68 of 100 errors should lie within one sigma and 95 within two.", "note"});
  }
}

PageTable CheckTable(const ResultFolder& result) {
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
  std::vector<const CheckResult*> order;
  for (const CheckResult& check : result.file.points.checks) order.push_back(&check);
  std::sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return a->chi_square > b->chi_square ||
           (std::isnan(b->chi_square) && !std::isnan(a->chi_square));
  });
  PageTable table;
  table.title = fmt::format("The {} check points farthest from what was predicted",
                            std::min(order.size(), kMaxKnownRows));
  table.folded = true;
  table.columns = {{"point", false}};
  for (const char* axis : axes)
    table.columns.push_back({std::string("error ") + axis + " [m]", true});
  for (const char* axis : axes)
    table.columns.push_back({std::string("sigma ") + axis + " [m]", true});
  table.columns.push_back({"chi-square", true});
  for (std::size_t i = 0; i < std::min(order.size(), kMaxKnownRows); ++i) {
    const CheckResult& check = *order[i];
    std::vector<std::string> row{std::string(result.file.points.ids[check.point])};
    for (const double error_m : check.error_enu_m) row.push_back(Shown(error_m, 3));
    for (const double sigma_m : check.sigma_enu_m) row.push_back(Shown(sigma_m, 3));
    row.push_back(Shown(check.chi_square, 3));
    table.rows.push_back(std::move(row));
  }
  table.note =
      "The chi-square of a point is the square of its error in units of its error ellipsoid: up to "
      "three are expected of three known components.";
  return table;
}

PageTable ControlTable(const ResultFolder& result) {
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
  std::vector<const files::ResultControl*> order;
  for (const files::ResultControl& control : result.file.control) order.push_back(&control);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return std::abs(a->w) > std::abs(b->w);
  });
  PageTable table;
  table.title = "Control points: residuals against sigmas";
  table.columns = {{"point", false},
                   {"component", false},
                   {"residual [m]", true},
                   {"sigma given [m]", true},
                   {"redundancy", true},
                   {"w", true},
                   {"minimal detectable blunder [m]", true},
                   {"its influence [m]", true}};
  const double critical =
      result.file.summary.tests ? result.file.summary.tests->critical_w : kAbsent;
  for (std::size_t i = 0; i < std::min(order.size(), kMaxKnownRows); ++i) {
    const files::ResultControl& c = *order[i];
    if (std::abs(c.w) > critical) table.marked.push_back(i);
    table.rows.push_back({std::string(result.file.points.ids[c.point]),
                          axes[static_cast<std::size_t>(c.component)],
                          Shown(c.residual_m, 3),
                          Shown(c.sigma_m, 3),
                          Shown(c.redundancy, 3),
                          Shown(c.w, 3),
                          Shown(c.mdb_m, 3),
                          Shown(c.influence_m, 3)});
  }
  table.note = fmt::format(
      "{} of {} components, the largest |w| first. Low redundancy: an error of this coordinate "
      "would go into the block unseen, as far as its influence says.",
      std::min(order.size(), kMaxKnownRows),
      order.size());
  return table;
}

/// Sigma of differences against the distance, one figure a component, pairs along and across.
void AddDifferences(const std::vector<DifferenceClass>& differences, PageSection* section) {
  constexpr std::array kAxes = {"along", "across", "up"};
  PageFigures figures;
  for (std::size_t k = 0; k < kAxes.size(); ++k) {
    XyChart chart;
    chart.x = {"distance [m]", true, kNotGiven, kNotGiven};
    chart.y.label = "sigma [m]";
    ChartSeries along{"pairs along the track", "line", "blue", {}, {}, {}, {}, {}};
    ChartSeries across{"pairs across it", "dash", "ink", {}, {}, {}, {}, {}};
    for (const DifferenceClass& of : differences) {
      ChartSeries& series = of.along ? along : across;
      series.x.push_back(of.distance_m);
      series.y.push_back(std::array{of.sigma_along_m, of.sigma_across_m, of.sigma_up_m}[k]);
    }
    chart.series = {along, across};
    FitY(&chart);
    const std::string id = fmt::format("differences-{}", k);
    figures.figures.push_back({id,
                               fmt::format("Differences {} against distance", kAxes[k]),
                               "",
                               "third",
                               ChartJson(id, chart)});
  }
  section->items.emplace_back(std::move(figures));
  section->items.emplace_back(
      PageText{"Standard deviation of the difference of two points, the median of a sample of "
               "pairs of each distance. Along is the track of the first pass.",
               "note"});
}

}  // namespace

PageSection TestSection(const ResultFolder& result) {
  PageSection section{"test", "Global test and variance components", {}};
  const files::ResultSummary& summary = result.file.summary;
  if (!summary.chi_square) {
    section.items.emplace_back(
        PageText{summary.status == "predicted"
                     ? "A prediction has no residuals, so there is no variance factor to test."
                     : "There is no redundancy, so there is no variance factor to test.",
                 "note"});
  } else {
    PageTable table;
    table.columns = {{"", false},
                     {"variance factor s0\xc2\xb2", true},
                     {"from", true},
                     {"to", true},
                     {"level", true},
                     {"redundancy", true},
                     {"", false}};
    if (summary.test_before)
      table.rows.push_back(TestRow("as weighted at first", *summary.test_before));
    table.rows.push_back(
        TestRow(summary.test_before ? "with variances estimated" : "looks and control",
                *summary.chi_square));
    if (!summary.chi_square->passed) table.marked.push_back(table.rows.size() - 1);
    table.note = summary.sigma_scaled_by_posterior
                     ? "All standard deviations of this report are scaled by s0."
                     : "All standard deviations of this report are those of the weights as given; "
                       "with s0\xc2\xb2 taken into account they would be multiplied by " +
                           Shown(std::sqrt(summary.sigma0_squared)) + ".";
    section.items.emplace_back(std::move(table));
  }
  if (!summary.groups.empty()) section.items.emplace_back(GroupTable(summary));
  if (!result.file.reductions.terms.empty()) {
    section.items.emplace_back(ReductionTable(result.file));
  }
  if (!summary.variances.empty()) {
    section.items.emplace_back(VarianceTable(summary));
  } else if (summary.status == "converged") {
    section.items.emplace_back(
        PageText{"Variance components of range and azimuth were not estimated (variance_components "
                 "= \"range-azimuth\" or \"per-pass\" would).",
                 "note"});
  }
  if (summary.repetition) AddMonteCarlo(*summary.repetition, &section);
  return section;
}

PageSection KnownPointsSection(const ResultFolder& result) {
  PageSection section{"known", "Control and check points", {}};
  if (result.file.points.checks.empty()) {
    section.items.emplace_back(PageText{
        "There are no check points: no known position was kept out of the adjustment.", "note"});
  } else {
    AddCheckItems(result, &section);
    section.items.emplace_back(CheckTable(result));
  }
  if (result.file.control.empty()) {
    const bool some = result.file.summary.Count("control_points") > 0.0;
    section.items.emplace_back(PageText{some
                                            ? "The result holds no residuals of its control points."
                                            : "There are no control points.",
                                        "note"});
  } else {
    section.items.emplace_back(ControlTable(result));
  }
  if (!result.file.summary.differences.empty()) {
    AddDifferences(result.file.summary.differences, &section);
  }
  return section;
}

}  // namespace sarblock
