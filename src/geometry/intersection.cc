// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/intersection.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "circle.h"
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace sarblock {

// ---- from a start to the point

namespace {

/// The whitened equations of all looks at one point, reduced to a triangle: J = Q R, Q'e = z.
/// Rows are rotated in one at a time, so that nothing is allocated for any number of looks.
struct Triangle {
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();  ///< upper triangular [1/m]
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  double rest = 0.0;  ///< norm of the part of e that no displacement changes

  void Absorb(const Eigen::RowVector3d& row, double error);
  double SquareSum() const { return z.squaredNorm() + rest * rest; }
};

/// A converged candidate point, relative to the origin.
struct Candidate {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();  ///< triangle of the whitened Jacobian [1/m]
  double square_sum = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool converged = false;
  bool determined = false;
  bool firmly = false;  ///< determined by a wide margin
};

void Triangle::Absorb(const Eigen::RowVector3d& row, double error) {
  Eigen::RowVector3d left = row;
  double last = error;
  for (Eigen::Index i = 0; i < 3; ++i) {
    // Whitened rows are far from the ends of the number range: no hypot is needed.
    const double norm = std::sqrt(r(i, i) * r(i, i) + left[i] * left[i]);
    if (norm == 0.0) {
      continue;
    }
    const double inverse = 1.0 / norm;
    const double c = r(i, i) * inverse;
    const double s = left[i] * inverse;
    for (Eigen::Index k = i; k < 3; ++k) {
      const double above = r(i, k);
      r(i, k) = c * above + s * left[k];
      left[k] = c * left[k] - s * above;
    }
    const double above = z[i];
    z[i] = c * above + s * last;
    last = c * last - s * above;
  }
  rest = std::sqrt(rest * rest + last * last);
}

// Solutions less exact than this part of a standard deviation need no second weighting.
constexpr double kApproximateSigmas = 1e-6;
// Converged also when a step changes the whitened equations by less than the rounding of a range (a
// few units in its last place).
constexpr double kRangeRounding = 8.0 * std::numeric_limits<double>::epsilon();
// Singular values below this part of the largest are rounding: no step is taken along them.
constexpr double kSingularPart = 1e-13;
// Above this reciprocal condition no singular value has to be computed.
constexpr double kRegular = 1e-4;
// A point determined with this margin in every criterion is firmly so.
constexpr double kFirmMargin = 4.0;
constexpr double kMinDamping = 1e-12;
constexpr double kMaxDamping = 1e12;
constexpr std::size_t kStackLooks = 64;
// A standard deviation beyond this part of the shortest range leaves the direction around the
// flight axis open: no linear statement holds there.
constexpr double kMaxDeviationPart = 0.5;
// The mirror solution has to lie this many standard deviations away (section 4).
constexpr double kMinMirrorDistance = 3.0;

// One whitening per look: on the stack up to 64 looks.
class Weights {
 public:
  explicit Weights(std::size_t count) {
    if (count > kStackLooks) {
      many_.resize(count);
    }
  }
  Whitening& operator[](std::size_t k) { return many_.empty() ? few_[k] : many_[k]; }
  const Whitening& operator[](std::size_t k) const { return many_.empty() ? few_[k] : many_[k]; }

 private:
  Whitening few_[kStackLooks];
  std::vector<Whitening> many_;
};

class Solver {
 public:
  Solver(std::span<const FixedPathLook> observations,
         const Eigen::Vector3d& origin_m,
         double max_step_m,
         const IntersectionOptions& options)
      : observations_(observations),
        origin_m_(origin_m),
        max_step_m_(max_step_m),
        options_(options),
        weights_(observations.size()) {}

  Candidate Run(const Eigen::Vector3d& start_m);

 private:
  bool Weigh(const Eigen::Vector3d& point_m);
  bool Evaluate(const Eigen::Vector3d& point_m, Triangle* triangle) const;
  struct Step {
    Eigen::Vector3d move_m = Eigen::Vector3d::Zero();
    double change = 0.0;  // of the whitened equations, by the model the step comes from
  };
  Step GaussNewtonStep() const;
  Step NewtonStep(double radius_m) const;
  Eigen::Matrix3d Curvature() const;
  bool Descend();
  void Judge();
  bool FirmlyDetermined() const;
  bool DeterminedAlong(const Eigen::Vector3d& step_m, double margin) const;
  double SecondOrder(const Eigen::Vector3d& step_m) const;

  std::span<const FixedPathLook> observations_;
  Eigen::Vector3d origin_m_;
  double max_step_m_;
  IntersectionOptions options_;
  Weights weights_;
  double floor_ = 0.0;  // whitened size of rounding
  Triangle triangle_;
  Candidate at_;
};

bool EquationsOf(const FixedPathLook& observation,
                 const Eigen::Vector3d& origin_m,
                 const Eigen::Vector3d& point_m,
                 LookEquations* look) {
  return EvaluateLookEquations(point_m,
                               observation.antenna_m - origin_m,
                               observation.velocity_mps,
                               observation.cone,
                               0.0,
                               look);
}

bool Solver::Weigh(const Eigen::Vector3d& point_m) {
  floor_ = 0.0;
  for (std::size_t k = 0; k < observations_.size(); ++k) {
    const FixedPathLook& observation = observations_[k];
    const TimeRates rates = LookTimeRates(point_m,
                                          observation.antenna_m - origin_m_,
                                          observation.velocity_mps,
                                          observation.acceleration_mps2,
                                          observation.cone);
    Whitening& w = weights_[k];
    w = observation.exact_time ? WhitenDoppler(observation.range_sigma_m, observation.azimuth_sigma)
        : observation.azimuth_in_seconds
            ? WhitenTime(observation.range_sigma_m, observation.azimuth_sigma, rates)
            : WhitenAzimuth(observation.range_sigma_m, observation.azimuth_sigma, rates);
    const double largest = std::max(std::abs(w.w00), std::abs(w.w11));
    if (!std::isfinite(largest) || !std::isfinite(w.w10)) {
      return false;
    }
    floor_ = std::max(floor_, kRangeRounding * observation.range_m * largest);
  }
  return true;
}

bool Solver::Evaluate(const Eigen::Vector3d& point_m, Triangle* triangle) const {
  *triangle = Triangle();
  for (std::size_t k = 0; k < observations_.size(); ++k) {
    LookEquations look;
    if (!EquationsOf(observations_[k], origin_m_, point_m, &look)) {
      return false;
    }
    const Whitening& w = weights_[k];
    const Eigen::Vector2d error =
        w.Apply(look.rho_m - observations_[k].range_m, look.doppler_error_m);
    triangle->Absorb(w.w00 * look.drho_dp, error[0]);
    triangle->Absorb(w.w10 * look.drho_dp + w.w11 * look.ded_dp, error[1]);
  }
  return std::isfinite(triangle->SquareSum()) && triangle->r.allFinite();
}

// Scales that give the columns unit length, so that singular values know no unit.
Eigen::Vector3d InverseColumnNorms(const Eigen::Matrix3d& r) {
  Eigen::Vector3d inverse_norm_m = Eigen::Vector3d::Ones();
  for (Eigen::Index c = 0; c < 3; ++c) {
    const double norm = r.col(c).norm();
    if (norm > 0.0) {
      inverse_norm_m[c] = 1.0 / norm;
    }
  }
  return inverse_norm_m;
}

struct Scaled {
  Eigen::Vector3d inverse_norm_m = Eigen::Vector3d::Ones();
  Eigen::JacobiSVD<Eigen::Matrix3d> svd;
};

Scaled Decompose(const Eigen::Matrix3d& r) {
  Scaled scaled;
  scaled.inverse_norm_m = InverseColumnNorms(r);
  const Eigen::Matrix3d unit = r * scaled.inverse_norm_m.asDiagonal();
  scaled.svd.compute(unit, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return scaled;
}

// R with unit columns, and its inverse where it has one.
struct ScaledInverse {
  Eigen::Vector3d inverse_norm_m = Eigen::Vector3d::Ones();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  double reciprocal_condition = 0.0;  // Frobenius norms: below the ratio of singular values
};

ScaledInverse Invert(const Eigen::Matrix3d& r) {
  ScaledInverse out;
  out.inverse_norm_m = InverseColumnNorms(r);
  const Eigen::Matrix3d unit = r * out.inverse_norm_m.asDiagonal();
  if (!(unit.diagonal().cwiseAbs().minCoeff() > 0.0)) {
    return out;
  }
  out.inverse = unit.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
  out.reciprocal_condition = 1.0 / (unit.norm() * out.inverse.norm());
  return out;
}

// Half the second derivative of v'Pv that J'J leaves out: sum of e times the curvature of the
// equations, (I - g g')/rho of the range and -sin(tau) times that of the cone.
Eigen::Matrix3d Solver::Curvature() const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < observations_.size(); ++k) {
    LookEquations look;
    if (!EquationsOf(observations_[k], origin_m_, at_.point_m, &look)) {
      continue;  // cannot happen: the point has been evaluated
    }
    const Whitening& w = weights_[k];
    const Eigen::Vector2d error =
        w.Apply(look.rho_m - observations_[k].range_m, look.doppler_error_m);
    const double factor = error[0] * w.w00 + error[1] * (w.w10 - w.w11 * look.sin_tau);
    sum += factor / look.rho_m *
           (Eigen::Matrix3d::Identity() - look.drho_dp.transpose() * look.drho_dp);
  }
  return sum;
}

Solver::Step Solver::GaussNewtonStep() const {
  // Far from singular every direction counts and R itself gives the step.
  const ScaledInverse regular = Invert(triangle_.r);
  if (regular.reciprocal_condition > kRegular) {
    return {regular.inverse_norm_m.cwiseProduct(-(regular.inverse * triangle_.z)),
            triangle_.z.norm()};
  }
  const Scaled scaled = Decompose(triangle_.r);
  const Eigen::Vector3d& s = scaled.svd.singularValues();
  const Eigen::Vector3d projected = scaled.svd.matrixU().transpose() * triangle_.z;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  Step step;
  double square = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (s[i] > kSingularPart * s[0]) {
      along[i] = -projected[i] / s[i];
      square += projected[i] * projected[i];
    }
  }
  step.move_m = scaled.inverse_norm_m.cwiseProduct(scaled.svd.matrixV() * along);
  step.change = std::sqrt(square);
  return step;
}

