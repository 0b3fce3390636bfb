// SPDX-License-Identifier: Apache-2.0
#include "circle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace sarblock::internal {
namespace {

// Multiple of the combined standard deviation of two looks within which circles are one circle: the
// two-sided normal quantile at a probability of 1e-6, rounded up.
constexpr double kSameWithinSigmas = 5.0;
// Circles whose equation varies by less than this part of the radius are concentric: rounding.
constexpr double kConcentricPart = 1e-12;
constexpr std::size_t kMaxCirclesPaired = 8;

// Standard deviation of a circle's place along its axis by the azimuth error.
double AzimuthSigma_m(const FixedPathLook& observation) {
  return observation.azimuth_in_seconds && !observation.exact_time
             ? observation.azimuth_sigma * observation.velocity_mps.norm()
             : observation.azimuth_sigma;
}

// Variance of a circle's centre along its axis: the azimuth error and the range error's share.
double AlongVariance_m2(const FixedPathLook& observation, const Circle& circle) {
  const double azimuth_sigma_m = AzimuthSigma_m(observation);
  const double range_share_m = observation.range_sigma_m * circle.along_m / circle.range_m;
  return azimuth_sigma_m * azimuth_sigma_m + range_share_m * range_share_m;
}

// One equation of look 2 along circle 1: amplitude cos(phi - phi0) = constant, both in metres.
struct CutEquation {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // its part in the plane of circle 1 counts
  double amplitude_m = 0.0;
  double constant_m = 0.0;
  double sigma_m = 1.0;
  double score = -std::numeric_limits<double>::infinity();
};

void Score(const Circle& first, double sigma_m, CutEquation* cut) {
  cut->sigma_m = sigma_m;
  const double inside = (cut->amplitude_m - cut->constant_m) * (cut->amplitude_m + cut->constant_m);
  // Positive: change of the equation per metre along circle 1, in standard deviations, at the
  // solution. Negative where there is none: the cut that varies most still locates the point
  // best. One that does not vary at all (concentric circles) is the last resort.
  if (inside > 0.0) {
    cut->score = std::sqrt(inside) / (first.radius_m * sigma_m);
  } else if (cut->amplitude_m > kConcentricPart * first.radius_m) {
    cut->score = -sigma_m / cut->amplitude_m;
  } else {
    cut->score = std::numeric_limits<double>::lowest();
  }
}

// docs/theory/intersection.md, eq. (2) and (3).
CutEquation BestCut(const Circle& first,
                    const Circle& second,
                    const FixedPathLook& second_observation) {
  const Eigen::Vector3d offset_m = first.centre_m - second.antenna_m;
  CutEquation sphere;
  sphere.direction = offset_m * (first.radius_m / second.range_m);
  sphere.amplitude_m = first.axis.cross(sphere.direction).norm();
  sphere.constant_m = ((second.range_m - first.radius_m) * (second.range_m + first.radius_m) -
                       offset_m.squaredNorm()) /
                      (2.0 * second.range_m);
  Score(first, second_observation.range_sigma_m, &sphere);

  CutEquation plane;
  plane.direction = second.axis * first.radius_m;
  plane.amplitude_m = first.axis.cross(plane.direction).norm();
  plane.constant_m = second.along_m - second.axis.dot(offset_m);
  Score(first, AzimuthSigma_m(second_observation), &plane);
  return plane.score > sphere.score ? plane : sphere;
}

struct BestPair {
  Circle circle;
  std::size_t partner = 0;
  CutEquation cut;
};

void Offer(std::span<const FixedPathLook> observations,
           const Eigen::Vector3d& origin_m,
           std::size_t i,
           std::size_t k,
           BestPair* best) {
  const Circle first = Circle::From(observations[i], origin_m);
  const CutEquation cut = BestCut(first, Circle::From(observations[k], origin_m), observations[k]);
  if (cut.score > best->cut.score) {
    *best = {first, k, cut};
  }
}

}  // namespace

