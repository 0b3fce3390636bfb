// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include "sarblock/adjust/block_structure.h"
#include "sarblock/adjust/ceres_engine.h"
#include "sarblock/adjust/covariance.h"
#include "sarblock/adjust/engine_choice.h"
#include "sarblock/adjust/montecarlo.h"
#include "sarblock/adjust/prior_quality.h"
#include "sarblock/adjust/reduced_engine.h"
#include "sarblock/adjust/selection.h"
#include "sarblock/adjust/start_values.h"
#include "sarblock/adjust/variance_components.h"
#include "sarblock/core/error.h"
#include "sarblock/core/parallel.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "blunder_search.h"
#include "rounding.h"
#include "solution.h"

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
/// Looks beyond this whitened square length are dropped after a robust solution.
constexpr double kKeepProbability_1 = 0.999;

std::string NameLooks(const Block& block, const std::vector<std::size_t>& looks) {
  std::string text;
  constexpr std::size_t kNamed = 5;
  for (std::size_t i = 0; i < std::min(looks.size(), kNamed); ++i) {
    const auto& offsets = block.looks.offsets;
    const auto after = std::upper_bound(offsets.begin(), offsets.end(), looks[i]);
    const auto point = static_cast<std::size_t>(after - offsets.begin()) - 1;
    text += (i == 0 ? "" : ", ") + block.passes[block.looks.pass[looks[i]]].id + "/" +
            std::string(block.points.ids[point]);
  }
  if (looks.size() > kNamed) text += " and " + std::to_string(looks.size() - kNamed) + " more";
  return text;
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

namespace {

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

namespace {

/// Solves once more and counts its iterations with those before.
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

/// Starts lost points again from the intersection on the corrected paths and solves once more; what
/// is still lost then is left out by name. `system` is the reduced system, without a loss, at the
/// solution, or nothing where points were left out.
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

/// Newton steps on the reduced system without damping, whose gradient keeps the digits that the
/// solver's shorter sums lose on badly scaled blocks. Ends where the step is what the solver
/// promises, no longer shrinks, or the iterations are used up. Returns all that is left, in sigmas:
/// where large residuals meet bent equations each step is a fixed part of the one before, and many
/// small ones are to come. The weights follow the state. Like every solve it has an allowance of
/// iterations of its own: those before may have gone to points that were lost.
double Polish(const AdjustOptions& options,
              AdjustmentProblem* problem,
              BlockState* state,
              std::optional<ReducedSystem>* system,
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
    const bool solvable = after->looks_not_evaluated() == 0 && after->weak_points().empty() &&
                          after->FactorAndAnalyse(&next).regular();
    const double left_after = solvable ? after->RemainingStep() : left;
    if (left_after < left) contraction = left_after / left;
    if (!(left_after < left)) {
      UpdateWhitening(*state, problem);
      break;
    }
    left = left_after;
    *state = std::move(next);
    system->emplace(std::move(*after));
    ++solve->iterations;
  }
  return left > options.tolerance_1 ? left / (1.0 - contraction) : left;
}

/// Standard deviations are those of the place where the solver stopped: what is still to go bends
/// them by as much.
void WarnOfSlowSteps(const AdjustmentProblem& problem, double tolerance_1, AdjustResult* result) {
  const double told_1 = std::max(1e-5, tolerance_1);
  const auto points = static_cast<double>(problem.block.points.size());
  if (result->remaining_step <= told_1 * std::sqrt(std::max(1.0, 1e-3 * points))) return;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", result->remaining_step);
  Warn(result,
       std::string("the last steps shrink slowly, ") + text.data() +
           " sigmas are still to go: standard deviations may have fewer than six digits (residuals "
           "too large for the curvature of thin intersections, or too few iterations)");
}

/// Drops the looks that a robust solution found far off; returns which.
std::vector<std::size_t> DropOutliers(const AdjustResult& result, AdjustmentProblem* problem) {
  const double limit = ChiSquareQuantile(kKeepProbability_1, 2.0);
  std::vector<std::size_t> dropped;
  for (std::size_t i = 0; i < problem->look_used.size(); ++i) {
    if (problem->look_used[i] == 0) continue;
    const Eigen::Vector2d w = problem->whitening[i].Apply(result.looks.range_residual_m[i],
                                                          result.looks.azimuth_residual_m[i]);
    if (w.squaredNorm() <= limit) continue;
    problem->look_used[i] = 0;
    dropped.push_back(i);
  }
  return dropped;
}

/// After looks were dropped some points may have too few left.
void LeaveOutStarved(AdjustmentProblem* problem) {
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    const int rows =
        problem->control_of[point] < 0
            ? 0
            : problem->control[static_cast<std::size_t>(problem->control_of[point])].rows;
    const int looks = problem->CountLooks(point);
    if (looks == 0) {
      problem->LeaveOut(point, PointStatus::kNotSeen, "all its looks were dropped as outliers");
    } else if (2 * looks + rows < 3) {
      problem->LeaveOut(
          point, PointStatus::kTooFewLooks, "too few looks were left after outliers were dropped");
    }
  }
}

/// Variance components from a solved state; weights and state follow.
void EstimateComponents(const Weighting& weighting,
                        const AdjustOptions& options,
                        AdjustmentProblem* problem,
                        BlockState* state,
                        SolveReport* solve,
                        AdjustResult* result,
                        ProgressSink* progress) {
  VarianceSteps steps;
  steps.solve = [&] {
    const SolveReport before = *solve;
    *solve = SolveRounds(weighting, options, problem, state, progress);
    solve->iterations += before.iterations;
    solve->initial_cost_1 = before.initial_cost_1;
  };
  if (weighting.loss != RobustLoss::kNone) {
    steps.drop_outliers = [&] {
      AdjustResult residuals;
      FillResiduals(*problem, *state, {}, &residuals);
      DropOutliers(residuals, problem);
      LeaveOutStarved(problem);
    };
  }
  const StageTimer timer("variance_components", &result->stages);
  result->variance_components =
      EstimateVarianceComponents(options, steps, problem, state, progress);
  WarnOfComponents(*result->variance_components, result);
}

}  // namespace

