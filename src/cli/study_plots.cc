// SPDX-License-Identifier: Apache-2.0
#include "study_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/svg_plot.h"
#include "studies/design_law.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

/// Distinct texts of a column in the order they appear.
std::vector<std::string> Distinct(const StudyTable& table, std::string_view column) {
  std::vector<std::string> found;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string text = table.Text(row, column);
    if (std::find(found.begin(), found.end(), text) == found.end()) found.push_back(text);
  }
  return found;
}

std::string TitleOf(const std::string& what, const std::string& variant) {
  return variant.empty() ? what : what + ": " + variant;
}

Plot AgainstControl(std::string title, std::string quantity) {
  Plot plot;
  plot.title = std::move(title);
  plot.x = {.label = "control points", .scale = PlotScale::kRoot, .range = {}};
  plot.y = {.label = std::move(quantity), .scale = PlotScale::kLog, .range = {}};
  return plot;
}

/// Values that stay within a factor of three are seen better on a linear axis.
void ChooseScale(Plot* plot) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const PlotSeries& series : plot->series) {
    for (const auto& point : series.points) {
      if (!std::isfinite(point[0]) || !std::isfinite(point[1])) continue;
      least = std::min(least, point[1]);
      most = std::max(most, point[1]);
    }
  }
  if (most < 3.0 * least) plot->y.scale = PlotScale::kLinear;
}

/// Worst sigma of a variant against the number of control points, one line per layout.
Plot PlotWorst(const StudyTable& table, const std::string& variant, const std::string& direction) {
  Plot plot = AgainstControl(TitleOf("Worst point", variant), "sigma_" + direction + " [m]");
  const std::string column = "max_sigma_" + direction + "_m";
  for (const std::string& layout : Distinct(table, "layout")) {
    PlotSeries series;
    bool own = false;  // a row beside that without control
    const bool exchanged = layout.starts_with("exchange ");
    const bool placed = exchanged || layout.starts_with("greedy ");  // has its own start
    for (std::size_t row = 0; row < table.size(); ++row) {
      const std::string of = table.Text(row, "layout");
      // Without control every layout begins in the same place.
      if ((of != layout && (of != "none" || placed)) || table.Text(row, "variant") != variant) {
        continue;
      }
      own = own || of == layout;
      const double count = table.Number(row, "control_points");
      if (!series.points.empty() && count < series.points.back()[0]) {  // another placement
        series.points.push_back({kNaN, kNaN});
      }
      series.points.push_back({count, table.Number(row, column)});
    }
    if (layout == "none" || !own) continue;
    series.name = layout;
    SetStyle(plot.series.size(), &series);
    if (exchanged) series.mark = PlotMark::kMarkers;
    plot.series.push_back(std::move(series));
  }
  ChooseScale(&plot);
  return plot;
}

/// Median of positions and of differences of neighbours, the best layout of each number of points.
Plot PlotRelative(const StudyTable& table, const std::vector<std::string>& variants) {
  Plot plot =
      AgainstControl("Positions and differences of neighbours, up, best layout", "sigma [m]");
  for (std::size_t v = 0; v < variants.size() && v < PlotSeries::kColours; ++v) {
    std::map<double, std::array<double, 2>> best;  // by number of control points
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (table.Text(row, "variant") != variants[v] || table.Number(row, "determined") != 1.0) {
        continue;
      }
      const std::array<double, 2> sigmas_m = {table.Number(row, "median_sigma_u_m"),
                                              table.Number(row, "median_difference_sigma_u_m")};
      const auto [at, added] = best.emplace(table.Number(row, "control_points"), sigmas_m);
      if (!added && sigmas_m[0] < at->second[0]) at->second = sigmas_m;
    }
    PlotSeries position, difference;
    for (const auto& [count, sigmas_m] : best) {
      position.points.push_back({count, sigmas_m[0]});
      difference.points.push_back({count, sigmas_m[1]});
    }
    position.name = variants[v].empty() ? "median sigma_u" : variants[v];
    position.colour = difference.colour = v;
    difference.dash = PlotDash::kDashed;
    plot.series.push_back(std::move(position));
    plot.series.push_back(std::move(difference));
  }
  plot.notes = {"solid: positions", "dashed: differences"};
  return plot;
}

