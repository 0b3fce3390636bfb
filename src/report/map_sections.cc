// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "files/result_tables.h"
#include "page.h"
#include "quality/covariance.h"
#include "result_page.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr int kSamples = 12;   // a side of a box, to find which degrees it spans
constexpr int kVertices = 48;  // of a line
constexpr double kLines = 3.0;

struct Span {
  double low_deg = kAbsent, high_deg = kAbsent;
  void Add(double angle_deg) {
    low_deg = std::fmin(low_deg, angle_deg);
    high_deg = std::fmax(high_deg, angle_deg);
  }
  /// Round degrees between the lines; 30 where the meridians meet in the box.
  [[nodiscard]] double Step_deg() const {
    const double size_deg = high_deg - low_deg;
    return size_deg > 180.0 ? 30.0 : RoundDown125(std::max(size_deg, 1e-7) / kLines);
  }
};

/// Latitudes and longitudes of a box; these from that of the middle, so that 180 degrees are no
/// border.
struct Degrees {
  Span lat, lon;
};

Degrees DegreesOf(const Frame& frame, const MapPlane& plane, const MapBox& box, double middle_deg) {
  Degrees out;
  for (int i = 0; i <= kSamples; ++i) {
    for (int k = 0; k <= kSamples; ++k) {
      const Geodetic at = frame.GeodeticFromFrame(
          plane.PositionAt({box.low_m[0] + (box.high_m[0] - box.low_m[0]) * i / kSamples,
                            box.low_m[1] + (box.high_m[1] - box.low_m[1]) * k / kSamples}));
      out.lat.Add(at.lat_rad * kDegPerRad);
      out.lon.Add(std::remainder(at.lon_rad * kDegPerRad - middle_deg, 360.0));
    }
  }
  return out;
}

std::string NameOfDegrees(double angle_deg,
                          double step_deg,
                          const char* positive,
                          const char* negative) {
  const int places = std::max(0, -static_cast<int>(std::floor(std::log10(step_deg) + 1e-9)));
  if (std::abs(angle_deg) < 0.5 * step_deg) return "0\xc2\xb0";
  return fmt::format(
      "{:.{}f}\xc2\xb0 {}", std::abs(angle_deg), places, angle_deg > 0.0 ? positive : negative);
}

}  // namespace

void MapBox::Add(const std::array<double, 2>& place_m) {
  for (std::size_t k = 0; k < 2; ++k) {
    low_m[k] = std::fmin(low_m[k], place_m[k]);
    high_m[k] = std::fmax(high_m[k], place_m[k]);
  }
}

MapBox MapBox::Widened(double margin_m) const {
  return {{low_m[0] - margin_m, low_m[1] - margin_m}, {high_m[0] + margin_m, high_m[1] + margin_m}};
}

std::vector<MapChart::Line> GraticuleOf(const Frame& frame,
                                        const MapPlane& plane,
                                        const MapBox& seen,
                                        const MapBox& drawn) {
  std::vector<MapChart::Line> lines;
  if (frame.kind() != FrameKind::kGeocentric) return lines;
  const Geodetic middle = frame.GeodeticFromFrame(plane.origin_m());
  const double middle_deg = middle.lon_rad * kDegPerRad;
  const Degrees whole = DegreesOf(frame, plane, drawn, middle_deg);
  const Span &lat = whole.lat, &lon = whole.lon;
  const Degrees crossed = DegreesOf(frame, plane, seen, middle_deg);
  const auto add = [&](const std::string& name, auto&& geodetic_deg) {
    MapChart::Line line{name, {}};
    for (int v = 0; v <= kVertices; ++v) {
      const std::array<double, 2> at_deg = geodetic_deg(static_cast<double>(v) / kVertices);
      line.places.push_back(plane.Place(
          frame.FrameFromGeodetic({at_deg[0] * kRadPerDeg, at_deg[1] * kRadPerDeg, middle.h_m})));
    }
    lines.push_back(std::move(line));
  };
  const double lat_step = crossed.lat.Step_deg(), lon_step = crossed.lon.Step_deg();
  for (double at = std::ceil(lat.low_deg / lat_step) * lat_step; at <= lat.high_deg;
       at += lat_step) {
    if (std::abs(at) > 89.999) continue;
    add(NameOfDegrees(at, lat_step, "N", "S"), [&](double part) {
      return std::array<double, 2>{at,
                                   middle_deg + lon.low_deg + part * (lon.high_deg - lon.low_deg)};
    });
  }
  const double first = std::ceil((middle_deg + lon.low_deg) / lon_step) * lon_step;
  for (double at = first; at <= middle_deg + lon.high_deg; at += lon_step) {
    const double name_deg = std::remainder(at, 360.0);
    add(NameOfDegrees(name_deg, lon_step, "E", "W"), [&](double part) {
      return std::array<double, 2>{lat.low_deg + part * (lat.high_deg - lat.low_deg), at};
    });
  }
  return lines;
}

