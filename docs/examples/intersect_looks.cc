// SPDX-License-Identifier: Apache-2.0
// Two looks at one point, intersected; and two from one flight line, which are no stereo.
// docs/api.md explains it.
#include <array>
#include <cmath>
#include <cstdio>

#include <sarblock/geometry/intersection.h>

int main() {
  // [sights]
  const Eigen::Vector3d point_m(1200.0, 9500.0, 350.0);
  const sarblock::Frame frame = sarblock::Frame::Local();
  std::array<sarblock::FixedPathLook, 2> observations;
  for (int i = 0; i < 2; ++i) {
    // Flight along +x; the antenna of a zero-Doppler look is abeam of the point.
    observations[i].antenna_m = {point_m.x(), 4000.0 * i, 6000.0};
    observations[i].velocity_mps = {150.0, 0.0, 0.0};
    observations[i].side = +1;  // left of the flight
    observations[i].range_m = (point_m - observations[i].antenna_m).norm();
    observations[i].range_sigma_m = 0.5;
    observations[i].azimuth_sigma = 0.5;
  }
  const sarblock::Intersection met = sarblock::Intersect(observations, frame);
  // [sights]
  const Eigen::Vector3d sigma_m = met.covariance_m2.diagonal().cwiseSqrt();
  std::printf("%s: %.3f %.3f %.3f m\n",
              sarblock::NameOf(met.outcome),
              met.position_m.x(),
              met.position_m.y(),
              met.position_m.z());
  std::printf("sigma %.3f %.3f %.3f m, intersection angle %.2f degrees\n",
              sigma_m.x(),
              sigma_m.y(),
              sigma_m.z(),
              met.intersection_rad * 180.0 / 3.14159265358979);

  // [one-flight]
  // The same line of flight, 20 degrees forward and backward.
  for (int i = 0; i < 2; ++i) {
    const double squint_rad = (i == 0 ? 20.0 : -20.0) * 3.14159265358979 / 180.0;
    const double abeam_m = std::hypot(point_m.y(), 6000.0 - point_m.z());
    observations[i].antenna_m = {point_m.x() - abeam_m * std::tan(squint_rad), 0.0, 6000.0};
    observations[i].range_m = abeam_m / std::cos(squint_rad);
    observations[i].cone.squint_rad = squint_rad;
  }
  const sarblock::Intersection none = sarblock::Intersect(observations, frame);
  // [one-flight]
  std::printf("%s: %s\n", sarblock::NameOf(none.outcome), sarblock::Explain(none.outcome));

  return met.outcome == sarblock::IntersectionOutcome::kDetermined &&
                 (met.position_m - point_m).norm() < 1e-6 &&
                 none.outcome == sarblock::IntersectionOutcome::kCirclesCoincide
             ? 0
             : 1;
}
