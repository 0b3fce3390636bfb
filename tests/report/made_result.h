// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "report/shown_result.h"

namespace sarblock::test {

/// One point of a made result.
struct MadePoint {
  std::string id;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::array<double, 3> sigma_m{};
  std::array<double, 3> fixed_path_sigma_m{};
  double angle_deg = 10.0;
  std::uint32_t looks = 3;
  PointRole role = PointRole::kTie;
  bool solved = true;
};

inline void AddPoint(const MadePoint& point, files::ResultPoints* out) {
  const auto squares = [](const std::array<double, 3>& s) {
    return SymmetricEnu{s[0] * s[0], s[1] * s[1], s[2] * s[2], 0.0, 0.0, 0.0};
  };
  out->ids.Append(point.id);
  out->role.push_back(point.role);
  PointResults& results = out->results;
  results.status.push_back(point.solved ? PointStatus::kAdjusted : PointStatus::kTooFewLooks);
  results.position_m.push_back(point.position_m);
  results.covariance_m2.push_back(squares(point.sigma_m));
  results.fixed_path_covariance_m2.push_back(squares(point.fixed_path_sigma_m));
  results.intersection_rad.push_back(point.angle_deg * kRadPerDeg);
  results.redundancy.push_back(3.0);
  results.looks.push_back(point.looks);
}

inline ResultFolder MadeOf(const std::vector<MadePoint>& points) {
  files::ResultFile file;
  for (const MadePoint& point : points) AddPoint(point, &file.points);
  return Arrange("made", std::move(file));
}

/// An adjustment that was accepted: 100 points in a row, heights three times as weak as plan, the
/// flight paths with 75 percent of the variance of each height; the last five points are the
/// weakest, with two looks at a smaller angle, outside the three control points.
inline ResultFolder MadeResult() {
  files::ResultFile out;
  out.summary.command = "adjust";
  out.summary.block = "made";
  out.summary.status = "converged";
  out.summary.verdict = Verdict::kAccepted;
  out.summary.version = "0";
  out.summary.iterations = 5;
  out.summary.counts = {{"points", 100}, {"control_points", 3}, {"redundancy", 200}};
  out.summary.sigma0_squared = 1.1025;
  out.summary.chi_square = {{1.1025, 200.0, {162.0, 240.0}, true}, 0.95};
  for (int i = 0; i < 100; ++i) {
    MadePoint point;
    point.id = "P" + std::to_string(i);
    point.position_m = {1000.0 * i, 500.0 * (i % 2), 0.0};
    const double up_m = 3.0 + 0.01 * i;
    point.sigma_m = {1.0, 1.25, up_m};
    point.fixed_path_sigma_m = {0.5, 0.5, 0.5 * up_m};
    if (i == 0 || i == 1 || i == 94) point.role = PointRole::kControl;
    if (i >= 95) {
      point.angle_deg = 4.0;
      point.looks = 2;
      point.sigma_m[2] = 9.0 + i;
    }
    AddPoint(point, &out.points);
  }
  return Arrange("made", std::move(out));
}

}  // namespace sarblock::test
