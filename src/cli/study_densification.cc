// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "report/svg_plot.h"
#include "studies/densification_file.h"
#include "study_command.h"
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

/// Worst sigma of a variant against the number of control points, a line a layout.
std::string PlotWorst(const StudyTable& table,
                      const std::string& variant,
                      const std::string& direction) {
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
  return SvgOf(plot);
}

/// Median of positions and of differences of neighbours, the best layout of each number of points.
std::string PlotRelative(const StudyTable& table, const std::vector<std::string>& variants) {
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
  return SvgOf(plot);
}

/// Normalised errors squared of the verified rows with the bounds that hold together.
std::string PlotVerified(const StudyTable& table) {
  Plot plot;
  plot.title = "Monte Carlo against prediction";
  plot.x.label = "row of densification.csv";
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
  if (found.points.empty()) return {};
  found.name = "found";
  found.mark = PlotMark::kMarkers;
  bound.name = "expected, with bound";
  bound.mark = PlotMark::kLine;
  bound.colour = 4;
  plot.series = {bound, found};
  return SvgOf(plot);
}

StudyAnswer ConcludeDensification(const DensificationStudy& study, const StudyTable& table) {
  StudyAnswer answer;
  answer.words = DescribeDensification(study, table);
  const std::vector<std::string> variants = Distinct(table, "variant");
  for (std::size_t v = 0; v < variants.size(); ++v) {
    for (const char* direction : {"u", "h"}) {
      answer.files.emplace_back(fmt::format("densification_{}_{}.svg", v + 1, direction),
                                PlotWorst(table, variants[v], direction));
    }
  }
  answer.files.emplace_back("densification_relative.svg", PlotRelative(table, variants));
  if (std::string verified = PlotVerified(table); !verified.empty()) {
    answer.files.emplace_back("densification_nees.svg", std::move(verified));
  }
  return answer;
}

}  // namespace

PreparedStudy PrepareDensification(const std::string& file,
                                   const std::vector<std::string>& overrides,
                                   int /*threads*/) {
  const auto read = std::make_shared<DensificationFile>(ReadDensification(file, overrides));
  PreparedStudy prepared;
  prepared.plan = PlanDensification(read->study);
  prepared.identity = read->identity;
  prepared.conclude = [read](const StudyTable& table, ProgressSink*) {
    return ConcludeDensification(read->study, table);
  };
  return prepared;
}

}  // namespace sarblock::cli
