// SPDX-License-Identifier: Apache-2.0
#include "simplification_choice.h"

#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>

#include "normals/reduced_system.h"
#include "simplifications.h"
#include "solve/reduced_engine.h"
#include <Eigen/Cholesky>

namespace sarblock {
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
  to->held = from.held;
  UpdateWeights(state, to);
}

/// Forms and factors a system at a state; false where it has no step.
bool FormStep(const BlockState& state, ProgressSink* progress, ReducedSystem* system) {
  system->Form(state, {}, progress);
  return system->looks_not_evaluated() == 0 && system->FactorDamped();
}

/// Largest |u'd| / sigma_u of a displacement over all directions u.
double InSigmas(const Eigen::Vector3d& enu_m, const SymmetricEnu& c) {
  const Eigen::Matrix3d matrix = MatrixOf(c);
  if (!matrix.allFinite()) return 0.0;
  return std::sqrt(std::max(0.0, enu_m.dot(matrix.ldlt().solve(enu_m))));
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
                            double limit_1,
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
    open[kind] = WorkOf(problem, only) < (1.0 - kLeastGain_1) * full;
    if (open[kind]) bound.gain_1 = MeasureGain(problem, state, only);
    bound.verdict = open[kind] ? "allowed, not taken: it gains nothing beside what was taken"
                               : "allowed, not taken: it gains nothing";
  }
  double part_1 = 0.0;
  for (double now = full;;) {
    std::size_t best = kSimplificationKinds;
    double least = (1.0 - kLeastGain_1) * now;
    for (std::size_t kind = 0; kind < kSimplificationKinds; ++kind) {
      if (!open[kind]) continue;
      const double work = WorkOf(problem, Both(taken, OnlySimplified(kind, middle_m)));
      if (work > least) continue;
      if (part_1 + (*bounds)[kind].fraction_1 > limit_1) {
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
    part_1 += (*bounds)[best].fraction_1;
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
    const double sigmas = InSigmas(
        problem.block.frame.EnuFromFrame(state.Position(point)) * shift_m, covariance_m2[point]);
    if (!std::isfinite(sigmas)) return kNone;
    largest = std::max(largest, sigmas);
  }
  return largest;
}

}  // namespace sarblock