Circle Circle::From(const FixedPathLook& observation, const Eigen::Vector3d& origin_m) {
  const double speed_mps = observation.velocity_mps.norm();
  const double sin_tau = observation.cone.Sine(speed_mps);
  Circle circle;
  circle.antenna_m = observation.antenna_m - origin_m;
  circle.axis = observation.velocity_mps / speed_mps;
  circle.range_m = observation.range_m;
  circle.along_m = observation.range_m * sin_tau;
  circle.centre_m = circle.antenna_m + circle.along_m * circle.axis;
  circle.radius_m = observation.range_m * std::sqrt((1.0 - sin_tau) * (1.0 + sin_tau));
  return circle;
}

CircleBasis CircleBasis::From(const Circle& circle) {
  CircleBasis basis;
  basis.e1 = circle.axis.unitOrthogonal();
  basis.e2 = circle.axis.cross(basis.e1);
  return basis;
}

Eigen::Vector3d PointOn(const Circle& circle, const CircleBasis& basis, double phi_rad) {
  return circle.centre_m +
         circle.radius_m * (std::cos(phi_rad) * basis.e1 + std::sin(phi_rad) * basis.e2);
}

CosineRoots SolveCosine(double a, double b, double c) {
  CosineRoots roots;
  roots.middle_rad = std::atan2(b, a);
  // atan2 of (sine, cosine) keeps the digits that acos would lose next to the touching point.
  const double amplitude = std::hypot(a, b);
  const double inside = (amplitude - c) * (amplitude + c);
  roots.half_rad = std::atan2(std::sqrt(std::max(inside, 0.0)), c);
  return roots;
}

Starts ClosedStarts(std::span<const FixedPathLook> observations,
                    const Eigen::Vector3d& origin_m,
                    const Eigen::Vector3d& up) {
  BestPair best;
  const std::size_t n = observations.size();
  if (n <= kMaxCirclesPaired) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = i + 1; k < n; ++k) {
        Offer(observations, origin_m, i, k, &best);
      }
    }
  } else {
    for (std::size_t k = 1; k < n; ++k) {
      Offer(observations, origin_m, 0, k, &best);
    }
    const std::size_t partner = best.partner;
    for (std::size_t k = 0; k < n; ++k) {
      if (k != partner) {
        Offer(observations, origin_m, partner, k, &best);
      }
    }
  }

  Starts starts;
  const Circle& circle = best.circle;
  if (best.cut.amplitude_m <= kConcentricPart * circle.radius_m) {
    // Every point of the circle serves alike: the one 45 degrees down on the look side.
    const Eigen::Vector3d across = up.cross(circle.axis);
    const Eigen::Vector3d upward = circle.axis.cross(across);
    const Eigen::Vector3d direction = observations[0].side * across - upward;
    starts.point_m[0] = circle.centre_m + circle.radius_m * direction.stableNormalized();
    starts.count = 1;
    return starts;
  }
  const CircleBasis basis = CircleBasis::From(circle);
  // Circles that just miss each other may do so by noise: the starts are then the two solutions of
  // a cut moved inwards by that much, so that neither side of the touching point is forgotten.
  const double inner_m = std::max(best.cut.amplitude_m - kSameWithinSigmas * best.cut.sigma_m, 0.0);
  const double constant_m = std::abs(best.cut.constant_m) < best.cut.amplitude_m
                                ? best.cut.constant_m
                                : std::copysign(inner_m, best.cut.constant_m);
  const CosineRoots roots =
      SolveCosine(best.cut.direction.dot(basis.e1), best.cut.direction.dot(basis.e2), constant_m);
  starts.point_m[0] = PointOn(circle, basis, roots.middle_rad + roots.half_rad);
  starts.point_m[1] = PointOn(circle, basis, roots.middle_rad - roots.half_rad);
  starts.count = 2;
  return starts;
}

