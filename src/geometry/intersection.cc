// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/intersection.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "circle.h"
#include "circle_height.h"
#include "intersection_solver.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

using internal::Candidate;

// Looks of correct standard deviations are called contradictory once in a million points.
constexpr double kMisfitProbability = 1e-6;
// Candidates closer than this part of the range are one solution reached twice.
constexpr double kSamePointPart = 1e-6;
// Refinement moves a start by the misfit of the looks, far less than this part of the range.
constexpr double kClearPart = 0.05;
constexpr std::size_t kMostLooksPaired = 16;

void Require(bool holds, const char* field, const char* problem) {
  if (!holds) {
    throw InputError(std::string(field), std::string(problem));
  }
}

bool Positive(double value) { return std::isfinite(value) && value > 0.0; }

void Validate(const Sight& sight) {
  Require(sight.antenna_m.allFinite(), "antenna_m", "must be finite");
  Require(sight.velocity_mps.allFinite() && sight.velocity_mps.squaredNorm() > 0.0,
          "velocity_mps",
          "must be finite and not zero");
  Require(sight.acceleration_mps2.allFinite(), "acceleration_mps2", "must be finite");
  Require(Positive(sight.range_m), "range_m", "must be finite and positive");
  Require(Positive(sight.range_sigma_m), "range_sigma_m", "must be finite and positive");
  Require(Positive(sight.azimuth_sigma), "azimuth_sigma", "must be finite and positive");
  Require(sight.side == 1 || sight.side == -1, "side", "must be +1 (left) or -1 (right)");
  if (sight.cone.kind == Cone::Kind::kSquint) {
    Require(
        std::abs(std::sin(sight.cone.squint_rad)) < 1.0 && std::cos(sight.cone.squint_rad) > 0.0,
        "squint_rad",
        "must lie between -pi/2 and pi/2");
  } else {
    Require(std::abs(sight.cone.closing_mps) < sight.velocity_mps.norm(),
            "closing_mps",
            "must be smaller than the speed (lambda f_D / 2 < |v|)");
  }
}

// > 0 where the direction d from the antenna lies on the side the antenna looks to.
double SideComponent(const Sight& sight, const Eigen::Vector3d& up_1, const Eigen::Vector3d& d_m) {
  return sight.side * up_1.cross(sight.velocity_mps).dot(d_m);
}

struct Placement {
  bool right_side = true;
  bool below = true;
  bool clearly_misplaced = false;  // on a wrong side or above by more than kClearPart of the range
};

Placement PlacementOf(std::span<const Sight> sights,
                      std::span<const Eigen::Vector3d> up_of_sight_1,
                      const Eigen::Vector3d& origin_m,
                      const Eigen::Vector3d& point_m) {
  Placement placement;
  for (std::size_t k = 0; k < sights.size(); ++k) {
    const Sight& sight = sights[k];
    const Eigen::Vector3d& up_1 = up_of_sight_1[k];
    const Eigen::Vector3d d_m = point_m - (sight.antenna_m - origin_m);
    placement.right_side = placement.right_side && SideComponent(sight, up_1, d_m) > 0.0;
    placement.below = placement.below && up_1.dot(d_m) < 0.0;
    const double clear_m = kClearPart * sight.range_m;
    placement.clearly_misplaced =
        placement.clearly_misplaced ||
        SideComponent(sight, up_1, d_m) < -clear_m * sight.velocity_mps.norm() ||
        up_1.dot(d_m) > clear_m;
  }
  return placement;
}

// Largest v'Pv of looks that agree. Quantiles take microseconds: the usual ones are kept.
double LargestMisfit(std::size_t looks) {
  constexpr std::size_t kKept = 64;
  const auto limit = [](std::size_t n) {
    return ChiSquareQuantile(1.0 - kMisfitProbability, 2.0 * static_cast<double>(n) - 3.0);
  };
  static const std::array<double, kKept> kept = [&limit] {
    std::array<double, kKept> out{};
    for (std::size_t n = 2; n < kKept; ++n) {
      out[n] = limit(n);
    }
    return out;
  }();
  return looks < kKept ? kept[looks] : limit(looks);
}

