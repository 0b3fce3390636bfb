// SPDX-License-Identifier: Apache-2.0
#include "simplifications.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "core/threads.h"
#include <Eigen/Eigenvalues>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 512;

/// The full model and, where it makes a difference, that with one simplification.
struct Models {
  Models(const AdjustmentProblem& problem, const Eigen::Vector3d& middle_m)
      : full(problem.block, problem.layout) {
    full.ScaleSigmas(problem.model.sigma_factors());
    for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
      const Simplified simplified = OnlySimplified(kind, middle_m);
      one[kind] = std::make_unique<LookModel>(problem.block, problem.layout, simplified);
    }
  }
  LookModel full;
  std::array<std::unique_ptr<LookModel>, kSimplificationKinds> one;
};

/// Where leaving it out changes the equations of a pass at all.
bool Matters(const AdjustmentProblem& problem, std::size_t pass, std::size_t kind) {
  const PassCorrections& corrections = problem.layout.passes[pass];
  const bool geocentric = problem.block.frame.kind() == FrameKind::kGeocentric;
  const bool straight = problem.block.passes[pass].path.IsStraight();
  switch (kind) {
    case kFlatFrame:
      return geocentric && !corrections.troposphere.empty();
    case kFixedTrackAxes:
      return corrections.NeedsTrackAxes() && (geocentric || !straight);
    case kLinearVelocity:
      return !straight;
    default:
      return false;
  }
}

/// What the looks of one point say: squares of the whitened differences by simplification, and the
/// information of the point with the paths held.
struct PointSums {
  std::array<double, kSimplificationKinds> square{};
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  bool complete = true;
};

void AddLook(const AdjustmentProblem& problem,
             const BlockState& state,
             const Models& models,
             std::size_t point,
             std::size_t look,
             PointSums* sums) {
  const std::size_t pass = problem.block.looks.pass[look];
  LookColumns columns;
  LookEvaluation at, simplified;
  const LookWeights& weights = problem.weights[look];
  if (!EvaluateLook(models.full, state, point, look, weights, &columns, &at)) {
    sums->complete = false;
    return;
  }
  sums->information += at.by_point.transpose() * at.by_point;
  for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
    if (!Matters(problem, pass, kind)) continue;
    sums->square[kind] +=
        EvaluateLook(*models.one[kind], state, point, look, weights, &columns, &simplified)
            ? (simplified.error_1 - at.error_1).squaredNorm()
            : std::numeric_limits<double>::infinity();
  }
}

/// Height error of a tangent plane at the middle of the points.
double PlaneError(const Frame& frame, const Eigen::Vector3d& middle_m, const Eigen::Vector3d& p_m) {
  if (frame.kind() != FrameKind::kGeocentric) return 0.0;
  const Eigen::Matrix3d enu = frame.EnuFromFrame(middle_m);
  const Eigen::Vector3d offset_m = enu * (p_m - middle_m);
  return offset_m.head<2>().squaredNorm() / (2.0 * middle_m.norm());
}

using Bounds = std::array<SimplificationBound, kSimplificationKinds>;

void TakeLarger(const SimplificationBound& bound, SimplificationBound* largest) {
  if (std::isnan(largest->fraction_1) || bound.fraction_1 > largest->fraction_1) {
    *largest = bound;
  }
}

void BoundPoint(const AdjustmentProblem& problem,
                const BlockState& state,
                const Models& models,
                const Eigen::Vector3d& middle_m,
                std::size_t point,
                Bounds* largest) {
  const Block& block = problem.block;
  PointSums sums;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (problem.look_used[i] != 0) AddLook(problem, state, models, point, i, &sums);
  }
  if (!sums.complete) return;
  if (problem.control_of[point] >= 0) {
    const auto index = static_cast<std::size_t>(problem.control_of[point]);
    const ControlEvaluation control = EvaluateControl(
        block.frame, problem.control[index], state.start_m[point], state.displacement_m[point]);
    const auto rows = control.by_point.topRows(problem.control[index].rows);
    sums.information += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sums.information);
  if (!(eigen.eigenvalues()[0] > 1e-14 * eigen.eigenvalues()[2])) return;
  const Eigen::Vector3d p_m = state.Position(point);
  const double sigma_m = 1.0 / std::sqrt(eigen.eigenvalues()[0]);
  for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
    const double part_1 = std::sqrt(sums.square[kind]);
    TakeLarger({kSimplificationNames[kind], part_1 * sigma_m, sigma_m, part_1}, &(*largest)[kind]);
  }
  // Coordinates in the plane are off in height as well.
  const Eigen::Vector3d up_1 = block.frame.EnuFromFrame(p_m).row(2).transpose();
  const double sigma_up_m = (eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal() *
                             (eigen.eigenvectors().transpose() * up_1))
                                .norm();
  const double plane_m = PlaneError(block.frame, middle_m, p_m);
  TakeLarger({kSimplificationNames[kFlatFrame], plane_m, sigma_up_m, plane_m / sigma_up_m},
             &(*largest)[kFlatFrame]);
}

}  // namespace

Eigen::Vector3d MiddleOfPoints(const AdjustmentProblem& problem, const BlockState& state) {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  double solved = 0.0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    solved += 1.0;
    middle_m += (state.Position(point) - middle_m) / solved;
  }
  return middle_m;
}

Simplified OnlySimplified(std::size_t kind, const Eigen::Vector3d& middle_m) {
  return {.flat_frame = kind == kFlatFrame,
          .fixed_track_axes = kind == kFixedTrackAxes,
          .linear_velocity = kind == kLinearVelocity,
          .middle_m = middle_m};
}

std::vector<SimplificationBound> BoundSimplifications(const AdjustmentProblem& problem,
                                                      const BlockState& state,
                                                      double limit_1) {
  const std::size_t points = problem.block.points.size();
  const Eigen::Vector3d middle_m = MiddleOfPoints(problem, state);
  const Models models(problem, middle_m);
  std::vector<Bounds> of_chunk((points + kPointsPerChunk - 1) / kPointsPerChunk);
  ParallelForChunks(
      points, kPointsPerChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem.Solves(point)) continue;
          BoundPoint(problem, state, models, middle_m, point, &of_chunk[chunk]);
        }
      });
  Bounds largest;
  for (const Bounds& chunk : of_chunk) {
    for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
      if (!chunk[kind].name.empty()) TakeLarger(chunk[kind], &largest[kind]);
    }
  }
  if (largest[0].name.empty()) return {};
  for (SimplificationBound& bound : largest) {
    bound.allowed = bound.fraction_1 <= limit_1;
    bound.verdict = bound.allowed ? "allowed" : "not allowed";
  }
  return {largest.begin(), largest.end()};
}

}  // namespace sarblock
