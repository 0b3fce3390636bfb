// SPDX-License-Identifier: Apache-2.0
#include "solve_block.h"

#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/parallel.h"
#include "determinacy/form_determined.h"
#include "determinacy/rank_analysis.h"
#include "engine_choice.h"
#include "geometry/look_side.h"
#include "reduced_engine.h"
#include "step_tolerance.h"

namespace sarblock {
namespace {

/// A whitening element that changes less than this at the solution changes no digit that counts.
constexpr double kWhiteningSettled_1 = 1e-7;
/// What is left of an adjusted time, in its sigmas, bends the equations by its square over the
/// range. Polish() mends it, but not under a robust loss. Times that a whole solution still moves
/// by more must follow every step: held for a solution they and the points go round each other.
constexpr double kTimeSettled_sigmas = 0.1, kTimeSettledUnderLoss_sigmas = 1e-3;
/// Step left, in sigmas over all unknowns together, at which the weights are formed again.
constexpr double kApproached_1 = 1.0;
constexpr int kMostRounds = 5;

/// Sights of a point's looks on the corrected paths.
std::vector<Sight> SightsOf(const AdjustmentProblem& problem,
                            const BlockState& state,
                            std::size_t point) {
  std::vector<Sight> sights;
  const auto& offsets = problem.block.looks.offsets;
  for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    if (const auto sight = problem.model.SightOf(i, state.corrections)) sights.push_back(*sight);
  }
  return sights;
}

}  // namespace

SolveReport SolveRounds(const Weighting& weighting,
                        const AdjustOptions& options,
                        AdjustmentProblem* problem,
                        BlockState* state,
                        ProgressSink* progress) {
  SolveReport total;
  // A redescending loss has many minima: it starts from the solution of a convex one, which has an
  // allowance of iterations of its own.
  if (weighting.loss == RobustLoss::kTukey) {
    AdjustOptions convex = options;
    convex.robust = RobustLoss::kHuber;
    convex.robust_scale = 0.0;
    total = SolveRounds({convex.robust, RobustScale(convex)}, convex, problem, state, progress);
  }
  const int allowed = total.iterations + options.max_iterations;
  bool followed = false;
  for (int round = 0; round < kMostRounds || followed; ++round) {
    SolveOptions solve;
    solve.max_iterations = followed ? 1 : std::max(1, allowed - total.iterations);
    if (followed) solve.damping_1 = total.damping_1;
    solve.threads = options.threads;
    // The first round only has to come near enough for the weights.
    const bool ceres = Resolve(options.engine) == Engine::kCeres;
    const bool approach = round == 0 && (!ceres || weighting.loss == RobustLoss::kNone);
    solve.settled_1 = approach ? kApproached_1 : options.tolerance_1;
    solve.ceres_solver = options.ceres_solver;
    const SolveReport report = ceres ? SolveWithCeres(*problem, weighting, solve, state, progress)
                                     : SolveReduced(*problem, weighting, solve, state, progress);
    if (total.iterations == 0) total.initial_cost_1 = report.initial_cost_1;
    total.iterations += report.iterations;
    total.converged = report.converged;
    total.final_cost_1 = report.final_cost_1;
    total.damping_1 = report.damping_1;
    total.message = report.message;
    const WhiteningChange change = UpdateWhitening(*state, problem);
    const bool settled =
        !approach && change.weight_1 <= kWhiteningSettled_1 &&
        change.time_1 <= (weighting.loss == RobustLoss::kNone ? kTimeSettled_sigmas
                                                              : kTimeSettledUnderLoss_sigmas);
    const bool goes_on = report.converged || (followed && report.iterations > 0);
    if (!goes_on || settled || total.iterations >= allowed) break;
    followed =
        weighting.loss == RobustLoss::kNone && round >= 1 && change.time_1 > kTimeSettled_sigmas;
  }
  return total;
}

std::vector<std::size_t> LostPoints(const AdjustmentProblem& problem,
                                    const BlockState& state,
                                    std::optional<ReducedSystem>* formed,
                                    ProgressSink* progress) {
  ReducedSystem& system = formed->emplace(problem, KeptFactors::kMostBytes);
  system.Form(state, {}, progress);
  const std::size_t points = problem.block.points.size();
  std::vector<std::uint8_t> lost(points, 0);
  for (const WeakPoint& weak : system.weak_points()) lost[weak.point] = 1;
  ParallelForChunks(points, 1024, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point) || problem.control_of[point] >= 0 || lost[point] != 0) continue;
      const Eigen::Vector3d p_m = state.Position(point);
      for (const Sight& sight : SightsOf(problem, state, point)) {
        if (!LiesWhereItLooks(problem.block.frame, sight, p_m)) lost[point] = 1;
      }
    }
  });
  std::vector<std::size_t> out;
  for (std::size_t point = 0; point < points; ++point) {
    if (lost[point] != 0) out.push_back(point);
  }
  return out;
}