bool Fits(const Candidate& candidate, std::size_t looks) {
  return candidate.square_sum <= LargestMisfit(looks);
}

// At most the two mirror solutions.
struct Pool {
  std::array<Candidate, 2> items;
  std::size_t count = 0;
  void Add(const Candidate& candidate) { items[count++] = candidate; }
  // Keeps the candidates that pass, if any does.
  template <typename Predicate>
  bool Prefer(Predicate&& passes) {
    Pool kept;
    for (std::size_t i = 0; i < count; ++i) {
      if (passes(items[i])) {
        kept.Add(items[i]);
      }
    }
    if (kept.count > 0) {
      *this = kept;
    }
    return kept.count > 0;
  }
  [[nodiscard]] const Candidate& Best() const {
    return count == 2 && items[1].square_sum < items[0].square_sum ? items[1] : items[0];
  }
};

Intersection ResultOf(std::span<const Sight> sights,
                      const Eigen::Vector3d& origin_m,
                      const Candidate& candidate,
                      IntersectionOutcome outcome) {
  Intersection result;
  result.outcome = outcome;
  result.position_m = origin_m + candidate.point_m;
  result.weighted_square_sum = candidate.square_sum;
  result.iterations = candidate.iterations;
  result.intersection_rad = LargestIntersectionAngle(result.position_m, sights);
  if (candidate.converged && candidate.determined) {
    result.covariance_m2 = internal::CovarianceOf(candidate.r);
  }
  return result;
}

}  // namespace

double LargestIntersectionAngle(const Eigen::Vector3d& p_m, std::span<const Sight> sights) {
  const std::size_t n = sights.size();
  double largest_rad = 0.0;
  std::size_t far = 0;
  const auto sweep = [&](std::size_t i, std::size_t begin) {
    for (std::size_t k = begin; k < n; ++k) {
      const double angle_rad = IntersectionAngle(p_m, sights[i], sights[k]);
      if (angle_rad > largest_rad) {
        largest_rad = angle_rad;
        far = k;
      }
    }
  };
  if (n <= kMostLooksPaired) {
    for (std::size_t i = 0; i + 1 < n; ++i) {
      sweep(i, i + 1);
    }
  } else {
    sweep(0, 1);
    sweep(far, 0);
  }
  return largest_rad;
}

