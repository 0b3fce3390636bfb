// SPDX-License-Identifier: Apache-2.0
#include "simplify.h"

#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>

#include "core/threads.h"
#include "linear/dense.h"
#include "normals/reduced_system.h"
#include "solve/reduced_engine.h"
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

/// Sums over the looks of one point: squares of the whitened differences by simplification, and
/// the information of the point with fixed paths.
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
  sums->information += at.d_point.transpose() * at.d_point;
  for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
    if (!Matters(problem, pass, kind)) continue;
    sums->square[kind] +=
        EvaluateLook(*models.one[kind], state, point, look, weights, &columns, &simplified)
            ? (simplified.whitened_error - at.whitened_error).squaredNorm()
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
  if (std::isnan(largest->fraction) || bound.fraction > largest->fraction) {
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
    const auto rows = control.d_point.topRows(problem.control[index].rows);
    sums.information += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sums.information);
  if (!(eigen.eigenvalues()[0] > 1e-14 * eigen.eigenvalues()[2])) return;
  const Eigen::Vector3d p_m = state.Position(point);
  const double sigma_m = 1.0 / std::sqrt(eigen.eigenvalues()[0]);
  for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
    const double part = std::sqrt(sums.square[kind]);
    TakeLarger({kSimplificationNames[kind], part * sigma_m, sigma_m, part}, &(*largest)[kind]);
  }
  // Coordinates in the plane are off in height as well.
  const Eigen::Vector3d up = block.frame.EnuFromFrame(p_m).row(2).transpose();
  const double sigma_up_m = (eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal() *
                             (eigen.eigenvectors().transpose() * up))
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
                                                      double limit) {
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
    bound.allowed = bound.fraction <= limit;
    bound.verdict = bound.allowed ? "allowed" : "not allowed";
  }
  return {largest.begin(), largest.end()};
}

namespace {

constexpr std::size_t kSampledLooks = 20000;
constexpr int kRepetitions = 5;

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// CPU time of one pass over every `stride`-th point, its looks evaluated as an iteration does.
double TimeLooks(const AdjustmentProblem& problem,
                 const BlockState& state,
                 const LookModel& model,
                 std::size_t stride) {
  const std::vector<std::uint64_t>& offsets = problem.block.looks.offsets;
  LookEvaluation at;
  LookColumns columns;
  const double begin_s = ThreadSeconds();
  for (std::size_t point = 0; point < problem.block.points.size(); point += stride) {
    if (!problem.Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      static_cast<void>(EvaluateLook(model, state, point, i, problem.weights[i], &columns, &at));
    }
  }
  return ThreadSeconds() - begin_s;
}

/// Work of evaluating all looks in use once.
double WorkOf(const AdjustmentProblem& problem, const Simplified& simplified) {
  const LookModel model(problem.block, problem.layout, simplified);
  std::vector<double> looks_of_pass(problem.block.passes.size(), 0.0);
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] != 0) looks_of_pass[problem.block.looks.pass[i]] += 1.0;
  }
  double work = 0.0;
  for (std::size_t pass = 0; pass < looks_of_pass.size(); ++pass) {
    work += looks_of_pass[pass] * model.WorkOf(pass);
  }
  return work;
}

Simplified Both(Simplified a, const Simplified& b) {
  a.flat_frame = a.flat_frame || b.flat_frame;
  a.fixed_track_axes = a.fixed_track_axes || b.fixed_track_axes;
  a.linear_velocity = a.linear_velocity || b.linear_velocity;
  a.middle_m = b.middle_m;
  return a;
}

/// The same block, what takes part and its weights, with the full model.
void AdoptAll(const AdjustmentProblem& from, const BlockState& state, AdjustmentProblem* to) {
  to->model.ScaleSigmas(from.model.sigma_factors());
  to->look_used = from.look_used;
  to->point_status = from.point_status;
  to->point_reason = from.point_reason;
  to->control_of = from.control_of;
  to->fixed = from.fixed;
  UpdateWeights(state, to);
}

/// Forms and factors a system at a state; false where it has no step.
bool FormStep(const BlockState& state, ProgressSink* progress, ReducedSystem* system) {
  system->Form(state, {}, progress);
  return system->looks_not_evaluated() == 0 && system->FactorDamped();
}

