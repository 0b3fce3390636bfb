// SPDX-License-Identifier: Apache-2.0
#include "circle_height.h"

#include <algorithm>
#include <cmath>

#include "circle.h"
#include <Eigen/Geometry>

namespace sarblock::internal {
namespace {

constexpr int kMaxNewton = 60;

// Height above the reference surface along a circle of one look, with two derivatives by the circle
// parameter. Coordinates relative to the antenna.
class HeightAlong {
 public:
  HeightAlong(const Circle& circle, const Frame& frame, const Eigen::Vector3d& origin_m)
      : circle_(circle), basis_(CircleBasis::Of(circle)), frame_(frame), origin_m_(origin_m) {}

  struct Value {
    Eigen::Vector3d point_m;  // relative to the antenna
    double height_m = 0.0;
    double first_m = 0.0;   // by phi
    double second_m = 0.0;  // by phi twice
  };
  [[nodiscard]] Value At(double phi_rad) const {
    Value value;
    value.point_m = PointOn(circle_, basis_, phi_rad);
    const Eigen::Vector3d radial_m = value.point_m - circle_.centre_m;
    const Eigen::Vector3d tangent_m = circle_.axis_1.cross(radial_m);
    const Vertical vertical = frame_.VerticalAt(origin_m_ + value.point_m);
    value.height_m = vertical.height_m;
    value.first_m = vertical.up_1.dot(tangent_m);
    value.second_m = -vertical.up_1.dot(radial_m) + tangent_m.dot(vertical.dup_dp * tangent_m);
    return value;
  }
  [[nodiscard]] const CircleBasis& basis() const { return basis_; }

 private:
  Circle circle_;
  CircleBasis basis_;
  const Frame& frame_;
  Eigen::Vector3d origin_m_;
};

// Parameter of the lowest (sign -1) or highest (+1) point next to `phi_rad`.
double Extremum(const HeightAlong& along, double sign, double phi_rad) {
  for (int i = 0; i < kMaxNewton; ++i) {
    const HeightAlong::Value value = along.At(phi_rad);
    if (!(value.second_m * sign < 0.0)) {
      break;  // no extremum of this kind nearby: keep the place reached
    }
    const double step_rad = -value.first_m / value.second_m;
    phi_rad += std::clamp(step_rad, -0.3, 0.3);
    if (std::abs(step_rad) < 1e-14) {
      break;
    }
  }
  return phi_rad;
}

// Newton between a parameter below and one above the wanted height, halving where it leaves them.
double Root(const HeightAlong& along, double height_m, double low_rad, double high_rad) {
  double phi_rad = 0.5 * (low_rad + high_rad);
  for (int i = 0; i < kMaxNewton; ++i) {
    const HeightAlong::Value value = along.At(phi_rad);
    const double error_m = value.height_m - height_m;
    (error_m < 0.0 ? low_rad : high_rad) = phi_rad;
    const double newton_rad = phi_rad - error_m / value.first_m;
    const bool inside =
        std::min(low_rad, high_rad) <= newton_rad && newton_rad <= std::max(low_rad, high_rad);
    const double next_rad = inside ? newton_rad : 0.5 * (low_rad + high_rad);
    const double moved_rad = std::abs(next_rad - phi_rad);
    phi_rad = next_rad;
    if (moved_rad < 1e-15) {
      break;
    }
  }
  return phi_rad;
}

}  // namespace

Intersection CircleAtHeight(const Sight& sight, const Frame& frame, double height_m) {
  const Circle circle = Circle::Of(sight, sight.antenna_m);
  const HeightAlong along(circle, frame, sight.antenna_m);
  const Eigen::Vector3d up_1 = frame.VerticalAt(sight.antenna_m).up_1;
  const CircleBasis& basis = along.basis();

  Intersection result;
  result.outcome = IntersectionOutcome::kCirclesDoNotMeet;
  const double top_rad = std::atan2(up_1.dot(basis.e2), up_1.dot(basis.e1));
  const double pi_rad = std::atan2(0.0, -1.0);
  const double lowest_rad = Extremum(along, -1.0, top_rad + pi_rad);
  double highest_rad = Extremum(along, 1.0, top_rad);
  if (along.At(lowest_rad).height_m > height_m || along.At(highest_rad).height_m < height_m) {
    return result;
  }
  // One root on either way up from the lowest point; the look side tells which.
  highest_rad = lowest_rad + std::remainder(highest_rad - lowest_rad, 2.0 * pi_rad);
  const double other_rad = highest_rad + (highest_rad > lowest_rad ? -2.0 : 2.0) * pi_rad;
  const Eigen::Vector3d towards = sight.side * up_1.cross(circle.axis_1);
  double best_side_m = -1.0;
  for (const double end_rad : {highest_rad, other_rad}) {
    const HeightAlong::Value at = along.At(Root(along, height_m, lowest_rad, end_rad));
    const double side_m = towards.dot(at.point_m);
    if (side_m > best_side_m || result.outcome != IntersectionOutcome::kDetermined) {
      best_side_m = side_m;
      result.position_m = sight.antenna_m + at.point_m;
      result.outcome = IntersectionOutcome::kDetermined;
    }
  }
  return result;
}

}  // namespace sarblock::internal