namespace {

constexpr std::size_t kMaxPoints = 5000;
constexpr std::size_t kMaxPasses = 80;
constexpr std::size_t kMaxMarks = 600;  // control, check
constexpr std::size_t kMaxErrors = 150;

class MapMaker {
 public:
  MapMaker(const ResultFolder& result, const AccuracyFigures& accuracy)
      : result_(result), points_(result.file.points), accuracy_(accuracy), plane_(result) {
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      if (std::isnan(points_.results.position_m[i][0])) continue;
      placed_.push_back(i);
      box_m_.Add(PlaceOf(i));
    }
    per_unit_m_ = SizeOf_m(box_m_) >= 3000.0 ? 1000.0 : 1.0;
  }

  BlockMap Make() {
    BlockMap out;
    out.placed = placed_.size();
    if (placed_.empty()) return out;
    chart_.unit = per_unit_m_ == 1.0 ? "m" : "km";
    chart_.unit_m = per_unit_m_;
    AddStrips();
    AddPoints();
    AddKnown();
    if (accuracy_.points > 0) {
      AddEllipses();
      AddErrors();
    }
    AddGraticule();
    out.sampled = chart_.points.size();
    out.passes = chart_.tracks.size();
    out.chart = std::move(chart_);
    return out;
  }

 private:
  [[nodiscard]] static double SizeOf_m(const MapBox& box) {
    return std::fmax(box.high_m[0] - box.low_m[0], box.high_m[1] - box.low_m[1]);
  }
  [[nodiscard]] std::array<double, 2> ToUnits(const std::array<double, 2>& place_m) const {
    return {place_m[0] / per_unit_m_, place_m[1] / per_unit_m_};
  }
  [[nodiscard]] std::array<double, 2> PlaceOf(std::uint32_t i) const {
    return plane_.Place(points_.results.position_m[i]);
  }
  [[nodiscard]] bool IsControl(std::uint32_t i) const {
    return points_.role[i] == PointRole::kControl;
  }

