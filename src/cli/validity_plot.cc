// SPDX-License-Identifier: Apache-2.0
#include "validity_plot.h"

#include "sarblock/core/units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace sarblock::cli {
namespace {

constexpr double kWidth = 650.0, kHeight = 420.0, kLeft = 70.0, kTop = 40.0;
constexpr double kPlotWidth = 430.0, kPlotHeight = 320.0;
constexpr double kLowest = -4.0, kHighest = 0.0;  // log10 of error/H
constexpr std::array<const char*, 6> kColours = {
    "#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377"};

struct Level {
  std::optional<double> ValidityLine::*ratio;
  const char* dashes;
  const char* name;
};
constexpr std::array<Level, 3> kLevels = {{{&ValidityLine::error_ratio_1_percent, "2,3", "1 %"},
                                           {&ValidityLine::error_ratio_5_percent, "7,4", "5 %"},
                                           {&ValidityLine::error_ratio_20_percent, "", "20 %"}}};

double Y(double log_ratio) {
  const double part = (kHighest - log_ratio) / (kHighest - kLowest);
  return kTop + kPlotHeight * part;
}

}  // namespace

std::string PlotValidity(const std::vector<ValidityLine>& lines,
                         ValiditySource source,
                         double terrain_ratio) {
  std::vector<const ValidityLine*> chosen;
  std::vector<double> bases;
  double first_deg = 90.0, last_deg = 0.0;
  for (const ValidityLine& line : lines) {
    if (line.of.source != source || line.of.terrain_ratio_1 != terrain_ratio) continue;
    chosen.push_back(&line);
    first_deg = std::min(first_deg, line.of.look_rad * kDegPerRad);
    last_deg = std::max(last_deg, line.of.look_rad * kDegPerRad);
    if (std::find(bases.begin(), bases.end(), line.of.base_ratio_1) == bases.end()) {
      bases.push_back(line.of.base_ratio_1);
    }
  }
  const double span_deg = std::max(last_deg - first_deg, 1e-9);
  const auto x = [&](double look_deg) {
    return kLeft + kPlotWidth * (look_deg - first_deg) / span_deg;
  };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"22\">Size of {3} at which the first order is off by 1, 5 and 20 %; "
      "point "
      "at z/H = {4}</text>\n",
      kWidth,
      kHeight,
      kLeft,
      NameOf(source),
      terrain_ratio);
  auto out = std::back_inserter(svg);
  for (int decade = static_cast<int>(kLowest); decade <= static_cast<int>(kHighest); ++decade) {
    fmt::format_to(out,
                   "<path d=\"M{0} {1}h{2}\" stroke=\"#dddddd\"/><text x=\"{3}\" y=\"{4}\" "
                   "text-anchor=\"end\">1e{5}</text>\n",
                   kLeft,
                   Y(decade),
                   kPlotWidth,
                   kLeft - 6,
                   Y(decade) + 4,
                   decade);
  }
  for (double look_deg = std::ceil(first_deg / 10.0) * 10.0; look_deg <= last_deg + 1e-9;
       look_deg += 10.0) {
    fmt::format_to(out,
                   "<path d=\"M{0:.2f} {1}v{2}\" stroke=\"#dddddd\"/><text x=\"{0:.2f}\" y=\"{3}\" "
                   "text-anchor=\"middle\">{4:.0f}</text>\n",
                   x(look_deg),
                   kTop,
                   kPlotHeight,
                   kTop + kPlotHeight + 16,
                   look_deg);
  }
  fmt::format_to(out,
                 "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">look angle of station ' [deg]"
                 "</text><text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">"
                 "error / H</text>\n",
                 kLeft + kPlotWidth / 2,
                 kTop + kPlotHeight + 38,
                 kTop + kPlotHeight / 2);
  const double lowest_ratio = std::pow(10.0, kLowest);
  bool terrain_exceeds = false;
  for (std::size_t b = 0; b < bases.size(); ++b) {
    const char* colour = kColours[b % kColours.size()];
    for (const Level& level : kLevels) {
      std::string path;
      leberl::Arrangement side = leberl::Arrangement::kSameSide;
      bool begins = true;
      for (const ValidityLine* line : chosen) {
        if (line->of.base_ratio_1 != bases[b]) continue;
        const std::optional<double>& ratio = line->*level.ratio;
        // The line breaks where terrain alone exceeds the level (0), outside the plot, and where
        // the point passes from between the stations to one side of them.
        if (!ratio || *ratio < lowest_ratio || *ratio > 1.0) {
          begins = true;
          terrain_exceeds = terrain_exceeds || (ratio && *ratio == 0.0);
          continue;
        }
        begins = begins || line->of.arrangement != side;
        side = line->of.arrangement;
        fmt::format_to(std::back_inserter(path),
                       "{}{:.2f} {:.2f}",
                       begins ? "M" : "L",
                       x(line->of.look_rad * kDegPerRad),
                       Y(std::log10(*ratio)));
        begins = false;
      }
      fmt::format_to(out,
                     "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" "
                     "stroke-dasharray=\"{}\"/>\n",
                     path,
                     colour,
                     level.dashes);
    }
    fmt::format_to(out,
                   "<text x=\"{}\" y=\"{}\" fill=\"{}\">B/H = {}</text>\n",
                   kLeft + kPlotWidth + 14,
                   kTop + 14 + 18.0 * static_cast<double>(b),
                   colour,
                   bases[b]);
  }
  for (std::size_t k = 0; k < kLevels.size(); ++k) {
    const double y = kTop + 130 + 18.0 * static_cast<double>(k);
    fmt::format_to(out,
                   "<path d=\"M{0} {1}h36\" stroke=\"black\" stroke-dasharray=\"{2}\"/>"
                   "<text x=\"{3}\" y=\"{4}\">{5}</text>\n",
                   kLeft + kPlotWidth + 14,
                   y,
                   kLevels[k].dashes,
                   kLeft + kPlotWidth + 58,
                   y + 4,
                   kLevels[k].name);
  }
  std::vector<const char*> notes = {"Left of a gap:", "opposite-side,", "right: same-side."};
  if (terrain_exceeds) {
    notes.insert(notes.end(), {"", "No line: terrain", "alone exceeds it."});
  }
  for (std::size_t k = 0; k < notes.size(); ++k) {
    fmt::format_to(out,
                   "<text x=\"{}\" y=\"{}\" font-size=\"11\">{}</text>\n",
                   kLeft + kPlotWidth + 14,
                   kTop + 234 + 15.0 * static_cast<double>(k),
                   notes[k]);
  }
  return svg + "</svg>\n";
}

}  // namespace sarblock::cli