// Newton with the full second derivative, damped to at most `radius_m`: where circles touch, J is
// singular and only the curvature holds the point (section 3).
Solver::Step Solver::NewtonStep(double radius_m) const {
  const Eigen::Vector3d inverse_norm_m = InverseColumnNorms(triangle_.r);
  const Eigen::Matrix3d hessian = inverse_norm_m.asDiagonal() *
                                  (triangle_.r.transpose() * triangle_.r + Curvature()) *
                                  inverse_norm_m.asDiagonal();
  const Eigen::Vector3d gradient =
      inverse_norm_m.cwiseProduct(triangle_.r.transpose() * triangle_.z);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(hessian);
  const Eigen::Vector3d projected = eigen.eigenvectors().transpose() * gradient;
  Step step;
  for (double damping = 0.0;; damping = std::max(4.0 * damping, kMinDamping)) {
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    double square = 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      // A downward curvature is turned round: the step stays one of descent.
      const double value = std::abs(eigen.eigenvalues()[i]) + damping;
      if (value > kSingularPart) {
        along[i] = -projected[i] / value;
        square += projected[i] * projected[i] / value;
      }
    }
    step.move_m = inverse_norm_m.cwiseProduct(eigen.eigenvectors() * along);
    step.change = std::sqrt(square);
    if (step.move_m.norm() <= radius_m || damping > kMaxDamping) {
      return step;
    }
  }
}

