// SPDX-License-Identifier: Apache-2.0
#include "svg_plot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "core/text.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr double kLeft = 76.0, kTop = 40.0, kPlotWidth = 460.0, kPlotHeight = 320.0;
constexpr double kHeight = 420.0, kGap = 14.0, kLine = 18.0, kSample = 36.0;
constexpr double kCharacter = 6.7;  // of a text of 12 units, on the wide side
constexpr std::array<const char*, PlotSeries::kColours + 1> kColour = {
    "#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377", "#000000"};
constexpr std::array<const char*, 3> kDashes = {"", "7,4", "2,3"};

struct Tick {
  double value;
  bool labelled;
};

/// A value axis: places in 0..1 and ticks.
class Axis {
 public:
  Axis(const PlotAxis& axis, double least, double most)
      : log_(axis.scale == PlotScale::kLog),
        root_(axis.scale == PlotScale::kRoot),
        given_(axis.range.has_value()) {
    if (given_) {
      least = (*axis.range)[0];
      most = (*axis.range)[1];
      if (!(least < most) || (log_ && !(least > 0.0)) || (root_ && !(least >= 0.0))) {
        throw std::logic_error("a plot's axis has no range");
      }
    }
    if (!(least <= most)) least = log_ ? 0.1 : 0.0, most = 1.0;  // nothing to show
    begin_ = To(least);
    end_ = To(most);
    log_ ? MakeLogTicks() : root_ ? MakeRootTicks(most) : MakeTicks();
  }

  [[nodiscard]] double To(double value) const {
    return log_ ? std::log10(value) : root_ ? std::sqrt(value) : value;
  }
  [[nodiscard]] bool Shows(double value) const {
    return std::isfinite(value) && (!log_ || value > 0.0) && (!root_ || value >= 0.0);
  }
  /// Part of the way along the axis.
  [[nodiscard]] double Part(double value) const { return (To(value) - begin_) / (end_ - begin_); }
  [[nodiscard]] const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  void MakeTicks() {
    if (begin_ == end_) {
      const double half = begin_ == 0.0 ? 1.0 : 0.1 * std::abs(begin_);
      begin_ -= half;
      end_ += half;
    }
    const double raw = (end_ - begin_) / 6.0;
    const double decade = std::pow(10.0, std::floor(std::log10(raw)));
    const double step = decade * (raw > 5.0 * decade   ? 10.0
                                  : raw > 2.0 * decade ? 5.0
                                  : raw > decade       ? 2.0
                                                       : 1.0);
    if (!given_) {
      begin_ = step * std::floor(begin_ / step + 1e-9);
      end_ = step * std::ceil(end_ / step - 1e-9);
    }
    const double first = std::ceil(begin_ / step - 1e-9);
    for (double i = first; i * step <= end_ + 1e-9 * step; i += 1.0) {
      ticks_.push_back({i == 0.0 ? 0.0 : i * step, true});
    }
  }

  /// 0 and numbers 1, 2, 5 of each decade, as many as there is room for.
  void MakeRootTicks(double most) {
    if (!given_) {  // from 0, with room for whole markers at both ends
      end_ = 1.02 * std::max(end_, 1.0);
      begin_ = -0.02 * end_;
    }
    constexpr double kRoom = 0.05;
    double last = -1.0;
    const auto add = [&](double value) {
      const double part = Part(value);
      const bool small = value > 0.0 && value < 1.0;  // counts are whole
      if (small || part < -1e-9 || part > 1.0 + 1e-9 || part - last < kRoom) return;
      ticks_.push_back({value, true});
      last = part;
    };
    add(0.0);
    const int highest = static_cast<int>(std::ceil(std::log10(std::max(most, 1.0))));
    for (int d = highest - 4; d <= highest; ++d) {
      for (const double m : {1.0, 2.0, 5.0}) add(m * std::pow(10.0, d));
    }
  }

