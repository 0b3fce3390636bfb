// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/simplifications.h"

#include "sarblock/adjust/problem.h"
#include "sarblock/flight/track_axes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace sarblock {
namespace {

enum Kind : std::size_t { kFlat, kFixedAxes, kUncoupled, kStraight, kKinds };
constexpr std::array<const char*, kKinds> kNames{
    "flat-frame", "fixed-track-axes", "uncoupled-squint", "linear-velocity"};

/// Largest standard deviation of a point, any direction.
double LargestSigma(const SymmetricEnu& c) {
  Eigen::Matrix3d matrix;
  matrix << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  if (!matrix.allFinite()) return kNotGiven;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(matrix, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

/// Errors of both equations where the antenna is off by ds and its velocity by dv.
Eigen::Vector2d EquationErrors(const Eigen::Vector3d& d_m,
                               const Eigen::Vector3d& velocity_mps,
                               const Eigen::Vector3d& ds_m,
                               const Eigen::Vector3d& dv_mps) {
  const double speed_mps = velocity_mps.norm();
  const Eigen::Vector3d u = velocity_mps / speed_mps;
  const double sine = u.dot(d_m) / d_m.norm();
  const Eigen::Vector3d across_m = d_m - u * u.dot(d_m);
  return {d_m.normalized().dot(ds_m),
          (u - sine * d_m.normalized()).dot(ds_m) - across_m.dot(dv_mps) / speed_mps};
}

/// State of a straight line between two states, the velocity interpolated linearly.
Motion StraightBetween(const std::vector<StateVector>& states, double time_s) {
  auto after =
      std::upper_bound(states.begin(), states.end(), time_s, [](double t, const StateVector& s) {
        return t < s.time_s;
      });
  after = std::clamp(after, states.begin() + 1, states.end() - 1);
  const StateVector& a = *(after - 1);
  const StateVector& b = *after;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  Motion motion;
  motion.position_m = a.position_m + part * (b.position_m - a.position_m);
  motion.velocity_mps = a.velocity_mps + part * (b.velocity_mps - a.velocity_mps);
  return motion;
}

/// Squares of the whitened errors of one look, by simplification.
using Squares = std::array<double, kKinds>;

bool AddLook(const AdjustmentProblem& problem,
             const AdjustResult& result,
             std::size_t look,
             const Eigen::Vector3d& p_m,
             Squares* squares) {
  const Block& block = problem.block;
  const std::size_t pass = block.looks.pass[look];
  const double time_s = block.looks.time_s[look];
  const FlightPath& nominal = block.passes[pass].path;
  const FlightPath& corrected =
      result.corrected_paths.empty() ? nominal : result.corrected_paths[pass];
  const auto at = corrected.At(time_s), before = nominal.At(time_s);
  if (!at || !before) return false;
  const Whitening w = problem.model.WhiteningOf(look, p_m, *at);
  const Eigen::Vector3d d_m = p_m - at->position_m;

  // Without the turning the velocity lacks A' c, c the correction in track axes.
  const TrackAxes axes = TrackAxesWithRate(block.frame, *before);
  const Eigen::Vector3d c_m = axes.axes_1.transpose() * (at->position_m - before->position_m);
  const Eigen::Vector2d turned =
      EquationErrors(d_m, at->velocity_mps, Eigen::Vector3d::Zero(), axes.rate * c_m);
  (*squares)[kFixedAxes] += w.Apply(turned[0], turned[1]).squaredNorm();

  // A time error of one standard deviation moves the range of a squinted look.
  const double range_sigma_m = block.SigmaOf(look).range_m;
  const double moved_m2 = 1.0 / (w.w00 * w.w00) - range_sigma_m * range_sigma_m;
  // Below rounding of the difference the two are not coupled at all.
  if (moved_m2 > 1e-12 * range_sigma_m * range_sigma_m) {
    (*squares)[kUncoupled] += moved_m2 / (range_sigma_m * range_sigma_m);
  }

  const Motion straight = StraightBetween(nominal.states(), time_s);
  const Eigen::Vector2d bent = EquationErrors(d_m,
                                              at->velocity_mps,
                                              straight.position_m - before->position_m,
                                              straight.velocity_mps - before->velocity_mps);
  (*squares)[kStraight] += w.Apply(bent[0], bent[1]).squaredNorm();
  return true;
}

/// Height error of a tangent plane at the middle of the points.
double PlaneError(const Frame& frame, const Eigen::Vector3d& middle_m, const Eigen::Vector3d& p_m) {
  const Eigen::Matrix3d enu = frame.EnuFromFrame(middle_m);
  const Eigen::Vector3d offset_m = enu * (p_m - middle_m);
  const double across_m2 = offset_m.head<2>().squaredNorm();
  return across_m2 / (2.0 * middle_m.norm());
}

}  // namespace

std::vector<SimplificationBound> BoundSimplifications(const Block& block,
                                                      const AdjustResult& result,
                                                      double limit_1) {
  std::vector<SimplificationBound> out;
  if (result.points.covariance_m2.empty()) return out;
  const AdjustmentProblem problem(block, {});
  const bool geocentric = block.frame.kind() == FrameKind::kGeocentric;
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  std::size_t solved = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!IsSolved(result.points.status[point])) continue;
    middle_m += result.points.position_m[point];
    ++solved;
  }
  if (solved == 0) return out;
  middle_m /= static_cast<double>(solved);

  for (std::size_t kind = 0; kind < kKinds; ++kind) out.push_back({kNames[kind]});
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!IsSolved(result.points.status[point])) continue;
    const Eigen::Vector3d& p_m = result.points.position_m[point];
    const SymmetricEnu& covariance_m2 = result.points.covariance_m2[point];
    const double sigma_m = LargestSigma(covariance_m2);
    if (!(sigma_m > 0.0)) continue;
    Squares squares{};
    bool complete = true;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      const bool rejected =
          result.looks.rejected.empty() ? block.looks.rejected(i) : result.looks.rejected[i] != 0;
      if (!rejected) complete = AddLook(problem, result, i, p_m, &squares) && complete;
    }
    if (!complete) continue;
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const bool flat = kind == kFlat;
      const double sigma_here_m = flat ? std::sqrt(covariance_m2[2]) : sigma_m;
      const double bound_m = !flat        ? std::sqrt(squares[kind]) * sigma_m
                             : geocentric ? PlaneError(block.frame, middle_m, p_m)
                                          : 0.0;
      const double fraction_1 = bound_m / sigma_here_m;
      if (std::isnan(out[kind].fraction_1) || fraction_1 > out[kind].fraction_1) {
        out[kind].bound_m = bound_m;
        out[kind].sigma_m = sigma_here_m;
        out[kind].fraction_1 = fraction_1;
      }
    }
  }
  for (SimplificationBound& bound : out) bound.allowed = bound.fraction_1 <= limit_1;
  return out;
}

}  // namespace sarblock
