// SPDX-License-Identifier: Apache-2.0
#include "visibility.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/track_axes.h"

namespace sarblock {
namespace {

/// The quick test of the ends leaves this much to the exact one.
constexpr double kMargin_m = 1.0;

bool InSwath(const Frame& frame,
             const NominalPass& planned,
             const Motion& motion,
             const Eigen::Vector3d& p_m) {
  const Eigen::Matrix3d axes = TrackAxesOf(frame, motion).axes_1;
  const Eigen::Vector3d d = p_m - motion.position_m;
  const double across_m = d.dot(axes.col(1)) * static_cast<double>(planned.pass.side);
  if (!(across_m > 0.0)) return false;
  double value = across_m;
  if (planned.swath.kind == SwathKind::kSlantRange) value = d.norm();
  if (planned.swath.kind == SwathKind::kLookAngle) {
    value = std::atan2(across_m, -d.dot(axes.col(2)));
  }
  return planned.swath.limits[0] <= value && value <= planned.swath.limits[1];
}

/// Time of the planned look at p, or nothing where the strip does not show it.
std::optional<double> PlannedTime(const Frame& frame,
                                  const NominalPass& planned,
                                  const Eigen::Vector3d& p_m) {
  const Pass& pass = planned.pass;
  const std::optional<double> time_s = FindConeTime(
      pass.path, p_m, Cone{.squint_rad = planned.squint_rad}, pass.start_s, pass.end_s);
  if (!time_s) return std::nullopt;
  const std::optional<Motion> motion = pass.path.At(*time_s);
  if (!motion || !InSwath(frame, planned, *motion, p_m)) return std::nullopt;
  return time_s;
}

Motion MotionAt(const Pass& pass, double time_s) {
  const std::optional<Motion> motion = pass.path.At(time_s);
  if (!motion) throw InputError(pass.id, "the strip lies outside its path");
  return *motion;
}

}  // namespace

std::size_t Visibility::HashCell::operator()(const Cell& cell) const {
  const auto u = [](std::int64_t value) { return static_cast<std::uint64_t>(value); };
  return MixStream(MixStream(u(cell[0]), u(cell[1])), u(cell[2]));
}

Visibility::Visibility(const Frame& frame, const std::vector<NominalPass>& planned)
    : frame_(frame), planned_(planned) {
  double farthest_m = 0.0;
  for (const NominalPass& pass : planned) {
    const Pass& p = pass.pass;
    Reach reach;
    reach.middle_m = MotionAt(p, 0.5 * (p.start_s + p.end_s)).position_m;
    reach.square_m2 = pass.reach_m * pass.reach_m;
    reach.sine_of_squint_1 = std::sin(pass.squint_rad);
    const std::array<double, 2> times_s = {p.start_s, p.end_s};
    for (std::size_t end = 0; end < 2; ++end) {
      const Motion motion = MotionAt(p, times_s[end]);
      reach.ends[end] = {motion.position_m, motion.velocity_mps.normalized()};
    }
    reaches_.push_back(reach);
    farthest_m = std::max(farthest_m, pass.reach_m);
  }
  cell_m_ = std::max(1.0, 0.5 * farthest_m);
  for (std::size_t pass = 0; pass < planned.size(); ++pass) {
    const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(planned[pass].reach_m);
    const Cell low = CellOf(reaches_[pass].middle_m - reach_m);
    const Cell high = CellOf(reaches_[pass].middle_m + reach_m);
    for (Cell cell = low; cell[0] <= high[0]; ++cell[0]) {
      for (cell[1] = low[1]; cell[1] <= high[1]; ++cell[1]) {
        for (cell[2] = low[2]; cell[2] <= high[2]; ++cell[2]) {
          passes_of_[cell].push_back(static_cast<std::uint32_t>(pass));
        }
      }
    }
  }
}

Visibility::Cell Visibility::CellOf(const Eigen::Vector3d& p_m) const {
  Cell cell;
  for (int axis = 0; axis < 3; ++axis) {
    cell[static_cast<std::size_t>(axis)] =
        static_cast<std::int64_t>(std::floor(p_m[axis] / cell_m_));
  }
  return cell;
}

bool Visibility::MayShow(const Reach& reach, const Eigen::Vector3d& p_m) const {
  if ((p_m - reach.middle_m).squaredNorm() > reach.square_m2) return false;
  // The cone error falls along the path: it is not negative at the start, nor positive at the end.
  const Eigen::Vector3d from_start_m = p_m - reach.ends[0].position_m;
  const Eigen::Vector3d from_end_m = p_m - reach.ends[1].position_m;
  const double sine_1 = reach.sine_of_squint_1;
  const double lean_start_m = sine_1 == 0.0 ? 0.0 : from_start_m.norm() * sine_1;
  const double lean_end_m = sine_1 == 0.0 ? 0.0 : from_end_m.norm() * sine_1;
  return from_start_m.dot(reach.ends[0].ahead_1) - lean_start_m >= -kMargin_m &&
         from_end_m.dot(reach.ends[1].ahead_1) - lean_end_m <= kMargin_m;
}

void Visibility::LooksAt(const Eigen::Vector3d& p_m, std::vector<PlannedLook>* looks) const {
  looks->clear();
  const auto found = passes_of_.find(CellOf(p_m));
  if (found == passes_of_.end()) return;
  for (const std::uint32_t pass : found->second) {
    if (!MayShow(reaches_[pass], p_m)) continue;
    if (const auto time_s = PlannedTime(frame_, planned_[pass], p_m)) {
      looks->push_back({pass, *time_s});
    }
  }
}

}  // namespace sarblock
