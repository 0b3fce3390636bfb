// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "charts.h"
#include "core/units.h"
#include "covariance/error_ellipse.h"
#include "html.h"
#include "io/geojson.h"
#include "sections.h"
#include "statistics.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostPoints = 5000;
constexpr std::size_t kMostPasses = 80;
constexpr std::size_t kMostMarks = 600;  // control, check
constexpr std::size_t kMostErrors = 150;
constexpr int kEllipseGrid = 11;  // one ellipse a cell

struct Box {
  double low[2] = {kAbsent, kAbsent}, high[2] = {kAbsent, kAbsent};
  void Add(const std::array<double, 2>& p) {
    for (std::size_t k = 0; k < 2; ++k) {
      low[k] = std::fmin(low[k], p[k]);
      high[k] = std::fmax(high[k], p[k]);
    }
  }
  [[nodiscard]] double size() const { return std::fmax(high[0] - low[0], high[1] - low[1]); }
};

class MapMaker {
 public:
  MapMaker(const ResultFolder& result, const AccuracyFigures& accuracy)
      : result_(result), accuracy_(accuracy), plane_(result) {
    const ResultPoints& points = result.file.points;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (std::isnan(points.results.position_m[i][0])) continue;
      placed_.push_back(i);
      box_.Add(plane_.Place(points.results.position_m[i]));
    }
    per_unit_m_ = box_.size() >= 3000.0 ? 1000.0 : 1.0;
  }

  [[nodiscard]] bool empty() const { return placed_.empty(); }
  [[nodiscard]] const MapPlane& plane() const { return plane_; }
  [[nodiscard]] std::size_t sampled() const { return sampled_; }
  [[nodiscard]] std::size_t placed() const { return placed_.size(); }
  [[nodiscard]] double magnified() const { return chart_.magnified; }
  [[nodiscard]] const char* unit() const { return per_unit_m_ == 1.0 ? "m" : "km"; }

  const MapChart& Make() {
    chart_.unit = unit();
    AddStrips();
    AddPoints();
    AddKnown();
    if (accuracy_.points > 0) {
      Magnify();
      AddEllipses();
      AddErrors();
    }
    return chart_;
  }

 private:
  std::array<double, 2> InUnits(const std::array<double, 2>& place_m) const {
    return {place_m[0] / per_unit_m_, place_m[1] / per_unit_m_};
  }
  std::array<double, 2> PlaceOf(std::uint32_t i) const {
    return plane_.Place(result_.file.points.results.position_m[i]);
  }

  void AddStrips() {
    const auto strips = StripsOf(result_.file);
    for (std::size_t s = 0; s < std::min(strips.size(), kMostPasses); ++s) {
      const std::string& pass = result_.file.passes[strips[s].front().pass].id;
      MapChart::Line track{pass, {}}, swath{pass, {}};
      const auto add = [&](const Eigen::Vector3d& edge_m) {
        if (!std::isnan(edge_m[0])) swath.places.push_back(InUnits(plane_.Place(edge_m)));
      };
      for (const StripStation& station : strips[s]) {
        track.places.push_back(InUnits(plane_.Place(station.antenna_m)));
        add(station.near_m);
      }
      for (std::size_t i = strips[s].size(); i-- > 0;) add(strips[s][i].far_m);
      if (swath.places.size() > 3) {
        swath.places.push_back(swath.places.front());
        chart_.swaths.push_back(std::move(swath));
      }
      chart_.tracks.push_back(std::move(track));
    }
  }

  void AddPoints() {
    const ResultPoints& points = result_.file.points;
    std::vector<std::uint32_t> shown;
    for (const std::uint32_t k : SampleIndices(placed_.size(), kMostPoints)) {
      shown.push_back(placed_[k]);
    }
    // The weakest are what a reader looks for.
    for (const std::string& id : accuracy_.largest_point) {
      const std::uint32_t i = id.empty() ? IdTable::kNone : points.ids.Find(id);
      if (i != IdTable::kNone && !std::binary_search(shown.begin(), shown.end(), i)) {
        shown.insert(std::lower_bound(shown.begin(), shown.end(), i), i);
      }
    }
    sampled_ = shown.size();
    const std::array<const char*, 3> axes = AxisNames(result_.file.frame);
    if (accuracy_.points > 0) {
      for (const char* axis : axes) {
        chart_.values.push_back({fmt::format("sigma {} [m]", axis), {}});
      }
      chart_.shown = static_cast<std::size_t>(accuracy_.weakest);
    }
    chart_.values.push_back({"intersection angle [deg]", {}});
    for (const std::uint32_t i : shown) {
      chart_.points.push_back(InUnits(PlaceOf(i)));
      chart_.point_names.emplace_back(points.ids[i]);
      for (std::size_t k = 0; k + 1 < chart_.values.size(); ++k) {
        chart_.values[k].of_point.push_back(SigmaOf(points, i, k));
      }
      chart_.values.back().of_point.push_back(IntersectionOf_deg(points, i));
    }
  }

  void AddKnown() {
    const ResultPoints& points = result_.file.points;
    for (const std::uint32_t i : placed_) {
      const PointRole role = points.role[i];
      if (role == PointRole::kTie) continue;
      const bool control = role == PointRole::kControl;
      ChartPlaces& places = control ? chart_.control : chart_.checks;
      if (places.size() >= kMostMarks) continue;
      places.push_back(InUnits(PlaceOf(i)));
      (control ? chart_.control_names : chart_.check_names).emplace_back(points.ids[i]);
    }
  }

  ErrorEllipse EllipseAt(std::uint32_t i) const {
    const ResultPoints& points = result_.file.points;
    constexpr SymmetricEnu kUnknown{kAbsent, kAbsent, 0.0, kAbsent, 0.0, 0.0};
    const std::vector<SymmetricEnu>& q_m2 = points.results.covariance_m2;
    return EllipseOf(q_m2.empty() ? kUnknown : q_m2[i]);
  }

  void Magnify() {
    std::vector<double> major_m;
    for (const std::uint32_t i : placed_) major_m.push_back(EllipseAt(i).major_m);
    const double median_m = SampleQuantile(std::move(major_m), 0.5);
    // The median ellipse is up to a twentieth of the map across.
    if (median_m > 0.0) chart_.magnified = RoundDown125(box_.size() / 40.0 / median_m);
  }

  /// One point a cell of a grid over the map, so that ellipses do not cover each other.
  void AddEllipses() {
    constexpr int kCorners = 24;
    std::set<std::pair<int, int>> taken;
    for (const std::uint32_t k : SampleIndices(placed_.size(), kMostPoints)) {
      const std::uint32_t i = placed_[k];
      const ErrorEllipse ellipse = EllipseAt(i);
      if (!std::isfinite(ellipse.major_m)) continue;
      const std::array<double, 2> place_m = PlaceOf(i);
      const auto cell = [&](std::size_t axis) {
        return static_cast<int>(kEllipseGrid * (place_m[axis] - box_.low[axis]) /
                                std::max(1e-9, box_.size()));
      };
      if (!taken.emplace(cell(0), cell(1)).second) continue;
      ChartPlaces outline;
      const double azimuth = ellipse.azimuth_rad;
      for (int c = 0; c <= kCorners; ++c) {
        const double angle = 2.0 * std::numbers::pi * c / kCorners;
        const double along_m = chart_.magnified * ellipse.major_m * std::cos(angle);
        const double aside_m = chart_.magnified * ellipse.minor_m * std::sin(angle);
        outline.push_back(
            InUnits({place_m[0] + along_m * std::sin(azimuth) + aside_m * std::cos(azimuth),
                     place_m[1] + along_m * std::cos(azimuth) - aside_m * std::sin(azimuth)}));
      }
      chart_.ellipses.push_back(std::move(outline));
    }
  }

  void AddErrors() {
    for (const CheckResult& check : result_.file.points.checks) {
      if (chart_.errors.size() >= kMostErrors) return;
      if (std::isnan(check.error_enu_m[0]) || std::isnan(check.error_enu_m[1])) continue;
      const std::array<double, 2> from_m = PlaceOf(check.point);
      chart_.errors.push_back({InUnits(from_m),
                               InUnits({from_m[0] + chart_.magnified * check.error_enu_m[0],
                                        from_m[1] + chart_.magnified * check.error_enu_m[1]})});
    }
  }

  const ResultFolder& result_;
  const AccuracyFigures& accuracy_;
  MapPlane plane_;
  std::vector<std::uint32_t> placed_;
  Box box_;
  double per_unit_m_ = 1.0;
  MapChart chart_;
  std::size_t sampled_ = 0;
};

