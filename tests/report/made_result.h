// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "report/result_folder.h"

namespace sarblock::test {

/// One point of a made result.
struct MadePoint {
  std::string id;
  std::array<double, 3> position_m{};
  std::array<float, 3> sigma_m{};
  std::array<float, 3> held_m{};
  float angle_deg = 10.0F;
  int looks = 3;
  ReportRole role = ReportRole::kTie;
  bool solved = true;
};

inline void AddPoint(const MadePoint& point, ReportPoints* out) {
  out->ids.Append(point.id);
  out->role.push_back(point.role);
  out->solved.push_back(point.solved ? 1 : 0);
  out->position_m.push_back(point.position_m);
  out->sigma_m.push_back(point.sigma_m);
  out->cov_en_m2.push_back(0.0F);
  out->sigma_held_m.push_back(point.held_m);
  out->cov_held_en_m2.push_back(0.0F);
  out->leberl_m.push_back({});
  out->leberl_azimuth_deg.push_back(90.0F);
  out->intersection_deg.push_back(point.angle_deg);
  out->redundancy.push_back(3.0F);
  out->looks.push_back(static_cast<std::uint16_t>(point.looks));
  if (!point.solved) ++out->unsolved_count;
}

/// An adjustment that was accepted: 100 points in a row, heights three times as weak as plan, the
/// flight paths with 75 percent of the variance of each height; the last five points are the
/// weakest, with two looks at a smaller angle, outside the three control points.
inline ResultFolder MadeResult() {
  ResultFolder out;
  out.path = "made";
  out.summary.command = "adjust";
  out.summary.block = "made";
  out.summary.status = "converged";
  out.summary.accepted = true;
  out.summary.version = "0";
  out.summary.iterations_1 = 5;
  out.summary.counts = {{"points", 100}, {"control_points", 3}, {"redundancy", 200}};
  out.summary.test = {1.1025, 200.0, 162.0, 240.0, 0.95, true};
  for (int i = 0; i < 100; ++i) {
    MadePoint point;
    point.id = "P" + std::to_string(i);
    point.position_m = {1000.0 * i, 500.0 * (i % 2), 0.0};
    const float up_m = 3.0F + 0.01F * static_cast<float>(i);
    point.sigma_m = {1.0F, 1.25F, up_m};
    point.held_m = {0.5F, 0.5F, 0.5F * up_m};
    if (i == 0 || i == 1 || i == 94) point.role = ReportRole::kControl;
    if (i >= 95) {
      point.angle_deg = 4.0F;
      point.looks = 2;
      point.sigma_m[2] = 9.0F + static_cast<float>(i);
    }
    AddPoint(point, &out.points);
  }
  return out;
}

}  // namespace sarblock::test