bool Solver::Descend() {
  if (!Evaluate(at_.point_m, &triangle_)) {
    return false;
  }
  bool newton = false;  // from the first Gauss-Newton step that fails or gains little
  double radius_m = max_step_m_;
  while (at_.iterations < options_.max_iterations) {
    ++at_.iterations;
    const double before = triangle_.SquareSum();
    Step step = newton ? NewtonStep(radius_m) : GaussNewtonStep();
    const double length_m = step.move_m.norm();
    if (!newton && length_m > radius_m) {
      step.move_m *= radius_m / length_m;
    }
    Triangle trial;
    const bool valid = Evaluate(at_.point_m + step.move_m, &trial);
    // Rounding of the equations changes the sum by floor * |e|: below that the sum cannot show
    // whether a step helps, and the step is as good as the point it starts from.
    const double blind = std::sqrt(floor_ * std::sqrt(before));
    const bool small =
        length_m <= radius_m && step.change <= std::max({options_.settled_sigmas, floor_, blind});
    const double gain = before - trial.SquareSum();
    if (valid && (small || gain > 0.0)) {
      at_.point_m += step.move_m;
      triangle_ = trial;
      if (small) {
        return true;
      }
      const bool good = gain > 0.25 * step.change * step.change;
      newton = newton || !good;
      radius_m = good ? std::min(2.0 * radius_m, max_step_m_) : radius_m;
    } else if (!newton) {
      newton = true;
    } else {
      radius_m = 0.25 * std::min(step.move_m.norm(), radius_m);
      if (radius_m < kRangeRounding * observations_[0].range_m) {
        return true;  // no step lowers the sum any more
      }
    }
  }
  return false;
}