std::string Caption(const ResultFolder& result, const MapMaker& map, const MapChart& chart) {
  std::string text =
      result.file.frame.kind() == FrameKind::kGeocentric
          ? fmt::format(
                "Plane through the middle of the block ({} degrees), east and north in {}. ",
                map.plane().middle(),
                map.unit())
          : fmt::format("x and y in {}. ", map.unit());
  if (!chart.ellipses.empty()) {
    text += fmt::format("Error ellipses of one sigma{} are drawn {} times their size.",
                        chart.errors.empty() ? "" : " and errors of check points",
                        ReadableCount(map.magnified()));
  }
  if (map.sampled() < map.placed()) {
    text += fmt::format(" {} of {} points are shown, drawn at random, with the weakest.",
                        ReadableCount(static_cast<double>(map.sampled())),
                        ReadableCount(static_cast<double>(map.placed())));
  }
  if (const std::size_t strips = StripsOf(result.file).size(); strips > kMostPasses) {
    text += fmt::format(" {} of {} passes are shown.", kMostPasses, ReadableCount(strips));
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
  constexpr std::size_t kMostPassRows = 60;
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

PageTable WeakestTable(const ResultFolder& result, const AccuracyFigures& accuracy) {
  const ResultPoints& points = result.file.points;
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
  const auto weak = static_cast<std::size_t>(accuracy.weakest);
  constexpr std::size_t kWeakRows = 15;
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
      "Two looks give four equations for three unknowns: redundancy about 1, so a blunder is seen "
      "but cannot be told to one of them.";
  return table;
}

}  // namespace

PageSection MapSection(const ResultFolder& result, const AccuracyFigures& accuracy) {
  PageSection section{"map", "Map of the block", {}};
  MapMaker map(result, accuracy);
  if (map.empty()) {
    section.items.emplace_back(PageText{"No point has a position.", "note"});
    return section;
  }
  const MapChart& chart = map.Make();
  section.items.emplace_back(PageFigure{"map-chart",
                                        "Points, flight paths and swaths",
                                        Caption(result, map, chart),
                                        "map",
                                        ChartJson("map-chart", chart)});
  if (result.file.strips.empty()) {
    section.items.emplace_back(
        PageText{"The result holds no flight paths and swaths (strips.csv).", "note"});
  } else {
    section.items.emplace_back(PassTable(result, map.plane()));
  }
  if (accuracy.points > 0) section.items.emplace_back(WeakestTable(result, accuracy));
  return section;
}

}  // namespace sarblock
