// SPDX-License-Identifier: Apache-2.0
#include "accuracy.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>

#include "statistics.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

bool HasSigma(const ResultPoints& points, std::size_t i) {
  return IsSolved(points.results.status[i]) && !std::isnan(SigmaOf(points, i, 0));
}

bool IsFree(const ResultPoints& points, std::size_t i) {
  return HasSigma(points, i) && points.role[i] != PointRole::kControl &&
         points.results.looks[i] > 1;
}

/// See AccuracyFigures::along_track_1.
double AlongTrack_1(const ResultFolder& result, const MapPlane& plane, std::size_t axis) {
  if (axis == 2) return 0.0;
  const ResultLooks& looks = result.file.looks;
  std::vector<double> weight(result.file.passes.size(), 0.0);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks.rejected[i] == 0 && IsFree(result.file.points, looks.point[i])) {
      weight[looks.pass[i]] += 1.0;
    }
  }
  double sum = 0.0, weights = 0.0;
  for (const std::span<const StripStation> strip : StripsOf(result.file)) {
    const auto first = plane.Place(strip.front().antenna_m);
    const auto last = plane.Place(strip.back().antenna_m);
    const double east_m = last[0] - first[0], north_m = last[1] - first[1];
    const double length2_m2 = east_m * east_m + north_m * north_m;
    if (!(length2_m2 > 0.0)) continue;
    const double along_m = axis == 0 ? east_m : north_m;
    sum += weight[strip.front().pass] * along_m * along_m / length2_m2;
    weights += weight[strip.front().pass];
  }
  return weights > 0.0 ? sum / weights : kAbsent;
}

ConvexHull HullOfControl(const ResultPoints& points, const MapPlane& plane) {
  std::vector<std::array<double, 2>> places_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.role[i] == PointRole::kControl) {
      places_m.push_back(plane.Place(points.results.position_m[i]));
    }
  }
  return ConvexHull(std::move(places_m));
}

AccuracyFigures::Group DescribeGroup(const ResultPoints& points,
                                     const std::vector<std::uint32_t>& members,
                                     const ConvexHull& hull,
                                     const MapPlane& plane) {
  AccuracyFigures::Group out;
  out.points = members.size();
  std::vector<double> angle_deg, looks;
  std::size_t outside = 0;
  for (const std::uint32_t i : members) {
    angle_deg.push_back(IntersectionOf_deg(points, i));
    looks.push_back(points.results.looks[i]);
    const std::array<double, 2> place = plane.Place(points.results.position_m[i]);
    if (!hull.Contains(place[0], place[1])) ++outside;
  }
  out.median_intersection_deg = SampleQuantile(std::move(angle_deg), 0.5);
  out.median_looks_1 = SampleQuantile(std::move(looks), 0.5);
  if (hull.HasArea() && !members.empty()) {
    out.outside_control_1 = static_cast<double>(outside) / static_cast<double>(members.size());
  }
  return out;
}

}  // namespace

std::array<const char*, 3> AxisNames(const Frame& frame) {
  if (frame.kind() == FrameKind::kGeocentric) return {"east", "north", "up"};
  return {"x", "y", "z"};
}

MapPlane::MapPlane(const ResultFolder& result) {
  const Frame& frame = result.file.frame;
  if (frame.kind() != FrameKind::kGeocentric) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const Eigen::Vector3d& p : result.file.points.results.position_m) {
    if (std::isnan(p[0])) continue;
    sum += p;
    count += 1.0;
  }
  if (count == 0.0) return;
  origin_m_ = sum / count;
  axes_1_ = frame.EnuFromFrame(origin_m_);
  const Geodetic place = frame.GeodeticFromFrame(origin_m_);
  middle_ = fmt::format("{:.4f}, {:.4f}", place.lat_rad * kDegPerRad, place.lon_rad * kDegPerRad);
}

std::array<double, 2> MapPlane::Place(const Eigen::Vector3d& position_m) const {
  const Eigen::Vector3d place_m = axes_1_ * (position_m - origin_m_);
  return {place_m[0], place_m[1]};
}

AccuracyFigures DescribeAccuracy(const ResultFolder& result) {
  const ResultPoints& points = result.file.points;
  AccuracyFigures out;
  std::vector<std::uint32_t> members, free;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (HasSigma(points, i)) members.push_back(i);
    if (IsFree(points, i)) free.push_back(i);
  }
  out.points = members.size();
  out.free_points = free.size();
  if (members.empty()) return out;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> sigma_m;
    std::uint32_t largest = members.front();
    for (const std::uint32_t i : members) {
      sigma_m.push_back(SigmaOf(points, i, k));
      if (SigmaOf(points, i, k) > SigmaOf(points, largest, k)) largest = i;
    }
    constexpr std::array kParts{0.5, 0.95};
    const std::vector<double> parts = SampleQuantiles(std::move(sigma_m), kParts);
    out.median_m[k] = parts[0];
    out.most_m[k] = parts[1];
    out.largest_m[k] = SigmaOf(points, largest, k);
    out.largest_point[k] = std::string(points.ids[largest]);
  }
  out.weakest = static_cast<int>(std::max_element(out.median_m.begin(), out.median_m.end()) -
                                 out.median_m.begin());
  if (free.empty()) return out;
  std::array<double, 3> free_median_m{};
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> sigma_m;
    for (const std::uint32_t i : free) sigma_m.push_back(SigmaOf(points, i, k));
    free_median_m[k] = SampleQuantile(std::move(sigma_m), 0.5);
  }
  out.weakest = static_cast<int>(std::max_element(free_median_m.begin(), free_median_m.end()) -
                                 free_median_m.begin());
  const auto weak = static_cast<std::size_t>(out.weakest);
  std::vector<double> parts;
  for (const std::uint32_t i : free) {
    const double looks_m = FixedPathSigmaOf(points, i, weak), whole_m = SigmaOf(points, i, weak);
    parts.push_back(1.0 - looks_m * looks_m / (whole_m * whole_m));
  }
  out.path_part_1 = SampleQuantile(std::move(parts), 0.5);
  const MapPlane plane(result);
  out.along_track_1 = AlongTrack_1(result, plane, weak);
  const ConvexHull hull = HullOfControl(points, plane);
  out.all = DescribeGroup(points, free, hull, plane);
  out.median_intersection_deg = out.all.median_intersection_deg;
  const std::size_t twentieth = std::max<std::size_t>(1, free.size() / 20);
  std::partial_sort(free.begin(),
                    free.begin() + static_cast<std::ptrdiff_t>(twentieth),
                    free.end(),
                    [&](std::uint32_t a, std::uint32_t b) {
                      return SigmaOf(points, a, weak) > SigmaOf(points, b, weak);
                    });
  free.resize(twentieth);
  out.weak = DescribeGroup(points, free, hull, plane);
  return out;
}

}  // namespace sarblock
