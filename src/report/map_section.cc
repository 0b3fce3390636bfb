// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>

#include "charts.h"
#include "files/geojson.h"
#include "html.h"
#include "map_chart.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

std::string Caption(const ResultFolder& result, const MapPlane& plane, const BlockMap& map) {
  const char* unit = map.chart.unit.c_str();
  std::string text =
      result.file.frame.kind() == FrameKind::kGeocentric
          ? fmt::format(
                "Plane through the middle of the block ({} degrees), east and north in {}. ",
                plane.middle(),
                unit)
          : fmt::format("x and y in {}. ", unit);
  text +=
      "Colours from the 2nd to the 98th percentile of the points that are not control. Drag to "
      "move; the buttons, a double click, or the wheel with Ctrl zoom.";
  if (!map.chart.ellipses.empty()) {
    text += fmt::format(
        " Error ellipses of one sigma{}, not of control points, enlarged as the key in the map "
        "says.",
        map.chart.errors.empty() ? "" : " and errors of check points");
  } else if (result.file.summary.Count("control_points") > 0.0 &&
             !result.file.points.results.covariance_m2.empty()) {
    text += " No ellipses: every point with a standard deviation is control.";
  }
  if (map.sampled < map.placed) {
    text += fmt::format(" {} of {} points are shown, drawn at random, with the weakest.",
                        ReadableCount(map.sampled),
                        ReadableCount(map.placed));
  }
  if (const std::size_t strips = StripsOf(result.file).size(); strips > map.passes) {
    text += fmt::format(" {} of {} passes are shown.", map.passes, ReadableCount(strips));
  }
  return text;
}

PageTable PassTable(const ResultFolder& result, const MapPlane& plane) {
  PageTable table;
  table.title = "Passes";
  table.folded = true;
  table.columns = {{"pass", false},
                   {"look", false},
                   {"heading [deg]", true},
                   {"strip from [s]", true},
                   {"to [s]", true},
                   {"swath, near to far [km]", true}};
  constexpr std::size_t kMostPassRows = 300;
  const auto strips = StripsOf(result.file);
  for (std::size_t s = 0; s < std::min(strips.size(), kMostPassRows); ++s) {
    const std::span<const StripStation> strip = strips[s];
    const ResultPass& pass = result.file.passes[strip.front().pass];
    const auto first = plane.Place(strip.front().antenna_m);
    const auto last = plane.Place(strip.back().antenna_m);
    double heading_deg = std::atan2(last[0] - first[0], last[1] - first[1]) * kDegPerRad;
    if (heading_deg < 0.0) heading_deg += 360.0;
    const StripStation& middle = strip[strip.size() / 2];
    const auto near = plane.Place(middle.near_m), far = plane.Place(middle.far_m);
    table.rows.push_back({pass.id,
                          pass.side == LookSide::kLeft ? "left" : "right",
                          Shown(heading_deg, 4),
                          Shown(strip.front().time_s, 6),
                          Shown(strip.back().time_s, 6),
                          Shown(std::hypot(far[0] - near[0], far[1] - near[1]) / 1000.0, 3)});
  }
  table.note = "Headings clockwise from north (y in a local frame).";
  if (strips.size() > kMostPassRows) {
    table.note += fmt::format(" The first {} of {}.", kMostPassRows, strips.size());
  }
  return table;
}