void SolveOnce(const AdjustOptions& options,
               AdjustmentProblem* problem,
               BlockState* state,
               SolveReport* solve,
               ProgressSink* progress) {
  const SolveReport before = *solve;
  *solve = SolveRounds({options.robust, RobustScale(options)}, options, problem, state, progress);
  solve->iterations += before.iterations;
  solve->initial_cost_1 = before.initial_cost_1;
}

void RecoverLostPoints(const AdjustOptions& options,
                       AdjustmentProblem* problem,
                       BlockState* state,
                       SolveReport* solve,
                       std::optional<ReducedSystem>* system,
                       PointDefects* defects,
                       ProgressSink* progress) {
  std::vector<std::size_t> lost = LostPoints(*problem, *state, system, progress);
  // Each round also mends the corrections that lost points have pulled at.
  for (int round = 0; round < 3 && !lost.empty(); ++round) {
    for (const std::size_t point : lost) {
      const Intersection met = Intersect(SightsOf(*problem, *state, point), problem->block.frame);
      if (met.outcome == IntersectionOutcome::kTooFewLooks) continue;
      state->start_m[point] = met.position_m;
      state->displacement_m[point].setZero();
      const auto& offsets = problem->block.looks.offsets;
      for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
        problem->model.adjusted_times()[i] = {};  // seen from where it was
      }
    }
    SolveOnce(options, problem, state, solve, progress);
    lost = LostPoints(*problem, *state, system, progress);
  }
  *defects = FindPointDefects(*problem, *state);
  bool left_out = LeaveOutOpenPoints(*defects, problem);
  for (const std::size_t point : lost) {
    if (!problem->Solves(point)) continue;
    const std::vector<Sight> sights = SightsOf(*problem, *state, point);
    const bool mirrored = std::any_of(sights.begin(), sights.end(), [&](const Sight& sight) {
      return !LiesWhereItLooks(problem->block.frame, sight, state->Position(point));
    });
    if (!mirrored || problem->control_of[point] >= 0) continue;  // weak points are named later
    problem->LeaveOut(point,
                      PointStatus::kUndetermined,
                      "its looks meet only above the antennas or on the side they do not look to");
    left_out = true;
  }
  if (left_out) {
    RequireSolvable(*problem);
    SolveOnce(options, problem, state, solve, progress);
    system->reset();
  }
}

double Polish(const AdjustOptions& options,
              AdjustmentProblem* problem,
              BlockState* state,
              std::optional<ReducedSystem>* system,
              RankReport* rank,
              SolveReport* solve,
              ProgressSink* progress) {
  constexpr int kMostSteps = 25;
  const double promised_1 = ShareOf(options.tolerance_1, *problem);
  double left = (*system)->RemainingStep(), contraction = 0.0;
  for (int step = 0; step < std::min(kMostSteps, options.max_iterations); ++step) {
    if (!(left > promised_1 && left < kApproached_1)) break;
    BlockState next = AfterNewtonStep(*problem, *state, (*system)->Step());
    UpdateWhitening(next, problem);
    std::optional<ReducedSystem> after;
    after.emplace(*problem, KeptFactors::kMostBytes);
    after->Form(next, {}, progress);
    RankReport rank_after;
    bool solvable = after->looks_not_evaluated() == 0 && after->weak_points().empty();
    if (solvable) {
      rank_after = FactorAndAnalyse(&*after, &next);
      solvable = rank_after.regular();
    }
    const double left_after = solvable ? after->RemainingStep() : left;
    if (left_after < left) contraction = left_after / left;
    if (!(left_after < left)) {
      UpdateWhitening(*state, problem);
      break;
    }
    left = left_after;
    *state = std::move(next);
    system->emplace(std::move(*after));
    *rank = std::move(rank_after);
    ++solve->iterations;
  }
  return left > options.tolerance_1 ? left / (1.0 - contraction) : left;
}

}  // namespace sarblock