// Part of the second differences of the whitened equations along `step_m` (a unit change of the
// linearised equations) that the linear solution mistakes for a displacement along the step.
double Solver::SecondOrder(const Eigen::Vector3d& step_m) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < observations_.size(); ++k) {
    const Whitening& w = weights_[k];
    LookEquations here, ahead, behind;
    if (!EquationsOf(observations_[k], origin_m_, at_.point_m, &here) ||
        !EquationsOf(observations_[k], origin_m_, at_.point_m + step_m, &ahead) ||
        !EquationsOf(observations_[k], origin_m_, at_.point_m - step_m, &behind)) {
      return std::numeric_limits<double>::infinity();
    }
    const Eigen::Vector2d linear = w.Apply(here.drho_dp * step_m, here.ded_dp * step_m);
    const Eigen::Vector2d second =
        0.5 * w.Apply(ahead.rho_m - 2.0 * here.rho_m + behind.rho_m,
                      ahead.doppler_error_m - 2.0 * here.doppler_error_m + behind.doppler_error_m);
    sum += linear.dot(second);
  }
  return std::abs(sum);
}

bool Solver::DeterminedAlong(const Eigen::Vector3d& step_m, double margin) const {
  double shortest_m = std::numeric_limits<double>::infinity();
  for (const FixedPathLook& observation : observations_) {
    shortest_m = std::min(shortest_m, observation.range_m);
  }
  return margin * step_m.norm() <= kMaxDeviationPart * shortest_m &&
         margin * SecondOrder(step_m) * kMinMirrorDistance <= 1.0;
}

// One standard deviation along (nearly) the worst determined direction by inverse iteration on
// R'R, where R is regular: well-conditioned points skip the SVD.
bool Solver::FirmlyDetermined() const {
  const ScaledInverse regular = Invert(triangle_.r);
  if (!(regular.reciprocal_condition >
        std::max(kRegular, kFirmMargin * options_.min_reciprocal_condition))) {
    return false;
  }
  Eigen::Index longest = 0;
  regular.inverse.rowwise().squaredNorm().maxCoeff(&longest);
  Eigen::Vector3d v = Eigen::Vector3d::Unit(longest);
  double growth = 1.0;
  for (int i = 0; i < 4; ++i) {
    v = regular.inverse * (regular.inverse.transpose() * v);
    growth = v.norm();
    v /= growth;
  }
  return DeterminedAlong(regular.inverse_norm_m.cwiseProduct(v) * std::sqrt(growth), kFirmMargin);
}