AdjustResult Adjust(const Block& block,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  RequireOffered(options);
  if (options.corrections == CorrectionChoice::kAuto) {
    return AdjustSelected(block, options, pairs, progress);
  }
  return AdjustGiven(block, options, {}, pairs, nullptr, progress);
}

AdjustResult AdjustGiven(const Block& block,
                         const AdjustOptions& options,
                         const Simplified& simplified,
                         const PointPairs& pairs,
                         const AtSolution& at_solution,
                         ProgressSink* progress) {
  const ThreadLimit limit(options.threads);
  AdjustResult result;
  const std::vector<CorrectionGroup> none;
  AdjustmentProblem problem(
      block, options.corrections == CorrectionChoice::kGiven ? options.groups : none, simplified);
  BlockState state;
  std::vector<std::string> structure;
  PointDefects defects;
  bool floating = false;
  {
    const StageTimer timer("start", &result.stages);
    StartReport start = ComputeStartValues(&problem, progress);
    state = std::move(start.state);
    result.looks_not_evaluated = start.looks_not_evaluated.size();
    if (!start.looks_not_evaluated.empty()) {
      Warn(&result,
           std::to_string(start.looks_not_evaluated.size()) +
               " looks have no value in the model at the start and are left out: " +
               NameLooks(block, start.looks_not_evaluated));
    }
    RequireSolvable(problem);
    for (const Finding& finding : ExamineStructure(problem, state)) {
      structure.push_back(finding.text);
      Warn(&result, finding.text);
    }
    RequireCovarianceMethod(problem, options);
    std::optional<ReducedSystem> system;
    system.emplace(problem);
    system->Form(state, {}, progress);
    if (options.datum == Datum::kInner) {
      floating = HoldIfFloating(state, &problem);
      if (floating) {
        system->Form(state, {}, progress);
      } else {
        Warn(&result, "control or priors give the block a datum: inner constraints change nothing");
      }
    }
    // A singular block is refused before anything is solved with it. Points that are weak at the
    // start only are judged at the solution.
    if (system->weak_points().empty()) {
      RequireRegular(problem, system->FactorAndAnalyse(&state), structure);
    }
  }
  const Weighting weighting{options.robust, RobustScale(options)};
  SolveReport solve;
  std::optional<ReducedSystem> system;
  {
    const StageTimer timer("solve", &result.stages);
    solve = SolveRounds(weighting, options, &problem, &state, progress);
    RecoverLostPoints(options, &problem, &state, &solve, &system, &defects, progress);
  }
  if (options.quality.snooping != Snooping::kNone) {
    const StageTimer timer("snooping", &result.stages);
    const auto again = [&](RobustLoss loss) {
      AdjustOptions with_loss = options;
      with_loss.robust = loss;
      SolveOnce(with_loss, &problem, &state, &solve, progress);
    };
    system.reset();
    result.snooping = SearchBlunders(options, again, &problem, &state, progress);
  }
  if (options.variance_components != VarianceComponents::kNone) {
    EstimateComponents(weighting, options, &problem, &state, &solve, &result, progress);
    system.reset();  // formed with the weights before
  }
  std::optional<DatumTransform> datum;
  if (floating) {
    const StageTimer timer("datum", &result.stages);
    const auto again = [&] { SolveOnce(options, &problem, &state, &solve, progress); };
    datum.emplace(SettleInnerDatum(options, again, &problem, &state));
    system.reset();
  }
  std::optional<StageTimer> timer;
  timer.emplace("covariance", &result.stages);
  if (options.robust == RobustLoss::kNone) {
    if (!system || !system->weak_points().empty()) {
      FormDetermined(state, weighting, &problem, &system, progress);
    }
  } else {
    // A point that lost the weight of all its looks is named below, with the looks dropped.
    system.emplace(problem);
    system->Form(state, weighting, progress);
  }
  RequireRegular(problem, system->FactorAndAnalyse(&state), structure);
  timer.emplace("solve", &result.stages);
  result.remaining_step = options.robust == RobustLoss::kNone && !floating
                              ? Polish(options, &problem, &state, &system, &solve, progress)
                              : system->RemainingStep();
  timer.emplace("covariance", &result.stages);
  result.iterations = solve.iterations;
  result.initial_cost = solve.initial_cost_1;
  result.final_cost = system->cost();
  result.gradient = system->gradient();
  result.condition = system->Condition();
  if (system->looks_not_evaluated() > 0) {
    Warn(&result,
         std::to_string(system->looks_not_evaluated()) +
             " looks have no value in the model at the solution");
  }
  double square_sum = 2.0 * system->cost();
  std::vector<std::size_t> dropped;
  if (options.robust != RobustLoss::kNone) {
    FillResiduals(problem, state, weighting, &result);
    dropped = DropOutliers(result, &problem);
    LeaveOutStarved(&problem);
    if (!dropped.empty()) {
      Warn(&result,
           std::to_string(dropped.size()) +
               " looks were dropped as outliers after the robust "
               "solution");
    }
    FormDetermined(state, {}, &problem, &system, progress);
    RequireRegular(problem, system->FactorAndAnalyse(&state), structure);
    square_sum = 2.0 * system->cost();
    result.condition = system->Condition();
  }
  // What counts is the step that is left at the end, not what the solver says of itself.
  const bool converged = result.remaining_step <= (options.robust == RobustLoss::kNone
                                                       ? kRemainingStepAccepted_1
                                                       : kRemainingRobustStepAccepted_1) &&
                         system->looks_not_evaluated() == 0;
  result.status = converged ? AdjustStatus::kConverged : AdjustStatus::kNotConverged;
  result.accepted = converged;
  if (!converged) {
    Warn(&result, "not converged: " + solve.message);
  } else if (options.robust == RobustLoss::kNone) {
    WarnOfSlowSteps(problem, options.tolerance_1, &result);
  }

  WarnOfWeakDirections(system->rank(), &result);
  FillParameters(problem, state, &result);
  FillCovariance(problem, state, *system, datum, options, pairs, progress, &result);
  if (options.covariance == CovarianceLevel::kMonteCarlo) {
    timer.emplace("montecarlo", &result.stages);
    result.montecarlo =
        RunMonteCarlo(problem, state, weighting, options, result.points.covariance_m2, progress);
  }
  timer.emplace("quality", &result.stages);
  FillCorrectedPaths(problem, state, &result);
  FinishResult(problem, state, options, square_sum, defects, &result);
  WarnOfRounding(problem, state, &result);
  WarnOfContradictedPriors(&result);
  const bool of_whole_block = options.covariance == CovarianceLevel::kBlock ||
                              options.covariance == CovarianceLevel::kMonteCarlo;
  if (!result.points.covariance_m2.empty() && of_whole_block) {
    result.check_freedom_1 = CheckFreedom(problem, state, *system, result.checks);
  }
  if (floating && !result.checks.empty()) {
    result.checks.clear();
    Warn(&result, "check points are not compared: their coordinates have another datum");
  }
  // Also where the point went with them.
  for (const std::size_t look : dropped) result.looks.rejected[look] = 1;
  FillReasons(problem, dropped, &result);
  if (at_solution) {
    timer.emplace("simplifications", &result.stages);
    at_solution(problem, state, &result);
  }
  timer.reset();  // before the result is handed over
  return result;
}

}  // namespace sarblock
