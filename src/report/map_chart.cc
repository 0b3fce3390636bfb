// SPDX-License-Identifier: Apache-2.0
#include "map_chart.h"

#include <algorithm>
#include <cmath>

#include "graticule.h"
#include "quality/covariance.h"
#include "statistics.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kMostPoints = 5000;
constexpr std::size_t kMostPasses = 80;
constexpr std::size_t kMostMarks = 600;  // control, check
constexpr std::size_t kMostErrors = 150;

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
  [[nodiscard]] std::array<double, 2> InUnits(const std::array<double, 2>& place_m) const {
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
    std::vector<std::uint32_t> shown;
    for (const std::uint32_t k : SampleIndices(placed_.size(), kMostPoints)) {
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
      chart_.points.push_back(InUnits(PlaceOf(i)));
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
      if (places.size() >= kMostMarks) continue;
      places.push_back(InUnits(PlaceOf(i)));
      (IsControl(i) ? chart_.control_names : chart_.check_names).emplace_back(points_.ids[i]);
    }
  }

  void AddEllipses() {
    for (const std::uint32_t k : SampleIndices(placed_.size(), kMostPoints)) {
      const std::uint32_t i = placed_[k];
      if (IsControl(i)) continue;
      const ErrorEllipse ellipse = EllipseOf(points_.results.covariance_m2[i]);
      if (!(ellipse.major_m > 0.0) || !std::isfinite(ellipse.major_m)) continue;
      const std::array<double, 2> place = InUnits(PlaceOf(i));
      chart_.ellipses.push_back({place[0],
                                 place[1],
                                 ellipse.major_m / per_unit_m_,
                                 ellipse.minor_m / per_unit_m_,
                                 ellipse.azimuth_rad});
    }
  }

  void AddErrors() {
    for (const CheckResult& check : points_.checks) {
      if (chart_.errors.size() >= kMostErrors) return;
      if (std::isnan(check.error_enu_m[0]) || std::isnan(check.error_enu_m[1])) continue;
      const std::array<double, 2> from = InUnits(PlaceOf(check.point));
      chart_.errors.push_back({from[0],
                               from[1],
                               check.error_enu_m[0] / per_unit_m_,
                               check.error_enu_m[1] / per_unit_m_});
    }
  }

  void AddGraticule() {
    // What the page shows first: the block with its swaths in a window not much lower than wide.
    constexpr double kWindow_1 = 0.65;
    MapBox seen = box_m_;
    for (const MapChart::Line& swath : chart_.swaths) {
      for (const auto& [east, north] : swath.places) {
        seen.Add({per_unit_m_ * east, per_unit_m_ * north});
      }
    }
    const double side_m = kWindow_1 * SizeOf_m(seen);
    for (std::size_t k = 0; k < 2; ++k) {
      const double lacking_m = std::fmax(0.0, side_m - (seen.high_m[k] - seen.low_m[k]));
      seen.low_m[k] -= 0.5 * lacking_m;
      seen.high_m[k] += 0.5 * lacking_m;
    }
    chart_.graticule =
        GraticuleOf(result_.file.frame, plane_, seen, box_m_.Widened(1.2 * SizeOf_m(seen)));
    for (MapChart::Line& line : chart_.graticule) {
      for (std::array<double, 2>& place : line.places) place = InUnits(place);
    }
  }

  const ResultFolder& result_;
  const ResultPoints& points_;
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

}  // namespace sarblock
