// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sarblock {

/// Plots as SVG text: the one way in which the program draws.
///
/// Six colours that are distinct for the colour-blind too (Paul Tol's bright scheme), each with its
/// own marker, so that no plot relies on colour alone. Every text is escaped. No fonts, scripts,
/// styles or identifiers: a plot is complete as a file and may be put into a page with others.

enum class PlotScale {
  kLinear,
  kLog,
  kRoot,  ///< square root: shows small counts beside large ones, and 0
};

struct PlotAxis {
  std::string label;
  PlotScale scale = PlotScale::kLinear;
  /// From, to; not given: range of the data, to round numbers. kLog: both above 0, kRoot: not
  /// below.
  std::optional<std::array<double, 2>> range;
};

enum class PlotMark { kLine, kMarkers, kBoth };
enum class PlotDash { kSolid, kDashed, kDotted };

/// A line or a set of markers.
struct PlotSeries {
  static constexpr std::size_t kColours = 6;
  static constexpr std::size_t kBlack = kColours;  ///< a seventh, for what is no colour's

  std::string name;  ///< in the legend; empty: not there
  /// x, y in the order of the line. A value that is not finite (or not above 0 on a logarithmic
  /// axis, below 0 on one of roots) leaves a gap. Without points the series is in the legend
  /// alone.
  std::vector<std::array<double, 2>> points;
  /// By point, lower and upper end of a vertical bar; empty: none.
  std::vector<std::array<double, 2>> bars;
  PlotMark mark = PlotMark::kBoth;
  PlotDash dash = PlotDash::kSolid;
  std::size_t colour = 0;      ///< 0 to kBlack; larger numbers begin again at 0
  bool open = false;           ///< markers as outlines
  bool in_its_colour = false;  ///< the legend's text in the colour, without a sample
};

/// Colour, dashes and markers of the n-th of many series of one plot: the first six solid, the next
/// six dashed with open markers, the next dotted; then again from the first.
void SetStyle(std::size_t number, PlotSeries* series);

struct Plot {
  std::string title;
  PlotAxis x;
  PlotAxis y;
  std::vector<PlotSeries> series;
  std::vector<std::string> notes;  ///< lines below the legend
};

/// The plot as an SVG document; the same plot gives the same bytes. Without any point to show it
/// has empty axes. Throws std::logic_error for a given range that is empty or, on a logarithmic
/// axis, not positive.
[[nodiscard]] std::string SvgOf(const Plot& plot);

/// A quantity by two others, a cell for each pair of values: its number, on a colour from light
/// (least) to dark (most).
struct HeatMap {
  std::string title;
  std::string rows_label, columns_label;
  std::vector<std::string> rows, columns;  ///< labels, from the top and from the left
  std::vector<double> values;              ///< by row, then column; not finite: an empty cell
  std::vector<bool> framed;                ///< by cell, with a frame; empty: none
  std::vector<std::string> notes;          ///< lines below
};

/// The map as an SVG document, colours by the logarithm where all values are above 0. Throws
/// std::logic_error unless there is a value for each pair of labels.
[[nodiscard]] std::string SvgOf(const HeatMap& map);

using PlotPanel = std::variant<Plot, HeatMap>;

/// Several pictures in one document, row by row. Throws std::logic_error for no columns.
[[nodiscard]] std::string SvgOf(const std::vector<PlotPanel>& panels, std::size_t columns);

}  // namespace sarblock