/// What the weakest twentieth of the points has in common; empty where nothing stands out.
std::string WeakGroupText(const AccuracyFigures& accuracy) {
  const AccuracyFigures::Group& weak = accuracy.weak;
  const AccuracyFigures::Group& all = accuracy.all;
  std::vector<std::string> facets;
  if (weak.median_intersection_deg < 0.8 * all.median_intersection_deg) {
    facets.push_back(fmt::format("intersect at {} degrees in the median, all at {}",
                                 Shown(weak.median_intersection_deg, 3),
                                 Shown(all.median_intersection_deg, 3)));
  }
  if (weak.median_looks_1 < all.median_looks_1) {
    facets.push_back(fmt::format(
        "have {:.0f} looks where {:.0f} are usual", weak.median_looks_1, all.median_looks_1));
  }
  if (weak.outside_control_1 > all.outside_control_1 + 0.2) {
    facets.push_back(fmt::format("lie to {} outside the control points, of all points {}",
                                 ShownPercent(weak.outside_control_1),
                                 ShownPercent(all.outside_control_1)));
  }
  if (facets.empty() || weak.points < 5) return "";
  std::string text = "The weakest twentieth of the points that are not control ";
  for (std::size_t i = 0; i < facets.size(); ++i) {
    text += (i == 0 ? "" : (i + 1 == facets.size() ? " and " : ", ")) + facets[i];
  }
  return text + ". ";
}

PageTable WeakestTable(const ResultFolder& result, const AccuracyFigures& accuracy) {
  const ResultPoints& points = result.file.points;
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
  const auto weak = static_cast<std::size_t>(accuracy.weakest);
  constexpr std::size_t kWeakRows = 100;
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (IsSolved(points.results.status[i]) && !std::isnan(SigmaOf(points, i, 0))) {
      order.push_back(i);
    }
  }
  const std::size_t rows = std::min(order.size(), kWeakRows);
  std::partial_sort(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(rows),
                    order.end(),
                    [&](std::uint32_t a, std::uint32_t b) {
                      return SigmaOf(points, a, weak) > SigmaOf(points, b, weak);
                    });
  PageTable table;
  table.title = fmt::format("The {} weakest points", rows);
  table.columns = {{"point", false}, {"role", false}};
  for (const char* axis : axes)
    table.columns.push_back({std::string("sigma ") + axis + " [m]", true});
  table.columns.push_back({fmt::format("of it by the looks, {} [m]", axes[weak]), true});
  table.columns.push_back({"looks", true});
  table.columns.push_back({"angle [deg]", true});
  table.columns.push_back({"redundancy", true});
  for (std::size_t k = 0; k < rows; ++k) {
    const std::uint32_t i = order[k];
    std::vector<std::string> row{std::string(points.ids[i]), NameOf(points.role[i])};
    for (std::size_t axis = 0; axis < 3; ++axis) row.push_back(Shown(SigmaOf(points, i, axis), 3));
    row.push_back(Shown(FixedPathSigmaOf(points, i, weak), 3));
    row.push_back(std::to_string(points.results.looks[i]));
    row.push_back(Shown(IntersectionOf_deg(points, i), 3));
    row.push_back(Shown(FigureOf(points.results.redundancy, i), 3));
    table.rows.push_back(std::move(row));
  }
  table.note =
      WeakGroupText(accuracy) +
      "Two looks give four equations for three unknowns: redundancy about 1, so a blunder is "
      "detected but cannot be attributed to one of them.";
  return table;
}

}  // namespace

PageSection MapSection(const ResultFolder& result, const AccuracyFigures& accuracy) {
  PageSection section{"map", "Map of the block", {}};
  const MapPlane plane(result);
  const BlockMap map = MapOf(result, accuracy);
  if (map.placed == 0) {
    section.items.emplace_back(PageText{"No point has a position.", "note"});
    return section;
  }
  section.items.emplace_back(PageFigure{"map-chart",
                                        "Points, flight paths and swaths",
                                        Caption(result, plane, map),
                                        "map",
                                        ChartJson("map-chart", map.chart)});
  if (accuracy.points > 0) section.items.emplace_back(WeakestTable(result, accuracy));
  if (result.file.strips.empty()) {
    section.items.emplace_back(
        PageText{"The result holds no flight paths and swaths (strips.csv).", "note"});
  } else {
    section.items.emplace_back(PassTable(result, plane));
  }
  return section;
}

}  // namespace sarblock