  void MakeLogTicks() {
    if (!given_) {  // out to the next of 1, 2, 5
      begin_ = Round(begin_, -1);
      end_ = Round(end_, 1);
    }
    const double decades = end_ - begin_;
    const int every = std::max(1, static_cast<int>(std::ceil(decades / 10.0)));
    for (int d = static_cast<int>(std::floor(begin_)) - 1; d <= static_cast<int>(end_) + 1; ++d) {
      for (int m = 1; m < 10; ++m) {
        const double at = d + std::log10(static_cast<double>(m));
        if (at < begin_ - 1e-9 || at > end_ + 1e-9) continue;
        const bool main = m == 1 && d % every == 0;
        const bool between = decades < 3.0 && (m == 2 || m == 5);
        if (m == 1 || decades < 4.0) ticks_.push_back({m * std::pow(10.0, d), main || between});
      }
    }
  }

  static double Round(double log, int direction) {
    const double decade = std::floor(log);
    const std::array<double, 4> steps = {
        decade, decade + std::log10(2.0), decade + std::log10(5.0), decade + 1.0};
    if (direction < 0) {
      double below = decade;
      for (const double step : steps) {
        if (step <= log + 1e-9) below = step;
      }
      return below - (log - below < 1e-9 ? 0.05 : 0.0);
    }
    for (const double step : steps) {
      if (step >= log - 1e-9) return step + (step - log < 1e-9 ? 0.05 : 0.0);
    }
    return decade + 1.0;
  }

  bool log_;
  bool root_;
  bool given_;
  double begin_ = 0.0, end_ = 1.0;
  std::vector<Tick> ticks_;
};

Axis AxisOf(const Plot& plot, std::size_t coordinate) {
  const PlotAxis& axis = coordinate == 0 ? plot.x : plot.y;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  const auto add = [&](double value) {
    if (!std::isfinite(value) || (axis.scale == PlotScale::kLog && value <= 0.0)) return;
    if (axis.scale == PlotScale::kRoot && value < 0.0) return;
    least = std::min(least, value);
    most = std::max(most, value);
  };
  for (const PlotSeries& series : plot.series) {
    for (const auto& point : series.points) add(point[coordinate]);
    if (coordinate == 0) continue;
    for (const auto& bar : series.bars) add(bar[0]), add(bar[1]);
  }
  return {axis, least, most};
}

const char* ColourOf(const PlotSeries& series) { return kColour[series.colour % kColour.size()]; }

/// A marker about x, y: one shape a colour.
std::string Marker(double x, double y, const PlotSeries& series) {
  const std::string fill =
      series.open
          ? fmt::format("fill=\"white\" stroke=\"{}\" stroke-width=\"1.4\"", ColourOf(series))
          : fmt::format("fill=\"{}\"", ColourOf(series));
  const auto path = [&](const char* shape) {
    return fmt::format("<path d=\"M{:.2f} {:.2f}{}z\" {}/>\n", x, y, shape, fill);
  };
  switch (series.colour % kColour.size()) {
    case 1:
      return path("m-3.2 -3.2h6.4v6.4h-6.4");
    case 2:
      return path("m0 -4.4l4 7h-8");
    case 3:
      return path("m0 -4.6l4.6 4.6l-4.6 4.6l-4.6 -4.6");
    case 4:
      return path("m0 4.4l4 -7h-8");
    case 5:
      return path("m-1.3 -4h2.6v2.7h2.7v2.6h-2.7v2.7h-2.6v-2.7h-2.7v-2.6h2.7");
    default:
      return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"3.4\" {}/>\n", x, y, fill);
  }
}

std::string Dashes(const PlotSeries& series) {
  const char* dashes = kDashes[static_cast<std::size_t>(series.dash)];
  return *dashes == '\0' ? "" : fmt::format(" stroke-dasharray=\"{}\"", dashes);
}