bool CirclesCoincide(std::span<const FixedPathLook> observations, const Eigen::Vector3d& origin_m) {
  constexpr int kSamples = 8;
  const Circle first = Circle::From(observations[0], origin_m);
  const CircleBasis basis = CircleBasis::From(first);
  for (std::size_t k = 1; k < observations.size(); ++k) {
    const Circle other = Circle::From(observations[k], origin_m);
    const double range_limit_m = kSameWithinSigmas * std::hypot(observations[0].range_sigma_m,
                                                                observations[k].range_sigma_m);
    const double along_limit_m =
        kSameWithinSigmas * std::sqrt(AlongVariance_m2(observations[0], first) +
                                      AlongVariance_m2(observations[k], other));
    for (int i = 0; i < kSamples; ++i) {
      const double phi_rad = 2.0 * std::numbers::pi * i / kSamples;
      const Eigen::Vector3d d_m = PointOn(first, basis, phi_rad) - other.centre_m;
      const double along_m = other.axis.dot(d_m);
      const double radius_m = (d_m - along_m * other.axis).norm();
      if (std::abs(along_m) > along_limit_m ||
          std::abs(radius_m - other.radius_m) > range_limit_m) {
        return false;
      }
    }
  }
  return true;
}

namespace {

constexpr int kMaxNewton = 60;

// Height above the reference surface along a circle of one look, with two derivatives by the circle
// parameter. Coordinates relative to the antenna.
class HeightAlong {
 public:
  HeightAlong(const Circle& circle, const Frame& frame, const Eigen::Vector3d& origin_m)
      : circle_(circle), basis_(CircleBasis::From(circle)), frame_(frame), origin_m_(origin_m) {}

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
    const Eigen::Vector3d tangent_m = circle_.axis.cross(radial_m);
    const Vertical vertical = frame_.VerticalAt(origin_m_ + value.point_m);
    value.height_m = vertical.height_m;
    value.first_m = vertical.up.dot(tangent_m);
    value.second_m = -vertical.up.dot(radial_m) + tangent_m.dot(vertical.dup_dp * tangent_m);
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

Intersection CircleAtHeight(const FixedPathLook& observation, const Frame& frame, double height_m) {
  const Circle circle = Circle::From(observation, observation.antenna_m);
  const HeightAlong along(circle, frame, observation.antenna_m);
  const Eigen::Vector3d up = frame.VerticalAt(observation.antenna_m).up;
  const CircleBasis& basis = along.basis();

  Intersection result;
  result.outcome = IntersectionOutcome::kCirclesDoNotMeet;
  const double top_rad = std::atan2(up.dot(basis.e2), up.dot(basis.e1));
  const double pi_rad = std::atan2(0.0, -1.0);
  const double lowest_rad = Extremum(along, -1.0, top_rad + pi_rad);
  double highest_rad = Extremum(along, 1.0, top_rad);
  if (along.At(lowest_rad).height_m > height_m || along.At(highest_rad).height_m < height_m) {
    return result;
  }
  // One root on either way up from the lowest point; the look side decides.
  highest_rad = lowest_rad + std::remainder(highest_rad - lowest_rad, 2.0 * pi_rad);
  const double other_rad = highest_rad + (highest_rad > lowest_rad ? -2.0 : 2.0) * pi_rad;
  const Eigen::Vector3d towards = observation.side * up.cross(circle.axis);
  double best_side_m = -1.0;
  for (const double end_rad : {highest_rad, other_rad}) {
    const HeightAlong::Value at = along.At(Root(along, height_m, lowest_rad, end_rad));
    const double side_m = towards.dot(at.point_m);
    if (side_m > best_side_m || result.outcome != IntersectionOutcome::kDetermined) {
      best_side_m = side_m;
      result.position_m = observation.antenna_m + at.point_m;
      result.outcome = IntersectionOutcome::kDetermined;
    }
  }
  return result;
}

}  // namespace sarblock::internal
