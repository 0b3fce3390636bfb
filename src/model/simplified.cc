// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/simplified.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "geometry/track_axes.h"

namespace sarblock {

FlightPath StraightenedPath(const Pass& pass) {
  const FlightPath& path = pass.path;
  if (path.IsStraight()) return path;
  constexpr int kSteps = 16;
  const double start_s = std::clamp(pass.start_s, path.start_s(), path.end_s());
  const double end_s = std::clamp(pass.end_s, path.start_s(), path.end_s());
  const double middle_s = 0.5 * (start_s + end_s);
  const double step_s = (end_s - start_s) / kSteps;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero(), moment_ms = Eigen::Vector3d::Zero();
  double moment_s2 = 0.0, mean_speed_mps = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double from_middle_s = (k - 0.5 * kSteps) * step_s;
    Motion motion;
    if (!path.Evaluate(std::clamp(middle_s + from_middle_s, start_s, end_s), &motion)) return path;
    mean_m += motion.position_m / (kSteps + 1);
    mean_speed_mps += motion.velocity_mps.norm() / (kSteps + 1);
    moment_ms += from_middle_s * motion.position_m;
    moment_s2 += from_middle_s * from_middle_s;
  }
  const Eigen::Vector3d velocity_mps = moment_ms / moment_s2;
  if (!(velocity_mps.norm() > 0.5 * mean_speed_mps)) return path;
  const Eigen::Vector3d first_m = mean_m + (path.start_s() - middle_s) * velocity_mps;
  const Eigen::Vector3d last_m = first_m + (path.end_s() - path.start_s()) * velocity_mps;
  return FlightPath(std::vector<StateVector>{{path.start_s(), first_m, velocity_mps},
                                             {path.end_s(), last_m, velocity_mps}});
}

Eigen::Matrix3d AxesInTheMiddle(const Frame& frame, const FlightPath& path, const Pass& pass) {
  const double middle_s =
      std::clamp(0.5 * (pass.start_s + pass.end_s), path.start_s(), path.end_s());
  Motion motion;
  if (!path.Evaluate(middle_s, &motion)) {
    return Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  return TrackAxesOf(frame, motion).axes_1;
}

}  // namespace sarblock