/// Lines, bars and markers inside the plot's frame, in its own coordinates.
std::string DrawSeries(const PlotSeries& series, const Axis& x, const Axis& y) {
  std::string path, marks;
  bool begins = true;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const auto& point = series.points[i];
    if (!x.Shows(point[0]) || !y.Shows(point[1])) {
      begins = true;
      continue;
    }
    const double at_x = kPlotWidth * x.Part(point[0]);
    const double at_y = kPlotHeight * (1.0 - y.Part(point[1]));
    fmt::format_to(std::back_inserter(path), "{}{:.2f} {:.2f}", begins ? "M" : "L", at_x, at_y);
    begins = false;
    if (series.mark != PlotMark::kLine) marks += Marker(at_x, at_y, series);
    if (i < series.bars.size() && y.Shows(series.bars[i][0]) && y.Shows(series.bars[i][1])) {
      fmt::format_to(std::back_inserter(marks),
                     "<path d=\"M{:.2f} {:.2f}V{:.2f}\" stroke=\"{}\"/>\n",
                     at_x,
                     kPlotHeight * (1.0 - y.Part(series.bars[i][0])),
                     kPlotHeight * (1.0 - y.Part(series.bars[i][1])),
                     ColourOf(series));
    }
  }
  if (series.mark == PlotMark::kMarkers || path.empty()) return marks;
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n",
                     path,
                     ColourOf(series),
                     Dashes(series)) +
         marks;
}

std::string DrawGrid(const Axis& x, const Axis& y) {
  std::string svg;
  auto out = std::back_inserter(svg);
  for (const Tick& tick : y.ticks()) {
    const double at = kTop + kPlotHeight * (1.0 - y.Part(tick.value));
    fmt::format_to(out,
                   "<path d=\"M{} {:.2f}h{}\" stroke=\"{}\"/>\n",
                   kLeft,
                   at,
                   kPlotWidth,
                   tick.labelled ? "#cccccc" : "#eeeeee");
    if (!tick.labelled) continue;
    fmt::format_to(out,
                   "<text x=\"{}\" y=\"{:.2f}\" text-anchor=\"end\">{:.4g}</text>\n",
                   kLeft - 6,
                   at + 4,
                   tick.value);
  }
  for (const Tick& tick : x.ticks()) {
    const double at = kLeft + kPlotWidth * x.Part(tick.value);
    fmt::format_to(out,
                   "<path d=\"M{:.2f} {}v{}\" stroke=\"{}\"/>\n",
                   at,
                   kTop,
                   kPlotHeight,
                   tick.labelled ? "#cccccc" : "#eeeeee");
    if (!tick.labelled) continue;
    fmt::format_to(out,
                   "<text x=\"{:.2f}\" y=\"{}\" text-anchor=\"middle\">{:.4g}</text>\n",
                   at,
                   kTop + kPlotHeight + 16,
                   tick.value);
  }
  return svg;
}

std::string DrawLegend(const Plot& plot, double* bottom) {
  std::string svg;
  auto out = std::back_inserter(svg);
  const double left = kLeft + kPlotWidth + kGap;
  double at = kTop + kGap;
  for (const PlotSeries& series : plot.series) {
    if (series.name.empty()) continue;
    if (series.in_its_colour) {
      fmt::format_to(out,
                     "<text x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>\n",
                     left,
                     at,
                     ColourOf(series),
                     XmlText(series.name));
    } else {
      if (series.mark != PlotMark::kMarkers) {
        fmt::format_to(out,
                       "<path d=\"M{} {}h{}\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n",
                       left,
                       at - 4,
                       kSample,
                       ColourOf(series),
                       Dashes(series));
      }
      if (series.mark != PlotMark::kLine) svg += Marker(left + kSample / 2, at - 4, series);
      fmt::format_to(
          out, "<text x=\"{}\" y=\"{}\">{}</text>\n", left + kSample + 8, at, XmlText(series.name));
    }
    at += kLine;
  }
  at += kGap / 2;
  for (const std::string& note : plot.notes) {
    fmt::format_to(
        out, "<text x=\"{}\" y=\"{}\" font-size=\"11\">{}</text>\n", left, at, XmlText(note));
    at += 15.0;
  }
  *bottom = at;
  return svg;
}

double WidthOf(const Plot& plot) {
  double widest = 0.0;
  for (const PlotSeries& series : plot.series) {
    if (series.name.empty()) continue;
    const double sample = series.in_its_colour ? 0.0 : kSample + 8;
    widest = std::max(widest, sample + kCharacter * static_cast<double>(series.name.size()));
  }
  for (const std::string& note : plot.notes) {
    widest = std::max(widest, 0.92 * kCharacter * static_cast<double>(note.size()));
  }
  const double title = kLeft + kCharacter * static_cast<double>(plot.title.size());
  return std::ceil(std::max(kLeft + kPlotWidth + kGap + widest + kGap, title));
}

}  // namespace