/// Normalised errors squared of the verified rows with their simultaneous bounds.
std::optional<Plot> PlotVerified(const StudyTable& table, const std::string& name) {
  Plot plot;
  plot.title = "Monte Carlo against prediction";
  plot.x.label = "row of " + name + ".csv";
  plot.y.label = "mean of e' Q^-1 e / 3";
  PlotSeries found, bound;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double nees = table.Number(row, "nees");
    if (std::isnan(nees)) continue;
    const auto x = static_cast<double>(row + 1);
    found.points.push_back({x, nees});
    bound.points.push_back({x, 1.0});
    bound.bars.push_back({table.Number(row, "nees_lower"), table.Number(row, "nees_upper")});
  }
  if (found.points.empty()) return std::nullopt;
  found.name = "found";
  found.mark = PlotMark::kMarkers;
  bound.name = "expected, with bound";
  bound.mark = PlotMark::kLine;
  bound.colour = 4;
  plot.series = {bound, found};
  return plot;
}

/// Median (dashed) and worst (solid) sigmas against the swept value, or against its place in the
/// list where the values are not numbers.
Plot PlotSweep(const DesignStudy& study, const StudyTable& table) {
  Plot plot;
  plot.title = "Accuracy against " + study.axes.front().name;
  plot.x.label = study.axes.front().name;
  plot.y = {.label = "sigma [m]", .scale = PlotScale::kLog, .range = {}};
  bool numbers = true;
  for (std::size_t row = 0; row < table.size(); ++row) {
    numbers = numbers && std::isfinite(table.Number(row, "number_1"));
  }
  if (!numbers) {
    plot.x.label += ", as listed";
    for (std::size_t row = 0; row < table.size(); ++row) {
      plot.notes.push_back(fmt::format("{}: {}", row + 1, study.axes.front().values[row]));
    }
  }
  for (std::size_t axis = 0; axis < kDesignDirections.size(); ++axis) {
    for (const bool worst : {true, false}) {
      PlotSeries series;
      series.name = std::string(kDesignDirections[axis]) + (worst ? ", worst point" : ", median");
      series.colour = axis;
      series.dash = worst ? PlotDash::kSolid : PlotDash::kDashed;
      series.open = !worst;
      const std::string column =
          fmt::format("{}_sigma_{}_m", worst ? "max" : "median", kDesignDirections[axis]);
      for (std::size_t row = 0; row < table.size(); ++row) {
        const double x = numbers ? table.Number(row, "number_1") : static_cast<double>(row + 1);
        series.points.push_back({x, table.Number(row, column)});
      }
      plot.series.push_back(std::move(series));
    }
  }
  ChooseScale(&plot);
  return plot;
}

HeatMap PlotDesignMatrix(const DesignStudy& study,
                         const StudyTable& table,
                         const std::string& column,
                         const std::string& title) {
  HeatMap map;
  map.title = title;
  map.rows_label = study.axes[0].name;
  map.columns_label = study.axes[1].name;
  map.rows = study.axes[0].values;
  map.columns = study.axes[1].values;
  for (std::size_t row = 0; row < table.size(); ++row) {
    map.values.push_back(table.Number(row, column));
    if (!study.goals.empty()) map.framed.push_back(table.Number(row, "reached") == 1.0);
  }
  if (!study.goals.empty()) map.notes = {"framed: reaches all goals"};
  return map;
}

/// Accuracy against cost; what nothing beats in both is joined by a line.
Plot PlotCost(const DesignStudy& study, const StudyTable& table) {
  const std::string quantity = DesignQuantity(study);
  Plot plot;
  plot.title = "Accuracy against cost";
  plot.x.label = "cost" + (study.prices.currency.empty() ? "" : " [" + study.prices.currency + "]");
  plot.y = {.label = quantity.starts_with("max") ? "worst point [m]" : "median [m]",
            .scale = PlotScale::kLog,
            .range = {}};
  PlotSeries best, others;
  best.name = "nothing is cheaper and better";
  others.name = "others";
  others.mark = PlotMark::kMarkers;
  others.colour = PlotSeries::kBlack;
  others.open = true;
  for (std::size_t row = 0; row < table.size(); ++row) {
    PlotSeries& series = table.Number(row, "pareto") == 1.0 ? best : others;
    series.points.push_back({table.Number(row, "cost"), table.Number(row, quantity)});
  }
  std::sort(best.points.begin(), best.points.end());
  plot.series = {others, best};
  ChooseScale(&plot);
  return plot;
}