/// Largest |u'd| / sigma_u of a displacement over all directions u.
double LengthInSigmas(const Eigen::Vector3d& enu_m, const SymmetricEnu& c) {
  const Eigen::Matrix3d matrix = MatrixOf(c);
  if (!matrix.allFinite()) return 0.0;
  return std::sqrt(std::max(0.0, dense::InverseForm(matrix, enu_m)));
}

}  // namespace

double MeasureGain(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Simplified& simplified) {
  const LookModel full(problem.block, problem.layout);
  const LookModel less(problem.block, problem.layout, simplified);
  const std::size_t stride = std::max<std::size_t>(1, problem.block.looks.size() / kSampledLooks);
  double full_s = std::numeric_limits<double>::infinity(), less_s = full_s;
  for (int k = 0; k < kRepetitions; ++k) {
    full_s = std::min(full_s, TimeLooks(problem, state, full, stride));
    less_s = std::min(less_s, TimeLooks(problem, state, less, stride));
  }
  return less_s > 0.0 ? full_s / less_s : kNotGiven;
}

Simplified ChooseSimplified(const AdjustmentProblem& problem,
                            const BlockState& state,
                            double limit,
                            std::vector<SimplificationBound>* bounds) {
  Simplified taken;
  if (bounds->empty()) return taken;
  const Eigen::Vector3d middle_m = MiddleOfPoints(problem, state);
  const double full = WorkOf(problem, {});
  std::array<bool, kSimplificationKinds> open{};
  for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
    SimplificationBound& bound = (*bounds)[kind];
    if (!bound.allowed) continue;
    const Simplified only = OnlySimplified(kind, middle_m);
    open[kind] = WorkOf(problem, only) < (1.0 - kMinGain) * full;
    if (open[kind]) bound.gain = MeasureGain(problem, state, only);
    bound.verdict = open[kind] ? "allowed, not taken: it gains nothing beside what was taken"
                               : "allowed, not taken: it gains nothing";
  }
  double part = 0.0;
  for (double now = full;;) {
    std::size_t best = kSimplificationKinds;
    double least = (1.0 - kMinGain) * now;
    for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
      if (!open[kind]) continue;
      const double work = WorkOf(problem, Both(taken, OnlySimplified(kind, middle_m)));
      if (work > least) continue;
      if (part + (*bounds)[kind].fraction > limit) {
        (*bounds)[kind].verdict = "allowed, not taken: above the limit with what was taken";
        continue;
      }
      best = kind;
      least = work;
    }
    if (best == kSimplificationKinds) return taken;
    open[best] = false;
    taken = Both(taken, OnlySimplified(best, middle_m));
    now = least;
    part += (*bounds)[best].fraction;
    (*bounds)[best].taken = true;
    (*bounds)[best].verdict = "taken";
  }
}

double ShiftToFullModel(const AdjustmentProblem& problem,
                        const BlockState& state,
                        const std::vector<SymmetricEnu>& covariance_m2,
                        ProgressSink* progress) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  AdjustmentProblem full(problem.block, problem.groups, {}, problem.priors);
  AdoptAll(problem, state, &full);
  ReducedSystem system(full), own(problem);
  if (!FormStep(state, progress, &system)) return kNone;
  if (covariance_m2.empty()) return system.NewtonDecrement();
  if (!FormStep(state, progress, &own)) return kNone;
  const BlockState there = AfterNewtonStep(full, state, system.Step());
  const BlockState here = AfterNewtonStep(problem, state, own.Step());
  double largest = 0.0;
  for (std::size_t point = 0; point < covariance_m2.size(); ++point) {
    if (!problem.Solves(point)) continue;
    const Eigen::Vector3d shift_m = there.displacement_m[point] - here.displacement_m[point];
    const double sigmas = LengthInSigmas(
        problem.block.frame.EnuFromFrame(state.Position(point)) * shift_m, covariance_m2[point]);
    if (!std::isfinite(sigmas)) return kNone;
    largest = std::max(largest, sigmas);
  }
  return largest;
}

}  // namespace sarblock
