// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include "sarblock/adjust/block_structure.h"
#include "sarblock/adjust/ceres_engine.h"
#include "sarblock/adjust/covariance.h"
#include "sarblock/adjust/engine_choice.h"
#include "sarblock/adjust/montecarlo.h"
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

/// A weight that changes by less than this at the solution changes no digit that counts.
constexpr double kWeightsSettled_1 = 1e-7;
/// Newton decrement, in sigmas over all unknowns together, at which a solver without a loss hands
/// over to the finishing Newton steps; they start from up to ten times as much.
constexpr double kApproached_1 = 1.0;
constexpr int kMostFinishingSteps = 25;
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

namespace {

/// Whole Newton steps on the undamped reduced equations, the weights formed anew with each: the
/// finish of both engines. The gradient keeps digits that the cost has lost, and an undamped sum
/// those that the solver's shorter one has. Ends where the decrement is what the tolerance asks for
/// or no longer shrinks. `system` is formed at the state and factored when it returns true; false
/// where the block cannot be factored there. Fills decrement and contraction of `solve`.
bool NewtonFinish(const AdjustOptions& options,
                  AdjustmentProblem* problem,
                  BlockState* state,
                  ReducedSystem* system,
                  SolveReport* solve,
                  ProgressSink* progress) {
  const auto form = [&](const BlockState& at) {
    system->Form(at, {}, progress);
    return system->looks_not_evaluated() == 0 && system->weak_points().empty() &&
           system->FactorDamped();
  };
  solve->decrement_1 = std::numeric_limits<double>::infinity();
  if (!form(*state)) return false;
  double left_1 = system->NewtonDecrement(), contraction = 0.0;
  const double wanted_1 = ToleranceFor(options.tolerance_1, *problem);
  const int most = std::min(kMostFinishingSteps, options.max_iterations);
  for (int step = 0; step < most; ++step) {
    if (!(left_1 > wanted_1 && left_1 < 10.0 * kApproached_1)) break;
    Step(progress, "solve", static_cast<std::size_t>(solve->iterations), 0, "finish");
    BlockState next = AfterNewtonStep(*problem, *state, system->Step());
    UpdateWeights(next, problem);
    const bool formed = form(next);
    const double after_1 = formed ? system->NewtonDecrement() : left_1;
    if (!(after_1 < left_1)) {
      UpdateWeights(*state, problem);
      if (!form(*state)) return false;
      break;
    }
    contraction = after_1 / left_1;
    left_1 = after_1;
    *state = std::move(next);
    ++solve->iterations;
  }
  solve->final_cost_1 = system->cost();
  // Where large residuals meet curved equations each step is a fixed part of the one before: the
  // sum of all to come is what is left.
  solve->decrement_1 = left_1 > options.tolerance_1 ? left_1 / (1.0 - contraction) : left_1;
  return true;
}

}  // namespace