  void AddStrips() {
    const auto strips = StripsOf(result_.file);
    for (std::size_t s = 0; s < std::min(strips.size(), kMaxPasses); ++s) {
      const std::string& pass = result_.file.passes[strips[s].front().pass].id;
      MapChart::Line track{pass, {}}, swath{pass, {}};
      const auto add = [&](const Eigen::Vector3d& edge_m) {
        if (!std::isnan(edge_m[0])) swath.places.push_back(ToUnits(plane_.Place(edge_m)));
      };
      for (const StripStation& station : strips[s]) {
        track.places.push_back(ToUnits(plane_.Place(station.antenna_m)));
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
    std::vector<std::uint32_t> shown;
    for (const std::uint32_t k : SampleIndices(placed_.size(), kMaxPoints)) {
      shown.push_back(placed_[k]);
    }
    // The weakest are what a reader looks for.
    for (const std::string& id : accuracy_.largest_point) {
      const std::uint32_t i = id.empty() ? IdTable::kNone : points_.ids.Find(id);
      if (i != IdTable::kNone && !std::binary_search(shown.begin(), shown.end(), i)) {
        shown.insert(std::lower_bound(shown.begin(), shown.end(), i), i);
      }
    }
    for (const std::uint32_t i : shown) {
      chart_.points.push_back(ToUnits(PlaceOf(i)));
      chart_.point_names.emplace_back(points_.ids[i]);
    }
    const std::array<const char*, 3> axes = AxisNames(result_.file.frame);
    if (accuracy_.points > 0) {
      for (std::size_t k = 0; k < 3; ++k) {
        AddValue(fmt::format("sigma {} [m]", axes[k]), shown, [&, k](std::uint32_t i) {
          return SigmaOf(points_, i, k);
        });
      }
      chart_.shown = static_cast<std::size_t>(accuracy_.weakest);
    }
    AddValue("intersection angle [deg]", shown, [&](std::uint32_t i) {
      return IntersectionOf_deg(points_, i);
    });
    chart_.values.back().weak_where_low = true;
  }

  template <typename Of>
  void AddValue(const std::string& label, const std::vector<std::uint32_t>& shown, const Of& of) {
    MapChart::Value value;
    value.label = label;
    for (const std::uint32_t i : shown) value.of_point.push_back(of(i));
    std::vector<double> all;
    for (const std::uint32_t i : placed_) {
      if (!IsControl(i) && std::isfinite(of(i))) all.push_back(of(i));
    }
    if (all.empty()) {  // nothing but control
      for (const std::uint32_t i : placed_) all.push_back(of(i));
    }
    constexpr std::array kEnds{0.0, 0.02, 0.98, 1.0};
    const std::vector<double> ends = SampleQuantiles(std::move(all), kEnds);
    value.least = ends[0];
    value.low = ends[1];
    value.high = ends[2];
    value.most = ends[3];
    chart_.values.push_back(std::move(value));
  }

  void AddKnown() {
    for (const std::uint32_t i : placed_) {
      if (points_.role[i] == PointRole::kTie) continue;
      ChartPlaces& places = IsControl(i) ? chart_.control : chart_.checks;
      if (places.size() >= kMaxMarks) continue;
      places.push_back(ToUnits(PlaceOf(i)));
      (IsControl(i) ? chart_.control_names : chart_.check_names).emplace_back(points_.ids[i]);
    }
  }

  void AddEllipses() {
    for (const std::uint32_t k : SampleIndices(placed_.size(), kMaxPoints)) {
      const std::uint32_t i = placed_[k];
      if (IsControl(i)) continue;
      const ErrorEllipse ellipse = EllipseOf(points_.results.covariance_m2[i]);
      if (!(ellipse.major_m > 0.0) || !std::isfinite(ellipse.major_m)) continue;
      const std::array<double, 2> place = ToUnits(PlaceOf(i));
      chart_.ellipses.push_back({place[0],
                                 place[1],
                                 ellipse.major_m / per_unit_m_,
                                 ellipse.minor_m / per_unit_m_,
                                 ellipse.azimuth_rad});
    }
  }

  void AddErrors() {
    for (const CheckResult& check : points_.checks) {
      if (chart_.errors.size() >= kMaxErrors) return;
      if (std::isnan(check.error_enu_m[0]) || std::isnan(check.error_enu_m[1])) continue;
      const std::array<double, 2> from = ToUnits(PlaceOf(check.point));
      chart_.errors.push_back({from[0],
                               from[1],
                               check.error_enu_m[0] / per_unit_m_,
                               check.error_enu_m[1] / per_unit_m_});
    }
  }

  void AddGraticule() {
    // What the page shows first: the block with its swaths in a window not much lower than wide.
    constexpr double kWindow = 0.65;
    MapBox seen = box_m_;
    for (const MapChart::Line& swath : chart_.swaths) {
      for (const auto& [east, north] : swath.places) {
        seen.Add({per_unit_m_ * east, per_unit_m_ * north});
      }
    }
    const double side_m = kWindow * SizeOf_m(seen);
    for (std::size_t k = 0; k < 2; ++k) {
      const double lacking_m = std::fmax(0.0, side_m - (seen.high_m[k] - seen.low_m[k]));
      seen.low_m[k] -= 0.5 * lacking_m;
      seen.high_m[k] += 0.5 * lacking_m;
    }
    chart_.graticule =
        GraticuleOf(result_.file.frame, plane_, seen, box_m_.Widened(1.2 * SizeOf_m(seen)));
    for (MapChart::Line& line : chart_.graticule) {
      for (std::array<double, 2>& place : line.places) place = ToUnits(place);
    }
  }

  const ResultFolder& result_;
  const files::ResultPoints& points_;
  const AccuracyFigures& accuracy_;
  MapPlane plane_;
  std::vector<std::uint32_t> placed_;
  MapBox box_m_;
  double per_unit_m_ = 1.0;
  MapChart chart_;
};

}  // namespace

BlockMap MapOf(const ResultFolder& result, const AccuracyFigures& accuracy) {
  return MapMaker(result, accuracy).Make();
}

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
  constexpr std::size_t kMaxPassRows = 300;
  const auto strips = StripsOf(result.file);
  for (std::size_t s = 0; s < std::min(strips.size(), kMaxPassRows); ++s) {
    const std::span<const StripStation> strip = strips[s];
    const files::ResultPass& pass = result.file.passes[strip.front().pass];
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
  if (strips.size() > kMaxPassRows) {
    table.note += fmt::format(" The first {} of {}.", kMaxPassRows, strips.size());
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
  if (weak.median_looks < all.median_looks) {
    facets.push_back(fmt::format(
        "have {:.0f} looks where {:.0f} are usual", weak.median_looks, all.median_looks));
  }
  if (weak.outside_control > all.outside_control + 0.2) {
    facets.push_back(fmt::format("lie to {} outside the control points, of all points {}",
                                 ShownPercent(weak.outside_control),
                                 ShownPercent(all.outside_control)));
  }
  if (facets.empty() || weak.points < 5) return "";
  std::string text = "The weakest twentieth of the points that are not control ";
  for (std::size_t i = 0; i < facets.size(); ++i) {
    text += (i == 0 ? "" : (i + 1 == facets.size() ? " and " : ", ")) + facets[i];
  }
  return text + ". ";
}

PageTable WeakestTable(const ResultFolder& result, const AccuracyFigures& accuracy) {
  const files::ResultPoints& points = result.file.points;
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
    std::vector<std::string> row{std::string(points.ids[i]), files::NameOf(points.role[i])};
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

namespace {

constexpr std::size_t kProfileBins = 24;
constexpr std::size_t kMinInBin = 3;
constexpr std::size_t kMaxDots = 1500;

/// Unit vector (east, north) across the direction most of the flight paths have; axes count, not
/// their sense, so angles are doubled.
std::array<double, 2> AcrossDirection(const ResultFolder& result, const MapPlane& plane) {
  double c = 0.0, s = 0.0;
  for (const std::span<const StripStation> strip : StripsOf(result.file)) {
    const auto first = plane.Place(strip.front().antenna_m);
    const auto last = plane.Place(strip.back().antenna_m);
    const double angle = std::atan2(last[1] - first[1], last[0] - first[0]);
    c += std::cos(2.0 * angle);
    s += std::sin(2.0 * angle);
  }
  const double along = 0.5 * std::atan2(s, c);
  std::array<double, 2> across = {-std::sin(along), std::cos(along)};
  // East or north counts positive.
  if (across[0] + across[1] < 0.0) across = {-across[0], -across[1]};
  return across;
}

double AlongAzimuth(const std::vector<SymmetricEnu>& q_m2, std::size_t point, double azimuth_rad) {
  if (q_m2.empty()) return kAbsent;
  const double s = std::sin(azimuth_rad), c = std::cos(azimuth_rad);
  const auto& [ee_m2, nn_m2, uu_m2, en_m2, eu_m2, nu_m2] = q_m2[point];
  return std::sqrt(s * s * ee_m2 + c * c * nn_m2 + 2.0 * s * c * en_m2);
}

/// By point: what is shown of one component.
struct Profile {
  std::vector<double> paper_m, paper_with_path_m, fixed_paths_m, whole_m;
};

struct Profiles {
  std::vector<double> x_km;
  std::vector<std::string> names;
  Profile across, up;
};

/// Points by number of looks: further looks gain what a median over all would hide.
struct LookClass {
  std::uint32_t least = 2, most = 2;
  [[nodiscard]] bool Has(std::uint32_t looks) const { return looks >= least && looks <= most; }
  [[nodiscard]] std::string Name() const {
    if (least == most) return fmt::format("{} look{}", least, least == 1 ? "" : "s");
    return fmt::format("{} looks or more", least);
  }
};
constexpr std::uint32_t kAnyNumber = std::numeric_limits<std::uint32_t>::max();
constexpr LookClass kLookClasses[] = {{1, 1}, {2, 2}, {3, 3}, {4, kAnyNumber}};
constexpr std::size_t kMinInClass = 10;

Profiles Collect(const ResultFolder& result, const LookClass& looks) {
  const files::ResultPoints& points = result.file.points;
  const PointResults& figures = points.results;
  const MapPlane plane(result);
  const std::array<double, 2> direction = AcrossDirection(result, plane);
  const double fallback_rad = std::atan2(direction[0], direction[1]);
  Profiles out;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    // A control point is known beforehand: it would say nothing of the geometry.
    if (!IsSolved(figures.status[i]) || points.role[i] == PointRole::kControl ||
        !looks.Has(figures.looks[i]) || std::isnan(SigmaOf(points, i, 0))) {
      continue;
    }
    const auto place = plane.Place(figures.position_m[i]);
    out.x_km.push_back((place[0] * direction[0] + place[1] * direction[1]) / 1000.0);
    out.names.emplace_back(points.ids[i]);
    const double leberl_rad = FigureOf(figures.leberl_across_azimuth_rad, i);
    const double azimuth_rad = std::isnan(leberl_rad) ? fallback_rad : leberl_rad;
    const double across_m = FigureOf(figures.sigma_leberl_across_m, i);
    const double up_m = FigureOf(figures.sigma_leberl_up_m, i);
    out.across.whole_m.push_back(AlongAzimuth(figures.covariance_m2, i, azimuth_rad));
    out.across.fixed_paths_m.push_back(
        AlongAzimuth(figures.fixed_path_covariance_m2, i, azimuth_rad));
    out.across.paper_m.push_back(across_m);
    out.across.paper_with_path_m.push_back(
        std::hypot(across_m, FigureOf(figures.sigma_leberl_path_across_m, i)));
    out.up.whole_m.push_back(SigmaOf(points, i, 2));
    out.up.fixed_paths_m.push_back(FixedPathSigmaOf(points, i, 2));
    out.up.paper_m.push_back(up_m);
    out.up.paper_with_path_m.push_back(
        std::hypot(up_m, FigureOf(figures.sigma_leberl_path_up_m, i)));
  }
  return out;
}

ChartSeries MedianLine(const std::string& label,
                       const std::string& style,
                       const std::string& color,
                       const std::vector<double>& x,
                       const std::vector<double>& values) {
  ChartSeries series{label, style, color, {}, {}, {}, {}, {}};
  for (const BinnedMedian& bin : MedianInBins(x, values, kProfileBins, kMinInBin)) {
    series.x.push_back(bin.x);
    series.y.push_back(bin.value);
  }
  return series;
}

PageFigure ProfileFigure(const Profiles& profiles,
                         const Profile& profile,
                         const std::string& id,
                         const std::string& title,
                         const std::string& whole) {
  XyChart chart;
  chart.x.label = "distance across the flight direction [km]";
  chart.y.label = "sigma [m]";
  chart.y.logarithmic = true;
  ChartSeries dots{whole + ", single points", "points", "pale", {}, {}, {}, {}, {}};
  for (const std::uint32_t i : SampleIndices(profiles.x_km.size(), kMaxDots)) {
    dots.x.push_back(profiles.x_km[i]);
    dots.y.push_back(profile.whole_m[i]);
    dots.names.push_back(profiles.names[i]);
  }
  chart.series.push_back(std::move(dots));
  const std::vector<double>& x = profiles.x_km;
  for (ChartSeries series :
       {MedianLine(
            "1979 paper, with priors of paths", "dash", "purple", x, profile.paper_with_path_m),
        MedianLine("1979 paper, range noise", "dash", "orange", x, profile.paper_m),
        MedianLine("rigorous intersection, paths exact", "line", "green", x, profile.fixed_paths_m),
        MedianLine(whole, "line", "blue", x, profile.whole_m)}) {
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  return {id, title, "", "half", ChartJson(id, chart)};
}

}  // namespace

PageSection ProfileSection(const ResultFolder& result) {
  PageSection section{"profiles", "Sigma across the flight direction", {}};
  const std::string whole =
      result.file.summary.command == "intersect" ? "rigorous intersection" : "whole block";
  std::vector<std::string> few;
  std::size_t shown = 0;
  for (const LookClass& looks : kLookClasses) {
    const Profiles profiles = Collect(result, looks);
    const std::size_t count = profiles.x_km.size();
    if (count == 0) continue;
    if (count < kMinInClass) {
      few.push_back(fmt::format("{} with {}", count, looks.Name()));
      continue;
    }
    ++shown;
    const std::string title = fmt::format(", {} ({} points)", looks.Name(), ReadableCount(count));
    PageFigures figures;
    figures.figures.push_back(ProfileFigure(profiles,
                                            profiles.across,
                                            fmt::format("profile-across-{}", looks.least),
                                            "Sigma across track" + title,
                                            whole));
    figures.figures.push_back(ProfileFigure(profiles,
                                            profiles.up,
                                            fmt::format("profile-up-{}", looks.least),
                                            "Sigma in height" + title,
                                            whole));
    section.items.emplace_back(std::move(figures));
  }
  if (shown == 0) {
    section.items.emplace_back(
        PageText{few.empty() ? "No standard deviations were computed, or all points are control."
                             : "There are too few points for profiles.",
                 "note"});
    return section;
  }
  std::string note =
      "Medians of the points in strips of equal distance, by number of looks, control points left "
      "out. The intersection takes the flight paths as exact and is what the 1979 closed form (Eq. "
      "25) approximates for the best pair of looks; what the block lies above it is what the "
      "flight paths add, what it lies below the closed form is gained by further looks.";
  for (std::size_t i = 0; i < few.size(); ++i) {
    note += (i == 0 ? " Not drawn, too few: " : ", ") + few[i] + (i + 1 == few.size() ? "." : "");
  }
  section.items.emplace_back(PageText{note, "note"});
  return section;
}

}  // namespace sarblock