void Solver::Judge() {
  // Where the iteration converged, its last step has evaluated this place already.
  if (!at_.converged && !Evaluate(at_.point_m, &triangle_)) {
    return;
  }
  at_.r = triangle_.r;
  at_.square_sum = triangle_.SquareSum();
  at_.firmly = FirmlyDetermined();
  at_.determined = at_.firmly;
  if (at_.firmly) {
    return;
  }
  const Scaled scaled = Decompose(triangle_.r);
  const Eigen::Vector3d& s = scaled.svd.singularValues();
  if (!(s[2] > options_.min_reciprocal_condition * s[0])) {
    return;
  }
  // One standard deviation along the worst determined direction.
  at_.determined =
      DeterminedAlong(scaled.inverse_norm_m.cwiseProduct(scaled.svd.matrixV().col(2)) / s[2], 1.0);
}

Candidate Solver::Run(const Eigen::Vector3d& start_m) {
  at_ = Candidate();
  at_.point_m = start_m;
  const int rounds = options_.settled_sigmas > kApproximateSigmas ? 1 : 2;
  for (int round = 0; round < rounds; ++round) {
    at_.converged = Weigh(at_.point_m) && Descend();
    if (!at_.converged) {
      break;
    }
  }
  Judge();
  return at_;
}

/// Gauss-Newton, then damped Newton, from a start point: weights from the start, formed again once
/// at convergence. docs/theory/intersection.md, section 3 and 4.
Candidate Refine(std::span<const FixedPathLook> observations,
                 const Eigen::Vector3d& origin_m,
                 const Eigen::Vector3d& start_m,
                 double max_step_m,
                 const IntersectionOptions& options) {
  return Solver(observations, origin_m, max_step_m, options).Run(start_m);
}

/// (R'R)^-1 for a non-singular triangle.
Eigen::Matrix3d CovarianceOf(const Eigen::Matrix3d& r) {
  const Eigen::Matrix3d inverse =
      r.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity().eval());
  return inverse * inverse.transpose();
}

}  // namespace

// ---- the intersection