void SetStyle(std::size_t number, PlotSeries* series) {
  const std::size_t round = number / PlotSeries::kColours % kDashes.size();
  series->colour = number % PlotSeries::kColours;
  series->dash = static_cast<PlotDash>(round);
  series->open = round > 0;
}

namespace {

/// A picture without the element around it.
struct Drawing {
  double width, height;
  std::string content;
};

std::string DocumentOf(const Drawing& drawing) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\">\n{2}</svg>\n",
      drawing.width,
      drawing.height,
      drawing.content);
}

/// White ground, title and what a document says of itself.
std::string GroundOf(const std::string& title, double title_left, double width, double height) {
  return fmt::format(
      "<title>{2}</title>\n<!-- written by sarblock -->\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{3}\" y=\"22\">{2}</text>\n",
      width,
      height,
      XmlText(title),
      title_left);
}

Drawing DrawingOf(const Plot& plot) {
  const Axis x = AxisOf(plot, 0), y = AxisOf(plot, 1);
  double bottom = 0.0;
  const std::string legend = DrawLegend(plot, &bottom);
  Drawing drawing{WidthOf(plot), std::max(kHeight, bottom + kGap), {}};
  std::string& svg = drawing.content;
  svg = GroundOf(plot.title, kLeft, drawing.width, drawing.height);
  svg += DrawGrid(x, y);
  fmt::format_to(
      std::back_inserter(svg),
      "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n"
      "<text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}"
      "</text>\n<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" overflow=\"hidden\">\n",
      kLeft + kPlotWidth / 2,
      kTop + kPlotHeight + 38,
      XmlText(plot.x.label),
      kTop + kPlotHeight / 2,
      XmlText(plot.y.label),
      kLeft,
      kTop,
      kPlotWidth,
      kPlotHeight);
  for (const PlotSeries& series : plot.series) svg += DrawSeries(series, x, y);
  svg += "</svg>\n" + legend;
  return drawing;
}

