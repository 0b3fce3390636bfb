// SPDX-License-Identifier: Apache-2.0
#include "validity_plot.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <limits>

#include "report/svg_plot.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

constexpr double kLowest = 1e-4, kHighest = 1.0;  // error/H

struct Level {
  std::optional<double> ValidityLine::*ratio;
  PlotDash dash;
  const char* name;
};
constexpr std::array<Level, 3> kLevels = {
    {{&ValidityLine::error_ratio_1_percent, PlotDash::kDotted, "1 %"},
     {&ValidityLine::error_ratio_5_percent, PlotDash::kDashed, "5 %"},
     {&ValidityLine::error_ratio_20_percent, PlotDash::kSolid, "20 %"}}};

PlotSeries EmptySeries(std::size_t colour, PlotDash dash) {
  PlotSeries line;
  line.mark = PlotMark::kLine;
  line.colour = colour;
  line.dash = dash;
  return line;
}

}  // namespace

std::string PlotValidity(const std::vector<ValidityLine>& lines,
                         ValiditySource source,
                         double terrain_ratio) {
  std::vector<const ValidityLine*> chosen;
  std::vector<double> bases;
  for (const ValidityLine& line : lines) {
    if (line.of.source != source || line.of.terrain_ratio_1 != terrain_ratio) continue;
    chosen.push_back(&line);
    if (std::find(bases.begin(), bases.end(), line.of.base_ratio_1) == bases.end()) {
      bases.push_back(line.of.base_ratio_1);
    }
  }
  Plot plot;
  plot.title =
      fmt::format("Size of {} at which the first order is off by 1, 5 and 20 %; point at z/H = {}",
                  NameOf(source),
                  terrain_ratio);
  plot.x.label = "look angle of station ' [deg]";
  plot.y = {.label = "error / H", .scale = PlotScale::kLog, .range = {{kLowest, kHighest}}};
  constexpr std::array<double, 2> kGap = {std::numeric_limits<double>::quiet_NaN(),
                                          std::numeric_limits<double>::quiet_NaN()};
  bool terrain_exceeds = false;
  for (std::size_t b = 0; b < bases.size(); ++b) {
    for (const Level& level : kLevels) {
      PlotSeries series = EmptySeries(b, level.dash);
      leberl::Arrangement side = leberl::Arrangement::kSameSide;
      for (const ValidityLine* line : chosen) {
        if (line->of.base_ratio_1 != bases[b]) continue;
        const std::optional<double>& ratio = line->*level.ratio;
        // The line breaks where terrain alone exceeds the level (0), outside the plot, and where
        // the point passes from between the stations to one side of them.
        if (!ratio || *ratio < kLowest || *ratio > kHighest) {
          series.points.push_back(kGap);
          terrain_exceeds = terrain_exceeds || (ratio && *ratio == 0.0);
          continue;
        }
        if (line->of.arrangement != side) series.points.push_back(kGap);
        side = line->of.arrangement;
        series.points.push_back({line->of.look_rad * kDegPerRad, *ratio});
      }
      plot.series.push_back(series);
    }
    PlotSeries name = EmptySeries(b, PlotDash::kSolid);
    name.name = fmt::format("B/H = {}", bases[b]);
    name.in_its_colour = true;
    plot.series.push_back(name);
  }
  for (const Level& level : kLevels) {
    PlotSeries name = EmptySeries(PlotSeries::kBlack, level.dash);
    name.name = level.name;
    plot.series.push_back(name);
  }
  plot.notes = {"Left of a gap:", "opposite-side,", "right: same-side."};
  if (terrain_exceeds) {
    plot.notes.insert(plot.notes.end(), {"", "No line: terrain", "alone exceeds it."});
  }
  return SvgOf(plot);
}

}  // namespace sarblock::cli