namespace {

// Looks of correct standard deviations are called contradictory once in a million points.
constexpr double kMisfitProbability = 1e-6;
// Candidates closer than this part of the range are one solution reached twice.
constexpr double kSamePointPart = 1e-6;
// Refinement moves a start by the misfit of the looks, far less than this part of the range.
constexpr double kClearPart = 0.05;
constexpr std::size_t kMaxLooksPaired = 16;
// Angles whose sines and cosines differ by less than this part may differ by rounding alone.
constexpr double kSameAngle = 1e-14;

void Require(bool holds, const char* field, const char* problem) {
  if (!holds) {
    throw InputError(std::string(field), std::string(problem));
  }
}

bool Positive(double value) { return std::isfinite(value) && value > 0.0; }

void Validate(const FixedPathLook& observation) {
  Require(observation.antenna_m.allFinite(), "antenna_m", "must be finite");
  Require(observation.velocity_mps.allFinite() && observation.velocity_mps.squaredNorm() > 0.0,
          "velocity_mps",
          "must be finite and not zero");
  Require(observation.acceleration_mps2.allFinite(), "acceleration_mps2", "must be finite");
  Require(Positive(observation.range_m), "range_m", "must be finite and positive");
  Require(Positive(observation.range_sigma_m), "range_sigma_m", "must be finite and positive");
  Require(Positive(observation.azimuth_sigma), "azimuth_sigma", "must be finite and positive");
  Require(
      observation.side == 1 || observation.side == -1, "side", "must be +1 (left) or -1 (right)");
  if (observation.cone.kind == Cone::Kind::kSquint) {
    Require(std::abs(std::sin(observation.cone.squint_rad)) < 1.0 &&
                std::cos(observation.cone.squint_rad) > 0.0,
            "squint_rad",
            "must lie between -pi/2 and pi/2");
  } else {
    Require(std::abs(observation.cone.closing_mps) < observation.velocity_mps.norm(),
            "closing_mps",
            "must be smaller than the speed (lambda f_D / 2 < |v|)");
  }
}

// > 0 where the direction d from the antenna lies on the side the antenna looks to.
double SideComponent(const FixedPathLook& observation,
                     const Eigen::Vector3d& up,
                     const Eigen::Vector3d& d_m) {
  return observation.side * up.cross(observation.velocity_mps).dot(d_m);
}

struct Placement {
  bool right_side = true;
  bool below = true;
  bool clearly_mirrored = false;  // on a wrong side or above by more than kClearPart of the range
};

Placement PlacementOf(std::span<const FixedPathLook> observations,
                      std::span<const Eigen::Vector3d> up_at_antenna,
                      const Eigen::Vector3d& origin_m,
                      const Eigen::Vector3d& point_m) {
  Placement placement;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    const FixedPathLook& observation = observations[k];
    const Eigen::Vector3d& up = up_at_antenna[k];
    const Eigen::Vector3d d_m = point_m - (observation.antenna_m - origin_m);
    placement.right_side = placement.right_side && SideComponent(observation, up, d_m) > 0.0;
    placement.below = placement.below && up.dot(d_m) < 0.0;
    const double clear_m = kClearPart * observation.range_m;
    placement.clearly_mirrored =
        placement.clearly_mirrored ||
        SideComponent(observation, up, d_m) < -clear_m * observation.velocity_mps.norm() ||
        up.dot(d_m) > clear_m;
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

// The line of sight, projected across the flight.
Eigen::Vector3d AcrossTrack(const Eigen::Vector3d& p_m, const FixedPathLook& observation) {
  const Eigen::Vector3d along = observation.velocity_mps.stableNormalized();
  const Eigen::Vector3d d_m = p_m - observation.antenna_m;
  return d_m - along.dot(d_m) * along;
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

Intersection ResultOf(std::span<const FixedPathLook> observations,
                      const Eigen::Vector3d& origin_m,
                      const Candidate& candidate,
                      const IntersectionOptions& options,
                      IntersectionOutcome outcome) {
  Intersection result;
  result.outcome = outcome;
  result.position_m = origin_m + candidate.point_m;
  result.weighted_square_sum = candidate.square_sum;
  result.iterations = candidate.iterations;
  if (!options.with_covariance) {
    result.covariance_m2.setConstant(std::numeric_limits<double>::quiet_NaN());
    result.intersection_rad = std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  result.intersection_rad = LargestIntersectionAngle(result.position_m, observations);
  if (candidate.converged && candidate.determined) {
    result.covariance_m2 = CovarianceOf(candidate.r);
  }
  return result;
}

}  // namespace

double LargestIntersectionAngle(const Eigen::Vector3d& p_m,
                                std::span<const FixedPathLook> observations) {
  const std::size_t n = observations.size();
  double largest_rad = 0.0, largest_sine = 0.0, largest_cosine = 1.0;
  std::size_t far = 0;
  const auto offer = [&](const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, std::size_t k) {
    const double sine = a_m.cross(b_m).norm(), cosine = a_m.dot(b_m);
    // Most are smaller than the largest by far more than rounding: their arc is not computed.
    const double more = sine * largest_cosine, less = cosine * largest_sine;
    if (more - less < -kSameAngle * (more + std::abs(less))) return;
    const double angle_rad = std::atan2(sine, cosine);
    if (!(angle_rad > largest_rad)) return;
    largest_rad = angle_rad;
    largest_sine = sine;
    largest_cosine = cosine;
    far = k;
  };
  if (n <= kMaxLooksPaired) {
    std::array<Eigen::Vector3d, kMaxLooksPaired> across_m;
    for (std::size_t k = 0; k < n; ++k) across_m[k] = AcrossTrack(p_m, observations[k]);
    for (std::size_t i = 0; i + 1 < n; ++i) {
      for (std::size_t k = i + 1; k < n; ++k) offer(across_m[i], across_m[k], k);
    }
    return largest_rad;
  }
  for (const std::size_t begin : {std::size_t{1}, std::size_t{0}}) {
    const Eigen::Vector3d across_m = AcrossTrack(p_m, observations[far]);
    for (std::size_t k = begin; k < n; ++k) offer(across_m, AcrossTrack(p_m, observations[k]), k);
  }
  return largest_rad;
}

Intersection Intersect(std::span<const FixedPathLook> observations,
                       const Frame& frame,
                       const IntersectionOptions& options) {
  for (const FixedPathLook& observation : observations) {
    Validate(observation);
  }
  Intersection result;
  if (observations.size() < 2) {
    result.outcome = IntersectionOutcome::kTooFewLooks;
    return result;
  }
  const Eigen::Vector3d origin_m = observations[0].antenna_m;
  std::vector<Eigen::Vector3d> up;
  up.reserve(observations.size());
  for (const FixedPathLook& observation : observations) {
    up.push_back(frame.UpAt(observation.antenna_m));
  }
  const internal::Starts starts = internal::ClosedStarts(observations, origin_m, up[0]);
  // Half way between mirror solutions the basin of the other one begins.
  const double apart_m = (starts.point_m[1] - starts.point_m[0]).norm();
  const double max_step_m = starts.count == 2 ? 0.5 * apart_m : observations[0].range_m;
  const auto refine = [&](std::size_t i) {
    return Refine(observations, origin_m, starts.point_m[i], max_step_m, options);
  };
  // Most points have one start where the antennas look and its mirror image clearly elsewhere. If
  // the first leads to a firm solution in its place the mirror solution would be discarded below:
  // it is not computed.
  if (starts.count == 2) {
    const Placement first = PlacementOf(observations, up, origin_m, starts.point_m[0]);
    const Placement second = PlacementOf(observations, up, origin_m, starts.point_m[1]);
    if (first.clearly_mirrored != second.clearly_mirrored) {
      const Candidate candidate = refine(first.clearly_mirrored ? 1 : 0);
      const Placement placement = PlacementOf(observations, up, origin_m, candidate.point_m);
      if (candidate.converged && candidate.firmly && placement.right_side && placement.below) {
        return ResultOf(observations,
                        origin_m,
                        candidate,
                        options,
                        Fits(candidate, observations.size())
                            ? IntersectionOutcome::kDetermined
                            : IntersectionOutcome::kCirclesDoNotMeet);
      }
    }
  }
  Pool pool;
  for (std::size_t i = 0; i < starts.count; ++i) {
    const Candidate candidate = refine(i);
    const double same_m = kSamePointPart * observations[0].range_m;
    if (pool.count == 0 || (candidate.point_m - pool.items[0].point_m).norm() > same_m) {
      pool.Add(candidate);
    }
  }

  const auto placed = [&](const Candidate& c) {
    return PlacementOf(observations, up, origin_m, c.point_m);
  };
  const auto right_side = [&](const Candidate& c) { return placed(c).right_side; };
  const auto below = [&](const Candidate& c) { return placed(c).below; };
  const auto finish = [&](IntersectionOutcome outcome) {
    return ResultOf(observations, origin_m, pool.Best(), options, outcome);
  };
  // A point that floats within the noise (one circle twice) has no place to converge to.
  const auto settled = [&](const Candidate& c) {
    return c.converged || (!c.determined && Fits(c, observations.size()));
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
  if (!pool.Prefer([&](const Candidate& c) { return Fits(c, observations.size()); })) {
    return finish(IntersectionOutcome::kCirclesDoNotMeet);
  }
  if (!pool.Prefer([&](const Candidate& c) { return !c.determined || right_side(c); })) {
    return finish(IntersectionOutcome::kWrongSide);
  }
  pool.Prefer(below);
  if (!pool.items[0].determined || !pool.items[pool.count - 1].determined) {
    return finish(internal::CirclesCoincide(observations, origin_m)
                      ? IntersectionOutcome::kCirclesCoincide
                      : IntersectionOutcome::kCirclesTouch);
  }
  return finish(pool.count == 2 ? IntersectionOutcome::kAmbiguous
                                : IntersectionOutcome::kDetermined);
}

Intersection IntersectWithHeight(const FixedPathLook& observation,
                                 const Frame& frame,
                                 double height_m) {
  Validate(observation);
  Require(std::isfinite(height_m), "height_m", "must be finite");
  return internal::CircleAtHeight(observation, frame, height_m);
}

double IntersectionAngle(const Eigen::Vector3d& p_m,
                         const FixedPathLook& a,
                         const FixedPathLook& b) {
  const Eigen::Vector3d first_m = AcrossTrack(p_m, a), second_m = AcrossTrack(p_m, b);
  return std::atan2(first_m.cross(second_m).norm(), first_m.dot(second_m));
}

}  // namespace sarblock
