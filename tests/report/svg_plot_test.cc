// SPDX-License-Identifier: Apache-2.0
#include "report/svg_plot.h"

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

Plot OneSeries(std::vector<std::array<double, 2>> points, PlotMark mark) {
  Plot plot;
  plot.series.resize(1);
  plot.series[0].points = std::move(points);
  plot.series[0].mark = mark;
  return plot;
}

std::size_t CountOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

// Hand arithmetic: the plot's frame is 460 by 320, y grows upwards.
TEST(SvgPlotTest, PlacesPointsOnGivenLinearAxes) {
  Plot plot = OneSeries({{0.0, 10.0}, {5.0, 20.0}, {10.0, 12.5}}, PlotMark::kLine);
  plot.x.range = {{0.0, 10.0}};
  plot.y.range = {{10.0, 20.0}};
  EXPECT_THAT(SvgOf(plot), HasSubstr("M0.00 320.00L230.00 0.00L460.00 240.00"));
}

TEST(SvgPlotTest, PlacesDecadesEvenlyOnALogarithmicAxis) {
  Plot plot = OneSeries({{1.0, 1e-2}, {10.0, 1.0}, {100.0, 0.1}}, PlotMark::kLine);
  plot.x.scale = plot.y.scale = PlotScale::kLog;
  plot.x.range = {{1.0, 100.0}};
  plot.y.range = {{1e-2, 1.0}};
  EXPECT_THAT(SvgOf(plot), HasSubstr("M0.00 320.00L230.00 0.00L460.00 160.00"));
}

TEST(SvgPlotTest, PlacesSquaresEvenlyOnAnAxisOfRoots) {
  Plot plot =
      OneSeries({{0.0, 110.0}, {4.0, 120.0}, {16.0, 115.0}, {-1.0, 115.0}}, PlotMark::kLine);
  plot.x.scale = PlotScale::kRoot;
  plot.x.range = {{0.0, 16.0}};
  plot.y.range = {{110.0, 120.0}};
  const std::string svg = SvgOf(plot);
  EXPECT_THAT(svg, HasSubstr("M0.00 320.00L230.00 0.00L460.00 160.00\""));
  for (const char* tick : {">0<", ">1<", ">2<", ">5<", ">10<"}) EXPECT_EQ(CountOf(svg, tick), 1u);
  EXPECT_EQ(CountOf(svg, ">0.5<"), 0u);
  plot.x.range = {{0.0, 4.0}};
  const std::string few = SvgOf(plot);
  for (const char* tick : {">0.1<", ">0.2<", ">0.5<"}) EXPECT_EQ(CountOf(few, tick), 0u);
  EXPECT_EQ(CountOf(few, ">2<"), 1u);
  plot.x.range = {{-1.0, 16.0}};
  EXPECT_THROW(static_cast<void>(SvgOf(plot)), std::logic_error);
}

TEST(SvgPlotTest, EighteenSeriesLookDifferent) {
  std::set<std::string> drawn;
  for (std::size_t i = 0; i < 18; ++i) {
    Plot plot = OneSeries({{1.0, 1.0}, {2.0, 3.0}}, PlotMark::kBoth);
    SetStyle(i, &plot.series[0]);
    drawn.insert(SvgOf(plot));
  }
  EXPECT_EQ(drawn.size(), 18u);
  Plot open = OneSeries({{1.0, 1.0}}, PlotMark::kMarkers);
  open.series[0].open = true;
  EXPECT_THAT(SvgOf(open), HasSubstr("fill=\"white\" stroke=\"#4477aa\""));
}

TEST(SvgPlotTest, ALineBreaksWhereAValueCannotBeShown) {
  Plot plot = OneSeries({{1.0, 1.0}, {2.0, kNotANumber}, {3.0, 1.0}, {4.0, -1.0}, {5.0, 1.0}},
                        PlotMark::kLine);
  plot.y.scale = PlotScale::kLog;
  const std::string svg = SvgOf(plot);
  EXPECT_EQ(CountOf(svg, "nan"), 0u);
  const std::size_t at = svg.find("<path d=\"M0.00");
  ASSERT_NE(at, std::string::npos);
  const std::string path = svg.substr(at, svg.find('"', at + 9) - at);
  EXPECT_EQ(CountOf(path, "M"), 3u);
  EXPECT_EQ(CountOf(path, "L"), 0u);
}

TEST(SvgPlotTest, AxesReachRoundNumbersAroundTheData) {
  const std::string svg = SvgOf(OneSeries({{0.13, 3.0}, {0.97, 47.0}}, PlotMark::kMarkers));
  for (const char* label : {">0<", ">0.2<", ">1<", ">10<", ">50<"}) {
    EXPECT_THAT(svg, HasSubstr(label));
  }
  EXPECT_EQ(CountOf(svg, "<circle"), 2u);
}

