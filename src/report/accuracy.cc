// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/units.h"
#include "sarblock/geodesy/frame.h"

#include <algorithm>
#include <cmath>

#include "statistics.h"
#include "verdict.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

bool HasSigma(const ReportPoints& points, std::size_t i) {
  return points.solved[i] != 0 && !std::isnan(points.sigma_m[i][0]);
}

ConvexHull HullOfControl(const ReportPoints& points, const MapPlane& plane) {
  std::vector<std::array<double, 2>> places_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.role[i] == ReportRole::kControl)
      places_m.push_back(plane.Place(points.position_m[i]));
  }
  return ConvexHull(std::move(places_m));
}

AccuracyFigures::Group DescribeGroup(const ReportPoints& points,
                                     const std::vector<std::uint32_t>& members,
                                     const ConvexHull& hull,
                                     const MapPlane& plane) {
  AccuracyFigures::Group out;
  out.points = members.size();
  std::vector<double> angle_deg, looks;
  std::size_t outside = 0;
  for (const std::uint32_t i : members) {
    angle_deg.push_back(static_cast<double>(points.intersection_deg[i]));
    looks.push_back(points.looks[i]);
    const std::array<double, 2> place = plane.Place(points.position_m[i]);
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

std::array<const char*, 3> AxisNames(const ReportSummary& summary) {
  if (summary.geocentric) return {"east", "north", "up"};
  return {"x", "y", "z"};
}

MapPlane::MapPlane(const ResultFolder& result) {
  if (!result.summary.geocentric) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const std::array<double, 3>& p : result.points.position_m) {
    if (std::isnan(p[0])) continue;
    sum += Eigen::Vector3d(p[0], p[1], p[2]);
    count += 1.0;
  }
  if (count == 0.0 || !(result.summary.a_m > 0.0)) return;
  const Frame frame = Frame::Geocentric({"", result.summary.a_m, result.summary.flattening});
  const Eigen::Vector3d middle_m = sum / count;
  const Eigen::Matrix3d enu = frame.EnuFromFrame(middle_m);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    origin_m_[k] = middle_m[axis];
    axes_1_[0][k] = enu(0, axis);
    axes_1_[1][k] = enu(1, axis);
  }
  const Geodetic place = frame.GeodeticFromFrame(middle_m);
  middle_ = fmt::format("{:.4f}, {:.4f}", place.lat_rad * kDegPerRad, place.lon_rad * kDegPerRad);
}

std::array<double, 2> MapPlane::Place(const std::array<double, 3>& position_m) const {
  std::array<double, 2> out{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (std::size_t k = 0; k < 3; ++k) {
      out[axis] += axes_1_[axis][k] * (position_m[k] - origin_m_[k]);
    }
  }
  return out;
}

AccuracyFigures DescribeAccuracy(const ResultFolder& result) {
  const ReportPoints& points = result.points;
  AccuracyFigures out;
  std::vector<std::uint32_t> members;
  std::vector<double> angle_deg;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (points.solved[i] != 0) angle_deg.push_back(static_cast<double>(points.intersection_deg[i]));
    if (HasSigma(points, i)) members.push_back(i);
  }
  out.points = members.size();
  out.median_intersection_deg = SampleQuantile(std::move(angle_deg), 0.5);
  if (members.empty()) return out;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> sigma_m;
    std::uint32_t largest = members.front();
    for (const std::uint32_t i : members) {
      sigma_m.push_back(static_cast<double>(points.sigma_m[i][k]));
      if (points.sigma_m[i][k] > points.sigma_m[largest][k]) largest = i;
    }
    constexpr std::array kParts{0.5, 0.95};
    const std::vector<double> parts = SampleQuantiles(std::move(sigma_m), kParts);
    out.median_m[k] = parts[0];
    out.most_m[k] = parts[1];
    out.largest_m[k] = static_cast<double>(points.sigma_m[largest][k]);
    out.largest_point[k] = std::string(points.ids[largest]);
  }
  out.weakest = static_cast<int>(std::max_element(out.median_m.begin(), out.median_m.end()) -
                                 out.median_m.begin());
  const auto weak = static_cast<std::size_t>(out.weakest);
  std::vector<double> parts;
  for (const std::uint32_t i : members) {
    const auto held = static_cast<double>(points.sigma_held_m[i][weak]);
    const auto whole = static_cast<double>(points.sigma_m[i][weak]);
    parts.push_back(1.0 - held * held / (whole * whole));
  }
  out.path_part_1 = SampleQuantile(std::move(parts), 0.5);
  const MapPlane plane(result);
  const ConvexHull hull = HullOfControl(points, plane);
  out.all = DescribeGroup(points, members, hull, plane);
  const std::size_t twentieth = std::max<std::size_t>(1, members.size() / 20);
  std::partial_sort(members.begin(),
                    members.begin() + static_cast<std::ptrdiff_t>(twentieth),
                    members.end(),
                    [&](std::uint32_t a, std::uint32_t b) {
                      return points.sigma_m[a][weak] > points.sigma_m[b][weak];
                    });
  members.resize(twentieth);
  out.weak = DescribeGroup(points, members, hull, plane);
  return out;
}

}  // namespace sarblock