SolveReport SolveRounds(const Weighting& weighting,
                        const AdjustOptions& options,
                        AdjustmentProblem* problem,
                        BlockState* state,
                        ProgressSink* progress,
                        std::optional<ReducedSystem>* solved) {
  SolveReport total;
  // A redescending loss has many minima: it starts from the solution of a convex one, which has an
  // allowance of iterations of its own.
  if (weighting.loss == RobustLoss::kTukey) {
    AdjustOptions convex = options;
    convex.robust = RobustLoss::kHuber;
    convex.robust_scale = 0.0;
    total = SolveRounds({convex.robust, RobustScale(convex)}, convex, problem, state, progress);
  }
  const bool least_squares = weighting.loss == RobustLoss::kNone;
  const bool ceres = Resolve(options.engine) == Engine::kCeres;
  const int allowed = total.iterations + options.max_iterations;
  std::optional<ReducedSystem> own;
  std::optional<ReducedSystem>& system = solved == nullptr ? own : *solved;
  system.emplace(*problem, KeptFactors::kMostBytes);
  for (int round = 0; round < kMostRounds; ++round) {
    SolveOptions solve;
    solve.max_iterations = std::max(1, allowed - total.iterations);
    solve.threads = options.threads;
    // Least squares first come near; what finishes them needs no damping.
    solve.settled_1 = least_squares && round == 0 ? kApproached_1 : options.tolerance_1;
    solve.ceres_solver = options.ceres_solver;
    SolveReport report = ceres
                             ? SolveWithCeres(*problem, weighting, solve, state, progress)
                             : SolveReduced(*problem, weighting, solve, &*system, state, progress);
    if (total.iterations == 0) total.initial_cost_1 = report.initial_cost_1;
    if (ceres && !least_squares && report.converged) {  // what the cost hides of the last digits
      const SolveReport finish =
          SolveReduced(*problem, weighting, solve, &*system, state, progress);
      report.final_cost_1 = finish.final_cost_1;
      report.iterations += finish.iterations;
    }
    total.iterations += report.iterations;
    total.converged = report.converged;
    total.final_cost_1 = report.final_cost_1;
    total.message = report.message;
    const double change_1 = UpdateWeights(*state, problem);
    if (least_squares) {
      const bool factored = NewtonFinish(options, problem, state, &*system, &total, progress);
      if (factored) {
        total.converged =
            total.decrement_1 <= std::max(options.tolerance_1, kRemainingStepAccepted_1);
      }
      if ((factored && total.converged) || round > 0 || total.iterations >= allowed) break;
      continue;  // a damped solution to the end, once
    }
    if (!report.converged || change_1 <= kWeightsSettled_1 || total.iterations >= allowed) break;
  }
  if (!least_squares && solved != nullptr) system->Form(*state, {}, progress);
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

std::vector<std::size_t> MisplacedPoints(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const ReducedSystem& system) {
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
               std::optional<ReducedSystem>* system,
               ProgressSink* progress) {
  const SolveReport before = *solve;
  *solve = SolveRounds(
      {options.robust, RobustScale(options)}, options, problem, state, progress, system);
  solve->iterations += before.iterations;
  solve->initial_cost_1 = before.initial_cost_1;
}

/// Starts misplaced points again from the intersection on the corrected paths and solves once more;
/// what is still misplaced then is left out by name. `system` is the reduced system, without a
/// loss, at the solution.
void RecoverMisplacedPoints(const AdjustOptions& options,
                            AdjustmentProblem* problem,
                            BlockState* state,
                            SolveReport* solve,
                            std::optional<ReducedSystem>* system,
                            PointDefects* defects,
                            ProgressSink* progress) {
  std::vector<std::size_t> lost = MisplacedPoints(*problem, *state, **system);
  // Each round also mends the corrections that misplaced points have pulled at.
  for (int round = 0; round < 3 && !lost.empty(); ++round) {
    for (const std::size_t point : lost) {
      const Intersection met = Intersect(SightsOf(*problem, *state, point), problem->block.frame);
      if (met.outcome == IntersectionOutcome::kTooFewLooks) continue;
      state->start_m[point] = met.position_m;
      state->displacement_m[point].setZero();
    }
    SolveOnce(options, problem, state, solve, system, progress);
    lost = MisplacedPoints(*problem, *state, **system);
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
    SolveOnce(options, problem, state, solve, system, progress);
  }
}

/// Leaves out the looks whose corrected time of reading lies beyond the ends of their path; returns
/// them.
std::vector<std::size_t> LeaveOutBeyondPaths(const BlockState& state, AdjustmentProblem* problem) {
  std::vector<std::size_t> out;
  LookColumns columns;
  LookEvaluation at;
  const auto& offsets = problem->block.looks.offsets;
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem->look_used[i] == 0) continue;
      if (!EvaluateLook(problem->model, state, point, i, {}, &columns, &at)) continue;
      if (!at.beyond_path) continue;
      problem->look_used[i] = 0;
      out.push_back(i);
    }
  }
  return out;
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
std::vector<std::size_t> DropOutliers(const BlockState& state, AdjustmentProblem* problem) {
  const double limit = ChiSquareQuantile(kKeepProbability_1, 2.0);
  const auto& offsets = problem->block.looks.offsets;
  std::vector<std::size_t> dropped;
  WhitenedLook at;
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem->look_used[i] == 0) continue;
      const bool near =
          EvaluateWhitened(*problem, state, {}, point, i, &at) && at.error_1.squaredNorm() <= limit;
      if (near) continue;
      problem->look_used[i] = 0;
      dropped.push_back(i);
    }
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
      DropOutliers(*state, problem);
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
    solve = SolveRounds(weighting, options, &problem, &state, progress, &system);
    RecoverMisplacedPoints(options, &problem, &state, &solve, &system, &defects, progress);
    for (int round = 0; round < 3 && system->looks_beyond_path() > 0; ++round) {
      const std::vector<std::size_t> beyond = LeaveOutBeyondPaths(state, &problem);
      Warn(&result,
           std::to_string(beyond.size()) +
               " looks are left out: with the time bias of their pass they lie beyond the ends of "
               "its flight path: " +
               NameLooks(block, beyond));
      LeaveOutStarved(&problem);
      RequireSolvable(problem);
      SolveOnce(options, &problem, &state, &solve, &system, progress);
    }
  }
  if (options.quality.snooping != Snooping::kNone) {
    const StageTimer timer("snooping", &result.stages);
    const auto again = [&](RobustLoss loss) {
      AdjustOptions with_loss = options;
      with_loss.robust = loss;
      SolveOnce(with_loss, &problem, &state, &solve, nullptr, progress);
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
    const auto again = [&] { SolveOnce(options, &problem, &state, &solve, nullptr, progress); };
    datum.emplace(SettleInnerDatum(options, again, &problem, &state));
    system.reset();
  }
  std::optional<StageTimer> timer;
  timer.emplace("covariance", &result.stages);
  if (options.robust == RobustLoss::kNone) {
    if (!system || !system->weak_points().empty()) {
      FormDetermined(state, weighting, &problem, &system, progress);
      static_cast<void>(NewtonFinish(options, &problem, &state, &*system, &solve, progress));
    }
  } else {
    // A point that lost the weight of all its looks is named below, with the looks dropped.
    system.emplace(problem);
    system->Form(state, weighting, progress);
  }
  RequireRegular(problem, system->FactorAndAnalyse(&state), structure);
  result.remaining_step = std::max(system->NewtonDecrement(),
                                   options.robust == RobustLoss::kNone ? solve.decrement_1 : 0.0);
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
    dropped = DropOutliers(state, &problem);
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
  if (!result.points.covariance_m2.empty() && options.covariance == CovarianceLevel::kBlock) {
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