Intersection Intersect(std::span<const Sight> sights,
                       const Frame& frame,
                       const IntersectionOptions& options) {
  for (const Sight& sight : sights) {
    Validate(sight);
  }
  Intersection result;
  if (sights.size() < 2) {
    result.outcome = IntersectionOutcome::kTooFewLooks;
    return result;
  }
  const Eigen::Vector3d origin_m = sights[0].antenna_m;
  std::vector<Eigen::Vector3d> up_1;
  up_1.reserve(sights.size());
  for (const Sight& sight : sights) {
    up_1.push_back(frame.VerticalAt(sight.antenna_m).up_1);
  }
  const internal::Starts starts = internal::ClosedStarts(sights, origin_m, up_1[0]);
  // Half way between mirror solutions the basin of the other one begins.
  const double apart_m = (starts.point_m[1] - starts.point_m[0]).norm();
  const double max_step_m = starts.count == 2 ? 0.5 * apart_m : sights[0].range_m;
  const auto refine = [&](std::size_t i) {
    return internal::Refine(sights, origin_m, starts.point_m[i], max_step_m, options);
  };
  // Most points have one start where the antennas look and its mirror image clearly elsewhere. If
  // the first leads to a firm solution in its place the mirror solution would be discarded below:
  // it is not computed.
  if (starts.count == 2) {
    const Placement first = PlacementOf(sights, up_1, origin_m, starts.point_m[0]);
    const Placement second = PlacementOf(sights, up_1, origin_m, starts.point_m[1]);
    if (first.clearly_misplaced != second.clearly_misplaced) {
      const Candidate candidate = refine(first.clearly_misplaced ? 1 : 0);
      const Placement placement = PlacementOf(sights, up_1, origin_m, candidate.point_m);
      if (candidate.converged && candidate.firmly && placement.right_side && placement.below) {
        return ResultOf(sights,
                        origin_m,
                        candidate,
                        Fits(candidate, sights.size()) ? IntersectionOutcome::kDetermined
                                                       : IntersectionOutcome::kCirclesDoNotMeet);
      }
    }
  }
  Pool pool;
  for (std::size_t i = 0; i < starts.count; ++i) {
    const Candidate candidate = refine(i);
    const double same_m = kSamePointPart * sights[0].range_m;
    if (pool.count == 0 || (candidate.point_m - pool.items[0].point_m).norm() > same_m) {
      pool.Add(candidate);
    }
  }

  const auto placed = [&](const Candidate& c) {
    return PlacementOf(sights, up_1, origin_m, c.point_m);
  };
  const auto right_side = [&](const Candidate& c) { return placed(c).right_side; };
  const auto below = [&](const Candidate& c) { return placed(c).below; };
  const auto finish = [&](IntersectionOutcome outcome) {
    return ResultOf(sights, origin_m, pool.Best(), outcome);
  };
  // A point that floats within the noise (one circle twice) has no place to converge to.
  const auto settled = [&](const Candidate& c) {
    return c.converged || (!c.determined && Fits(c, sights.size()));
  };
  const auto open = [&](const Candidate& c) { return !settled(c) && right_side(c) && below(c); };
  const bool any_open = open(pool.items[0]) || open(pool.items[pool.count - 1]);
  if (!pool.Prefer(settled) || any_open) {
    return finish(IntersectionOutcome::kNotConverged);
  }
  // Place goes before fit: where path errors keep the circles apart, the mirror solution above the
  // antennas may fit better by chance and is still not the point. A point that floats along a
  // circle is on no particular side: only determined ones are judged.
  pool.Prefer([&](const Candidate& c) { return !c.determined || (right_side(c) && below(c)); });
  if (!pool.Prefer([&](const Candidate& c) { return Fits(c, sights.size()); })) {
    return finish(IntersectionOutcome::kCirclesDoNotMeet);
  }
  if (!pool.Prefer([&](const Candidate& c) { return !c.determined || right_side(c); })) {
    return finish(IntersectionOutcome::kWrongSide);
  }
  pool.Prefer(below);
  if (!pool.items[0].determined || !pool.items[pool.count - 1].determined) {
    return finish(internal::CirclesCoincide(sights, origin_m)
                      ? IntersectionOutcome::kCirclesCoincide
                      : IntersectionOutcome::kCirclesTouch);
  }
  return finish(pool.count == 2 ? IntersectionOutcome::kAmbiguous
                                : IntersectionOutcome::kDetermined);
}

Intersection IntersectWithHeight(const Sight& sight, const Frame& frame, double height_m) {
  Validate(sight);
  Require(std::isfinite(height_m), "height_m", "must be finite");
  return internal::CircleAtHeight(sight, frame, height_m);
}

double IntersectionAngle(const Eigen::Vector3d& p_m, const Sight& a, const Sight& b) {
  const auto projected = [&p_m](const Sight& sight) -> Eigen::Vector3d {
    const Eigen::Vector3d along = sight.velocity_mps.stableNormalized();
    const Eigen::Vector3d d_m = p_m - sight.antenna_m;
    return d_m - along.dot(d_m) * along;
  };
  const Eigen::Vector3d first_m = projected(a);
  const Eigen::Vector3d second_m = projected(b);
  return std::atan2(first_m.cross(second_m).norm(), first_m.dot(second_m));
}

}  // namespace sarblock