/// Sigma of a direction against what is swept, both logarithmic: values as markers, laws as lines.
Plot PlotLaws(const DesignStudy& study, const std::vector<FittedLaw>& laws, std::size_t axis) {
  const std::string& swept = study.axes[study.law->axis].name;
  Plot plot;
  plot.title = fmt::format("Growth {} with {}, worst point", kDesignDirections[axis], swept);
  plot.x = {.label = swept, .scale = PlotScale::kLog, .range = {}};
  plot.y = {
      .label = study.law->part == DesignLaw::Part::kPaths ? "what the paths add [m]" : "sigma [m]",
      .scale = PlotScale::kLog,
      .range = {}};
  for (const FittedLaw& fitted : laws) {
    if (fitted.axis != axis || !fitted.column.starts_with("max_")) continue;
    PlotSeries values, line;
    const std::string derived =
        std::isnan(fitted.derived) ? "" : fmt::format(", derived {:.2f}", fitted.derived);
    values.name = fmt::format("{}{}p {:.2f}{}",
                              fitted.value,
                              fitted.value.empty() ? "" : ": ",
                              fitted.law.exponent,
                              derived);
    SetStyle(fitted.place, &values);
    line.colour = values.colour;
    line.dash = values.dash;
    values.mark = PlotMark::kMarkers;
    line.mark = PlotMark::kLine;
    values.points = fitted.values;
    for (const auto& [x, y] : fitted.values) {
      line.points.push_back({x, fitted.law.factor * std::pow(x, fitted.law.exponent)});
    }
    plot.series.push_back(std::move(line));
    plot.series.push_back(std::move(values));
  }
  plot.notes = {"lines: sigma = c x^p, least squares", "in logarithms"};
  return plot;
}

}  // namespace

std::vector<StudyFile> PlotsOf(const DensificationStudy& /*study*/, const StudyTable& table) {
  const std::vector<std::string> variants = Distinct(table, "variant");
  std::vector<PlotPanel> worst;
  for (const std::string& variant : variants) {
    for (const char* direction : {"u", "h"}) worst.push_back(PlotWorst(table, variant, direction));
  }
  std::vector<PlotPanel> relative = {PlotRelative(table, variants)};
  if (auto verified = PlotVerified(table, "densification")) {
    relative.emplace_back(*std::move(verified));
  }
  return {{"densification_worst.svg", SvgOf(worst, 1)},
          {"densification_relative.svg", SvgOf(relative, 1)}};
}

std::vector<StudyFile> PlotsOf(const DesignStudy& study, const StudyTable& table) {
  const bool curve = study.axes.size() == 1;
  std::vector<PlotPanel> accuracy, laws;
  if (curve) {
    accuracy.emplace_back(PlotSweep(study, table));
  } else {
    for (const char* direction : kDesignDirections) {
      accuracy.emplace_back(PlotDesignMatrix(study,
                                             table,
                                             fmt::format("max_sigma_{}_m", direction),
                                             fmt::format("Worst point, sigma {} [m]", direction)));
    }
  }
  if (study.prices.Given()) accuracy.emplace_back(PlotCost(study, table));
  const std::vector<FittedLaw> fitted = FitLaws(study, table);
  for (std::size_t axis = 0; axis < kDesignDirections.size() && !fitted.empty(); ++axis) {
    laws.emplace_back(PlotLaws(study, fitted, axis));
  }
  if (auto verified = PlotVerified(table, "design")) laws.emplace_back(*std::move(verified));
  std::vector<StudyFile> files = {
      {curve ? "design_curve.svg" : "design_maps.svg", SvgOf(accuracy, 1)}};
  if (!laws.empty()) {
    files.emplace_back(fitted.empty() ? "design_verified.svg" : "design_law.svg", SvgOf(laws, 1));
  }
  return files;
}

}  // namespace sarblock::cli