TEST(SvgPlotTest, TextsAreEscapedAndNothingDependsOnIdentifiers) {
  Plot plot = OneSeries({{1.0, 1.0}}, PlotMark::kBoth);
  plot.title = "a < b & \"c\"";
  plot.x.label = "x>";
  plot.series[0].name = "line\n<svg>";
  plot.notes = {"]]>"};
  const std::string svg = SvgOf(plot);
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &quot;c&quot;"));
  EXPECT_THAT(svg, HasSubstr("line &lt;svg&gt;"));
  EXPECT_THAT(svg, HasSubstr("]]&gt;"));
  EXPECT_THAT(svg, Not(HasSubstr("id=")));
  EXPECT_EQ(CountOf(svg, "<svg"), CountOf(svg, "</svg>"));
}

TEST(SvgPlotTest, EveryColourHasAMarkerOfItsOwn) {
  std::vector<std::string> markers;
  for (std::size_t colour = 0; colour < PlotSeries::kColours; ++colour) {
    Plot plot = OneSeries({{1.0, 1.0}}, PlotMark::kMarkers);
    plot.series[0].colour = colour;
    const std::string svg = SvgOf(plot);
    const std::size_t begin = svg.rfind("<svg");
    const std::size_t shape = svg.find('\n', begin) + 1;
    std::string marker = svg.substr(shape, svg.find(" fill", shape) - shape);
    EXPECT_THAT(markers, Not(::testing::Contains(marker)));
    markers.push_back(std::move(marker));
  }
}

TEST(SvgPlotTest, AnEmptyPlotHasAxesAndAnEmptyRangeIsRefused) {
  EXPECT_THAT(SvgOf(Plot{}), HasSubstr(">0.2<"));
  Plot plot;
  plot.x.range = {{2.0, 2.0}};
  EXPECT_THROW(static_cast<void>(SvgOf(plot)), std::logic_error);
  plot.x = {.label = "", .scale = PlotScale::kLog, .range = {{0.0, 1.0}}};
  EXPECT_THROW(static_cast<void>(SvgOf(plot)), std::logic_error);
}

// Hand arithmetic: a decade in three cells, the middle one at half of the logarithm.
TEST(HeatMapTest, ColoursFollowTheLogarithmAndCellsTheirLabels) {
  HeatMap map;
  map.title = "worst <point>";
  map.rows = {"60 %"};
  map.columns = {"0", "4", "8", "12"};
  map.values = {1.0, std::sqrt(10.0), 10.0, kNotANumber};
  map.framed = {true, false, false, false};
  const std::string svg = SvgOf(map);
  EXPECT_THAT(svg, HasSubstr("worst &lt;point&gt;"));
  for (const char* text : {">1<", ">3.16<", ">10<", ">-<", ">60 %<", ">12<"}) {
    EXPECT_EQ(CountOf(svg, text), 1U) << text;
  }
  EXPECT_EQ(CountOf(svg, "#fdf4c8"), 1U);  // least
  EXPECT_EQ(CountOf(svg, "#e0865c"), 1U);  // half way
  EXPECT_EQ(CountOf(svg, "#60215c"), 1U);  // most
  EXPECT_EQ(CountOf(svg, "stroke=\"#228833\""), 1U);
  map.values.pop_back();
  EXPECT_THROW(static_cast<void>(SvgOf(map)), std::logic_error);
}

// Hand arithmetic: a plot is 420 high; each column is as wide as its widest picture.
TEST(PlotPanelTest, AreSideBySideInRows) {
  Plot plot = OneSeries({{0.0, 1.0}, {1.0, 2.0}}, PlotMark::kLine);
  HeatMap map;
  map.rows = map.columns = {"a"};
  map.values = {2.0};
  const std::string svg = SvgOf({plot, map, map}, 2);
  EXPECT_EQ(CountOf(svg, "xmlns"), 1U);
  EXPECT_EQ(CountOf(svg, "</svg>"), 1U + 3U + 1U);  // document, pictures, the plot's frame
  const std::string alone = SvgOf(plot);
  const std::size_t at = alone.find("width=\"") + 7;
  const std::string width = alone.substr(at, alone.find('"', at) - at);
  EXPECT_THAT(svg, HasSubstr("<svg x=\"0\" y=\"0\" width=\"" + width + "\" height=\"420\">"));
  EXPECT_THAT(svg, HasSubstr("<svg x=\"" + width + "\" y=\"0\""));
  EXPECT_THAT(svg, HasSubstr("<svg x=\"0\" y=\"420\""));
  EXPECT_THROW(static_cast<void>(SvgOf({plot}, 0)), std::logic_error);
}

}  // namespace
}  // namespace sarblock