/// From light to dark, distinct in grey as well.
std::string HeatColour(double part) {
  constexpr std::array<std::array<double, 3>, 4> kStops = {
      {{253, 244, 200}, {244, 178, 102}, {204, 90, 82}, {96, 33, 92}}};
  const double at = std::clamp(part, 0.0, 1.0) * static_cast<double>(kStops.size() - 1);
  const std::size_t low = std::min<std::size_t>(static_cast<std::size_t>(at), kStops.size() - 2);
  std::array<int, 3> colour{};
  for (std::size_t i = 0; i < 3; ++i) {
    colour[i] = static_cast<int>(
        std::lround(std::lerp(kStops[low][i], kStops[low + 1][i], at - static_cast<double>(low))));
  }
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

/// Part of the way from the least to the most of the values.
class HeatScale {
 public:
  explicit HeatScale(const std::vector<double>& values) {
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      least_ = std::min(least_, value);
      most_ = std::max(most_, value);
    }
    log_ = least_ > 0.0;
  }
  [[nodiscard]] double Part(double value) const {
    if (!(least_ < most_)) return 0.0;
    return log_ ? std::log(value / least_) / std::log(most_ / least_)
                : (value - least_) / (most_ - least_);
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
  bool log_ = false;
};

double WidestOf(const std::vector<std::string>& labels) {
  std::size_t widest = 0;
  for (const std::string& label : labels) widest = std::max(widest, label.size());
  return kCharacter * static_cast<double>(widest);
}

Drawing DrawingOf(const HeatMap& map) {
  if (map.values.size() != map.rows.size() * map.columns.size() ||
      (!map.framed.empty() && map.framed.size() != map.values.size())) {
    throw std::logic_error("a heat map needs a value for each pair of labels");
  }
  constexpr double kRow = 30.0, kHead = 74.0;
  const double cell = std::max(64.0, WidestOf(map.columns) + kGap);
  const double left = kGap + 24.0 + WidestOf(map.rows) + kGap;
  const double right = left + cell * static_cast<double>(map.columns.size());
  const double bottom = kHead + kRow * static_cast<double>(map.rows.size());
  const double width =
      std::ceil(kGap + std::max({right,
                                 kGap + kCharacter * static_cast<double>(map.title.size()),
                                 left + WidestOf({map.columns_label}),
                                 left + WidestOf(map.notes)}));
  const double height = bottom + kGap + kLine * static_cast<double>(map.notes.size() + 1);
  Drawing drawing{width, height, {}};
  std::string& svg = drawing.content;
  svg = GroundOf(map.title, kGap, width, height);
  svg += fmt::format(
      "<text x=\"{}\" y=\"46\">{}</text>\n"
      "<text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
      left,
      XmlText(map.columns_label),
      0.5 * (kHead + bottom),
      XmlText(map.rows_label));
  auto out = std::back_inserter(svg);
  for (std::size_t j = 0; j < map.columns.size(); ++j) {
    fmt::format_to(out,
                   "<text x=\"{:.2f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                   left + cell * (static_cast<double>(j) + 0.5),
                   kHead - 8.0,
                   XmlText(map.columns[j]));
  }
  const HeatScale scale(map.values);
  for (std::size_t i = 0; i < map.rows.size(); ++i) {
    const double top = kHead + kRow * static_cast<double>(i);
    fmt::format_to(out,
                   "<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"end\">{}</text>\n",
                   left - 8.0,
                   top + 0.5 * kRow + 4.0,
                   XmlText(map.rows[i]));
    for (std::size_t j = 0; j < map.columns.size(); ++j) {
      const std::size_t at = i * map.columns.size() + j;
      const double x = left + cell * static_cast<double>(j), value = map.values[at];
      const bool shown = std::isfinite(value);
      const double part = shown ? scale.Part(value) : 0.0;
      fmt::format_to(
          out,
          "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n"
          "<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\" fill=\"{}\">{}</text>\n",
          x + 1.0,
          top + 1.0,
          cell - 2.0,
          kRow - 2.0,
          shown ? HeatColour(part) : "#ffffff",
          x + 0.5 * cell,
          top + 0.5 * kRow + 4.0,
          part > 0.55 ? "white" : "black",
          shown ? Digits(value, 3) : "-");
      if (map.framed.empty() || !map.framed[at]) continue;
      fmt::format_to(out,
                     "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
                     "fill=\"none\" stroke=\"#228833\" stroke-width=\"2.5\"/>\n",
                     x + 2.5,
                     top + 2.5,
                     cell - 5.0,
                     kRow - 5.0);
    }
  }
  for (std::size_t k = 0; k < map.notes.size(); ++k) {
    fmt::format_to(out,
                   "<text x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n",
                   left,
                   bottom + kLine * static_cast<double>(k + 1),
                   XmlText(map.notes[k]));
  }
  return drawing;
}

}  // namespace

std::string SvgOf(const Plot& plot) { return DocumentOf(DrawingOf(plot)); }

std::string SvgOf(const HeatMap& map) { return DocumentOf(DrawingOf(map)); }

std::string SvgOf(const std::vector<PlotPanel>& panels, std::size_t columns) {
  if (columns == 0) throw std::logic_error("panels need a column");
  std::vector<Drawing> drawings;
  for (const PlotPanel& panel : panels) {
    drawings.push_back(std::visit([](const auto& of) { return DrawingOf(of); }, panel));
  }
  std::vector<double> widths(std::min(columns, drawings.size()), 0.0);
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    widths[i % columns] = std::max(widths[i % columns], drawings[i].width);
  }
  Drawing all{0.0, 0.0, {}};
  for (const double width : widths) all.width += width;
  for (std::size_t begin = 0; begin < drawings.size(); begin += columns) {
    const std::size_t end = std::min(drawings.size(), begin + columns);
    double left = 0.0, height = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Drawing& drawing = drawings[i];
      all.content += fmt::format("<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\">\n{}</svg>\n",
                                 left,
                                 all.height,
                                 drawing.width,
                                 drawing.height,
                                 drawing.content);
      left += widths[i - begin];
      height = std::max(height, drawing.height);
    }
    all.height += height;
  }
  all.content = fmt::format(
      "<rect width=\"{}\" height=\"{}\" fill=\"white\"/>\n{}", all.width, all.height, all.content);
  return DocumentOf(all);
}
}  // namespace sarblock
