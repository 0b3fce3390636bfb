// SPDX-License-Identifier: Apache-2.0
#include "adjust_given.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"
#include "finish.h"
#include "normals/point.h"
#include "quality/assess.h"
#include "quality/blunder_search.h"
#include "quality/consensus_search.h"
#include "quality/covariance.h"
#include "quality/mismatches.h"
#include "quality/montecarlo.h"
#include "quality/shifted_group.h"
#include "quality/variance_components.h"
#include "quality/verdict_tests.h"
#include "solve/inner_datum.h"
#include "solve/rank.h"
#include "solve/solve_block.h"
#include "solve/start.h"
#include "solve/structure.h"

namespace sarblock {
namespace {

/// The correction groups that a result was made with: given or chosen.
std::vector<CorrectionGroup> UsedGroups(const AdjustOptions& options, const AdjustResult& result) {
  switch (options.corrections) {
    case CorrectionChoice::kGiven:
      return options.groups;
    case CorrectionChoice::kAuto:
      return result.selection.groups;
    case CorrectionChoice::kNone:
      break;
  }
  return {};
}

}  // namespace

void DescribePaths(const Block& block, const AdjustOptions& options, AdjustResult* result) {
  result->strips = SampleStrips(block, UsedGroups(options, *result), *result);
}

namespace {

/// A move to another datum leaves v'Pv as it is but for rounding, which is less than this.
constexpr double kMaxChangeOfDatum = 1e-3;

std::string NameLooks(const Block& block, const std::vector<std::size_t>& looks) {
  std::string text;
  constexpr std::size_t kNamed = 5;
  for (std::size_t i = 0; i < std::min(looks.size(), kNamed); ++i) {
    const std::size_t point = block.looks.PointOf(looks[i]);
    text += (i == 0 ? "" : ", ") + block.passes[block.looks.pass[looks[i]]].id + "/" +
            std::string(block.points.ids[point]);
  }
  if (looks.size() > kNamed) text += " and " + std::to_string(looks.size() - kNamed) + " more";
  return text;
}

/// Standard deviations are those of the place where the solver stopped: what is still to go bends
/// them by as much.
void WarnOfSlowSteps(const AdjustmentProblem& problem, double tolerance, AdjustResult* result) {
  const double reported = std::max(1e-5, tolerance);
  const auto points = static_cast<double>(problem.block.points.size());
  if (result->remaining_step <= reported * std::sqrt(std::max(1.0, 1e-3 * points))) return;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", result->remaining_step);
  Warn(result,
       std::string("the last steps shrink slowly, ") + text.data() +
           " sigmas are still to go: standard deviations may have fewer than six digits (residuals "
           "too large for the curvature of thin intersections, or too few iterations)");
}

/// Drops the looks that a robust solution found far off; returns which.
std::vector<std::size_t> DropOutliers(const BlockState& state, AdjustmentProblem* problem) {
  const double limit = FarSquare();
  const auto& offsets = problem->block.looks.offsets;
  std::vector<std::size_t> dropped;
  WhitenedLook at;
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem->look_used[i] == 0) continue;
      const bool near = EvaluateWhitened(*problem, state, {}, point, i, &at) &&
                        at.whitened_error.squaredNorm() <= limit;
      if (near) continue;
      problem->look_used[i] = 0;
      dropped.push_back(i);
    }
  }
  return dropped;
}

/// Whether another pair of looks of a point agrees as well as the two that are used. Of three looks
/// on parallel paths any two agree, whichever of them is wrong.
bool AnotherPairAgrees(const AdjustmentProblem& problem,
                       const BlockState& state,
                       std::size_t point) {
  const Block& block = problem.block;
  std::vector<FixedPathLook> looks;
  std::vector<std::uint8_t> used;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i)) continue;
    if (const auto look = problem.model.FixPath(i, state.corrections)) {
      looks.push_back(*look);
      used.push_back(problem.look_used[i]);
    }
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (used[i] != 0 && used[j] != 0) continue;
      const std::vector<FixedPathLook> pair{looks[j], looks[i]};
      if (Agree(pair, Intersect(pair, block.frame), block.frame)) return true;
    }
  }
  return false;
}

/// Leaves out points that keep two looks after the loss dropped others, where another pair agrees
/// as well: nothing says which pair is right. The search for blunders does the same (FindSuspects).
void LeaveOutUndecided(const BlockState& state,
                       const std::vector<std::size_t>& dropped,
                       AdjustmentProblem* problem) {
  const Block& block = problem->block;
  const auto& offsets = block.looks.offsets;
  std::size_t last = block.points.size();
  for (const std::size_t look : dropped) {
    const auto after = std::upper_bound(offsets.begin(), offsets.end(), look);
    const auto point = static_cast<std::size_t>(after - offsets.begin() - 1);
    if (point == last || !problem->Solves(point) || problem->control_of[point] >= 0) continue;
    last = point;
    if (problem->CountLooks(point) != 2 || !AnotherPairAgrees(*problem, state, point)) continue;
    SuspectSet all;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (!block.looks.rejected(i)) all.looks.push_back(i);
    }
    problem->LeaveOut(point, PointStatus::kApart, DescribeContradiction(block, all));
  }
}

/// After looks were dropped some points may have too few left.
void LeaveOutStarved(AdjustmentProblem* problem) {
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    const std::optional<PointStatus> lacks = problem->LacksEquations(point);
    if (!lacks) continue;
    problem->LeaveOut(point,
                      *lacks,
                      *lacks == PointStatus::kNotSeen
                          ? "all its looks were dropped as outliers"
                          : "too few looks were left after outliers were dropped");
  }
}

/// Variance components from a solved state; weights and state follow.
void EstimateComponents(const AdjustOptions& options,
                        AdjustmentProblem* problem,
                        BlockState* state,
                        SolveReport* solve,
                        AdjustResult* result,
                        ProgressSink* progress) {
  VarianceSteps steps;
  steps.solve = [&] { SolveOnce(options, problem, state, solve, nullptr, progress); };
  if (options.robust != RobustLoss::kNone) {
    steps.drop_outliers = [&] {
      LeaveOutUndecided(*state, DropOutliers(*state, problem), problem);
      LeaveOutStarved(problem);
    };
  }
  const StageTimer timer("variance_components", &result->stages);
  result->variance_components =
      EstimateVarianceComponents(options, steps, problem, state, progress);
  WarnOfComponents(*result->variance_components, result);
}

void RefuseLargeLoss(const AdjustmentProblem& problem, AdjustResult* result) {
  const Block& block = problem.block;
  std::size_t given = 0, left_out = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    const std::size_t begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
    std::size_t looks = 0;
    for (std::size_t i = begin; i < end; ++i) looks += block.looks.rejected(i) ? 0U : 1U;
    given += looks;
    const bool open =
        problem.point_status[point] == PointStatus::kUndetermined && problem.mirrored[point] == 0;
    if (looks < 2 || open) continue;  // the network configuration leaves these out
    left_out += looks - static_cast<std::size_t>(problem.CountLooks(point));
  }
  if (static_cast<double>(left_out) <= kMaxLeftOut * static_cast<double>(given)) return;
  Refuse(result,
         std::to_string(left_out) + " of " + std::to_string(given) +
             " looks were left out as blunders, outliers or mirror solutions, more than a quarter; "
             "something "
             "that many looks share is wrong (the times, ranges or ids of a pass, a control point, "
             "the standard deviations)");
}

/// What was left out may be right and the path wrong: without the looks of a pass at control
/// points, or at points that others see too, this cannot be decided.
void RefusePassWithoutLooks(const AdjustmentProblem& problem, AdjustResult* result) {
  std::optional<std::size_t> pass = PassThatLosesControl(problem);
  const bool control = pass.has_value();
  if (!control) pass = UndecidedPass(CountPassLooks(problem.block, problem.look_used));
  if (!pass) return;
  Refuse(result,
         "pass " + problem.block.passes[*pass].id + " lost at least half of its looks at " +
             (control ? "control points" : "points of three looks and more") +
             " as blunders or outliers: they may be right and its path wrong (its times or "
             "ranges, its corrections and their standard deviations" +
             (control ? ", the control points)" : ")"));
}

/// `decrement`: the Newton decrement, infinite where looks have no value.
std::string WhyNotConverged(const SolveReport& solve, double decrement) {
  std::string why = solve.message;
  if (solve.converged && !std::isfinite(decrement)) {
    why = "looks have no value in the model at the solution";
  } else if (solve.converged) {
    std::array<char, 200> text{};
    std::snprintf(
        text.data(),
        text.size(),
        "where the steps ended, a whole Newton step is still %.2g sigmas long: residuals are "
        "too large for the curvature of the equations (gross contradictions, or points that "
        "two looks hardly determine)",
        decrement);
    why = text.data();
  }
  return solve.held_by.empty() ? why : why + "; where steps led, " + solve.held_by;
}

/// No solution is accepted in which a point is above an antenna or on the side away from the look.
void RefuseMirrorSolutions(const AdjustmentProblem& problem,
                           const BlockState& state,
                           const ReducedSystem& system,
                           AdjustResult* result) {
  const std::vector<std::size_t> mirrored = MirrorSolutions(problem, state, system);
  if (mirrored.empty()) return;
  const IdTable& ids = problem.block.points.ids;
  Refuse(result,
         std::to_string(mirrored.size()) +
             " points lie above the antennas or on the side that their looks do not look to: " +
             std::string(ids[mirrored.front()]) + (mirrored.size() > 1 ? " and others" : ""));
}

/// Looks that the corrected time puts beyond the ends of their path are left out.
void DropBeyondPaths(const AdjustOptions& options,
                     const Solution& solution,
                     ProgressSink* progress,
                     AdjustResult* result) {
  AdjustmentProblem& problem = *solution.problem;
  BlockState& state = *solution.state;
  for (int round = 0; round < 3 && (*solution.system)->looks_beyond_path() > 0; ++round) {
    const std::vector<std::size_t> beyond = LeaveOutBeyondPaths(state, &problem);
    Warn(result,
         std::to_string(beyond.size()) +
             " looks are left out: with the time bias of their pass they lie beyond the ends of "
             "its flight path: " +
             NameLooks(problem.block, beyond));
    LeaveOutStarved(&problem);
    RequireSolvable(problem);
    SolveOnce(options, &problem, &state, solution.solve, solution.system, progress);
  }
}

struct RobustOutcome {
  std::string why_none;              ///< why the robust solution is none; empty: it is one
  std::vector<std::size_t> dropped;  ///< looks far off in it
};

/// A loss decides which looks stay. Positions, corrections, residuals, covariance and tests are
/// then those of least squares with the looks kept: they belong together, which those of an
/// estimate under the loss would not (docs/theory/adjustment.md, section 7). Afterwards `options`
/// has no loss.
RobustOutcome SettleRobust(const Solution& solution,
                           AdjustOptions* options,
                           ProgressSink* progress,
                           AdjustResult* result) {
  const StageTimer timer("solve", &result->stages);
  AdjustmentProblem& problem = *solution.problem;
  BlockState& state = *solution.state;
  const Weighting weighting{options->robust, RobustScale(*options)};
  RobustOutcome out;
  const double decrement = NewtonDecrementUnderLoss(weighting, problem, state, progress);
  if (!(decrement <= kRemainingRobustStepAccepted)) {
    out.why_none = WhyNotConverged(*solution.solve, decrement);
  }
  FillLossWeights(problem, state, weighting, result);
  out.dropped = DropOutliers(state, &problem);
  LeaveOutUndecided(state, out.dropped, &problem);
  LeaveOutStarved(&problem);
  RequireSolvable(problem);
  options->robust = RobustLoss::kNone;
  SolveOnce(*options, &problem, &state, solution.solve, solution.system, progress);
  RecoverMirrorSolutions(
      *options, &problem, &state, solution.solve, solution.system, solution.defects, progress);
  return out;
}

/// The search for blunders from a solution; none is in the result where it gave way.
void Search(const AdjustOptions& options,
            const Solution& solution,
            ProgressSink* progress,
            AdjustResult* result) {
  const StageTimer timer("snooping", &result->stages);
  const auto again = [&](RobustLoss loss) {
    AdjustOptions with_loss = options;
    with_loss.robust = loss;
    SolveOnce(with_loss, solution.problem, solution.state, solution.solve, nullptr, progress);
  };
  solution.system->reset();
  result->snooping = SearchBlunders(options, again, solution.problem, solution.state, progress);
  // The search may have led points away, or freed others from what had led them.
  solution.system->emplace(*solution.problem, KeptFactors::kMaxBytes);
  (*solution.system)->Form(*solution.state, {}, progress);
  RecoverMirrorSolutions(options,
                         solution.problem,
                         solution.state,
                         solution.solve,
                         solution.system,
                         solution.defects,
                         progress);
}

/// Whether the looks that were left out are a group of one pass; it then takes their place.
void SearchForGroup(const AdjustOptions& options,
                    const Solution& solution,
                    RobustOutcome* robust,
                    ProgressSink* progress,
                    AdjustResult* result) {
  if (!options.quality.consensus || !solution.solve->converged) return;
  std::vector<std::uint64_t> lost(robust->dropped.begin(), robust->dropped.end());
  if (result->snooping) {
    const std::vector<std::uint64_t> left_out = LooksLeftOut(*result->snooping);
    lost.insert(lost.end(), left_out.begin(), left_out.end());
  }
  if (lost.empty()) return;
  const StageTimer timer("group", &result->stages);
  std::optional<SnoopingReport> found = SearchShiftedGroup(options, lost, solution, progress);
  if (!found) return;
  result->snooping = std::move(found);
  robust->dropped.clear();
  result->looks.weight.clear();
}

/// Solution and search as requested; if they contradict themselves, or there is no solution, by
/// consensus. Returns the options of the solution: a consensus replaces a loss.
/// `unsettled`: how the solution contradicts itself where no consensus settles it, else kNone; a
/// later solution may be another minimum.
AdjustOptions SolveAndSearch(const AdjustOptions& asked,
                             const Solution& solution,
                             ProgressSink* progress,
                             AdjustResult* result,
                             Contradiction* unsettled) {
  AdjustOptions plain = asked;
  plain.quality.snooping = Snooping::kNone;
  AdjustOptions agreed = asked;
  agreed.robust = RobustLoss::kNone;
  bool tried = !asked.quality.consensus;
  const auto by_consensus = [&](Contradiction contradiction) {
    if (tried || contradiction == Contradiction::kNone) return false;
    tried = true;
    const StageTimer timer("consensus", &result->stages);
    ConsensusOutcome found = SearchByConsensus(asked, solution, progress);
    const bool settled = found.agreed || contradiction == Contradiction::kTest;
    *unsettled = settled ? Contradiction::kNone : contradiction;
    if (!found.adopted) return false;
    result->snooping = std::move(found.adopted);
    Warn(result, DescribeConsensus(*solution.problem, *result->snooping));
    DropBeyondPaths(agreed, solution, progress, result);
    return true;
  };
  try {
    {
      const StageTimer timer("solve", &result->stages);
      *solution.solve = SolveRounds({asked.robust, RobustScale(asked)},
                                    asked,
                                    solution.problem,
                                    solution.state,
                                    progress,
                                    solution.system);
    }
    // Before points are led back one by one: what pulls at all of them is found first.
    if (!tried && by_consensus(FindContradiction(plain, solution))) return agreed;
    {
      const StageTimer timer("solve", &result->stages);
      RecoverMirrorSolutions(asked,
                             solution.problem,
                             solution.state,
                             solution.solve,
                             solution.system,
                             solution.defects,
                             progress);
      DropBeyondPaths(asked, solution, progress, result);
    }
    if (!tried && by_consensus(FindContradiction(plain, solution))) return agreed;
    if (asked.quality.snooping == Snooping::kNone) return asked;
    if (*unsettled != Contradiction::kNone && !solution.solve->converged) {
      Warn(
          result,
          "no search for blunders was made: the block as it was given has no solution to test, and "
          "its looks have no consensus; nothing is left out");
      return asked;
    }
    Search(asked, solution, progress, result);
    std::optional<SnoopingReport> searched = std::exchange(result->snooping, std::nullopt);
    const Contradiction left =
        searched ? FindContradiction(asked, solution) : Contradiction::kGross;
    if (by_consensus(left)) return agreed;
    if (!searched) {
      Refuse(
          result,
          "the search for blunders was aborted: it had left out more than a quarter of the looks, "
          "so something that many looks share is wrong (the times, ranges or ids of a pass, a "
          "control point, the standard deviations); nothing is left out");
    }
    result->snooping = std::move(searched);
  } catch (const UndeterminedError&) {
    result->snooping.reset();
    if (!by_consensus(Contradiction::kGross)) throw;
    return agreed;
  }
  return asked;
}

}  // namespace

AdjustResult AdjustGiven(const Block& block,
                         const AdjustOptions& asked,
                         const Simplified& simplified,
                         const PointPairs& pairs,
                         const AtSolution& at_solution,
                         ProgressSink* progress) {
  AdjustResult result;
  const CorrectionModel given = GivenCorrections(asked);
  AdjustmentProblem problem(block, given.groups, simplified, given.priors);
  BlockState state;
  std::vector<std::string> structure;
  PointDefects defects;
  bool floating = false;
  std::optional<ReducedSystem> system;  // formed at the state
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
    RequireCovarianceMethod(problem, asked);
    system.emplace(problem);
    const ResourceNeeds needs = PredictNeeds(problem, asked, &*system);
    if (const std::string text = ProblemOfMemory(needs, asked); !text.empty()) {
      throw InputError(FilePlace{}, text);
    }
    const auto form = [&] {
      system->FormSettled({.renewed = &problem.weights}, 0.0, kMaxOwnStep, &state, progress);
    };
    form();
    if (asked.datum == Datum::kInner) {
      floating = FixDatumIfFloating(state, &problem);
      if (floating) {
        form();
      } else {
        Warn(&result, "control or priors give the block a datum: inner constraints change nothing");
      }
    }
    // A singular block is refused before anything is solved with it. Points that are weak at the
    // start only are judged at the solution.
    if (system->weak_points().empty()) {
      RequireRegular(problem, FactorAndAnalyse(&*system, &state), structure);
    } else {
      system.reset();
    }
  }
  SolveReport solve;
  const Solution solution{&problem, &state, &solve, &system, &defects};
  Contradiction unsettled = Contradiction::kNone;
  AdjustOptions options = SolveAndSearch(asked, solution, progress, &result, &unsettled);
  const bool settled = unsettled == Contradiction::kNone;
  RobustOutcome robust;
  if (settled && options.robust == RobustLoss::kNone) {
    SearchForGroup(options, solution, &robust, progress, &result);
  }
  if (options.variance_components != VarianceComponents::kNone) {
    EstimateComponents(options, &problem, &state, &solve, &result, progress);
    system.emplace(problem, KeptFactors::kMaxBytes);  // that before had other weights
    system->Form(state, {}, progress);
    RecoverMirrorSolutions(options, &problem, &state, &solve, &system, &defects, progress);
  }
  if (options.robust != RobustLoss::kNone) {
    robust = SettleRobust(solution, &options, progress, &result);
    // Estimated components are not those of another choice of looks.
    if (settled && robust.why_none.empty() && !result.variance_components) {
      SearchForGroup(options, solution, &robust, progress, &result);
    }
    if (!robust.dropped.empty()) {
      Warn(&result,
           std::to_string(robust.dropped.size()) +
               " looks were dropped as outliers after the robust solution");
    }
  }
  std::optional<DatumTransform> datum;
  double cost_before_datum = std::numeric_limits<double>::quiet_NaN();
  if (floating) {
    const StageTimer timer("datum", &result.stages);
    system.emplace(problem);
    system->Form(state, {}, nullptr);
    cost_before_datum = system->cost();
    const auto again = [&] { SolveOnce(options, &problem, &state, &solve, nullptr, progress); };
    datum.emplace(SettleInnerDatum(options, again, &problem, &state));
    system.reset();
  }
  std::optional<StageTimer> timer;
  timer.emplace("covariance", &result.stages);
  if (!system || !system->weak_points().empty()) {
    FormDetermined(state, {}, &problem, &system, progress);
    static_cast<void>(NewtonFinish(options, &problem, &state, &*system, &solve, progress));
  }
  const RankReport rank = FactorAndAnalyse(&*system, &state);
  RequireRegular(problem, rank, structure);
  result.remaining_step = std::max(system->NewtonDecrement(), solve.decrement);
  result.iterations = solve.iterations;
  result.initial_cost = solve.initial_cost;
  result.final_cost = system->cost();
  if (const double change = 2.0 * std::abs(result.final_cost - cost_before_datum);
      change > kMaxChangeOfDatum) {
    Refuse(
        &result,
        "the datum is not free: moved to the inner datum the block changes v'Pv by " +
            Digits(change, 2) +
            ", so a direction that counts as a defect is one that the observations determine, if "
            "only weakly; give control, or priors of the corrections, in place of datum = "
            "\"inner\"");
  }
  result.gradient = system->gradient();
  result.condition = rank.condition;
  if (system->looks_not_evaluated() > 0) {
    Warn(&result,
         std::to_string(system->looks_not_evaluated()) +
             " looks have no value in the model at the solution");
  }
  // What counts is the Newton decrement at the end, not the solver's own verdict.
  const double decrement = system->looks_not_evaluated() == 0
                               ? result.remaining_step
                               : std::numeric_limits<double>::infinity();
  std::string why_not = robust.why_none;
  if (why_not.empty() && !(decrement <= kRemainingStepAccepted)) {
    why_not = WhyNotConverged(solve, decrement);
  }
  result.status = why_not.empty() ? AdjustStatus::kConverged : AdjustStatus::kNotConverged;
  if (why_not.empty()) {
    WarnOfSlowSteps(problem, options.tolerance, &result);
  } else {
    Refuse(&result, "not converged: " + why_not);
  }

  RefuseLargeLoss(problem, &result);
  if (asked.robust != RobustLoss::kNone || result.snooping)
    RefusePassWithoutLooks(problem, &result);
  RefuseMirrorSolutions(problem, state, *system, &result);
  const bool unsolved = unsettled == Contradiction::kUnsolved;
  if (unsettled == Contradiction::kGross || (unsolved && why_not.empty())) {
    Refuse(&result,
           std::string(unsolved ? "the first solution did not converge"
                                : "the block contradicted itself") +
               " and its looks have no consensus: where steps or losses came to an end may not be "
               "the place");
  }
  WarnOfWeakDirections(rank, &result);
  FillParameters(problem, state, &result);
  FillCovariance(problem, state, *system, datum, options, pairs, progress, &result);
  if (options.covariance == CovarianceLevel::kMonteCarlo) {
    timer.emplace("montecarlo", &result.stages);
    result.montecarlo = ReportMonteCarlo(
        DrawMonteCarlo(problem, state, options, result.points.covariance_m2, progress),
        options.montecarlo_seed,
        result.points.covariance_m2);
  }
  timer.emplace("quality", &result.stages);
  FillCorrectedPaths(problem, state, &result);
  FinishResult(
      problem,
      state,
      options,
      {2.0 * system->cost(), SquareLeftOut(robust.dropped.size(), block.looks.size(), result)},
      defects,
      &result);
  WarnOfRounding(problem, state, &result);
  if (!floating && why_not.empty()) {
    result.curvatures = CurvaturesOfCorrections(problem, state, *system, result.parameters);
  }
  const bool of_whole_block = options.covariance == CovarianceLevel::kBlock ||
                              options.covariance == CovarianceLevel::kMonteCarlo;
  if (!result.points.covariance_m2.empty() && of_whole_block) {
    result.check_freedom =
        CheckFreedom(problem, state, *system, result.checks, PosteriorFactor(options, result));
  }
  if (floating && !result.checks.empty()) {
    result.checks.clear();
    Warn(&result, "check points are not compared: their coordinates have another datum");
  }
  FillReasons(problem, robust.dropped, &result);
  ReportMismatches(problem, options, &result);
  Assess(block, options, &result);
  if (at_solution) {
    timer.emplace("simplifications", &result.stages);
    at_solution(problem, state, &result);
  }
  timer.reset();  // before the result is handed over
  return result;
}

// ---- what it needs of memory

namespace {

constexpr double kMiB = 1024.0 * 1024.0;
/// Less than this is not looked for: there is always as much.
constexpr std::uint64_t kAlwaysThere = std::uint64_t{64} << 20;

/// Bytes of arrays.
struct ArrayBytes {
  std::uint64_t all = 0;
  std::uint64_t large = 0;  ///< of arrays that may be in scratch files

  void Add(std::uint64_t bytes) {
    all += bytes;
    if (bytes >= kScratchMinBytes) large += bytes;
  }
};

/// Adds vectors that are filled.
template <typename... Vectors>
void AddFilled(ArrayBytes* to, const Vectors&... vectors) {
  (to->Add(vectors.size() * sizeof(vectors[0])), ...);
}

/// Adds vectors that will be filled with so many elements.
template <typename... Vectors>
void AddPlanned(std::uint64_t count, ArrayBytes* to, const Vectors&... vectors) {
  (to->Add(count * sizeof(vectors[0])), ...);
}

void AddAsRead(const Looks& looks, ArrayBytes* to) {
  AddFilled(to, looks.offsets);
  Looks::ForColumns([&](const char*, auto column, auto...) { AddFilled(to, looks.*column); });
}

void AddAsRead(const Points& points, ArrayBytes* to) { AddFilled(to, points.role, points.given_m); }

ArrayBytes LooksBytes(const AdjustmentProblem& problem, const AdjustOptions& options) {
  const Looks& looks = problem.block.looks;
  const std::uint64_t count = looks.size();
  const LookResults results;
  const LookQuality quality;
  ArrayBytes bytes;
  AddAsRead(looks, &bytes);
  AddFilled(&bytes, problem.look_used, problem.weights);
  AddPlanned(count, &bytes, results.range_residual_m, results.azimuth_residual_m, results.rejected);
  if (options.robust != RobustLoss::kNone) AddPlanned(count, &bytes, results.weight);
  if (options.covariance != CovarianceLevel::kNone) {
    for (const std::size_t k : {0U, 1U}) {
      AddPlanned(count, &bytes, quality.redundancy[k], quality.w[k], quality.shift_m[k]);
    }
  }
  return bytes;
}

ArrayBytes PointsBytes(const AdjustmentProblem& problem, const AdjustOptions& options) {
  const Points& points = problem.block.points;
  const std::uint64_t count = points.size();
  const PointResults results;
  const BlockState state;
  ArrayBytes bytes;
  AddAsRead(points, &bytes);
  AddFilled(
      &bytes, problem.point_status, problem.point_reason, problem.mirrored, problem.control_of);
  AddPlanned(count,
             &bytes,
             state.start_m,
             state.displacement_m,
             results.status,
             results.looks,
             results.position_m,
             results.intersection_rad);
  if (options.covariance != CovarianceLevel::kNone) {
    AddPlanned(count, &bytes, results.covariance_m2, results.fixed_path_covariance_m2);
    for (const auto figure : kAccuracyFigures) AddPlanned(count, &bytes, results.*figure);
  }
  return bytes;
}

std::uint64_t Doubles(std::size_t count) { return sizeof(double) * count; }

}  // namespace

ResourceNeeds PredictNeeds(const AdjustmentProblem& problem,
                           const AdjustOptions& options,
                           ReducedSystem* system) {
  const SystemNeeds system_needs = system->Needs(options.threads);
  const FactorNeeds& factor = system_needs.factor;
  ResourceNeeds needs;
  const bool scratch = ScratchScope::Current() != nullptr;
  const ArrayBytes looks = LooksBytes(problem, options);
  const ArrayBytes points = PointsBytes(problem, options);
  ArrayBytes block;
  AddAsRead(problem.block.looks, &block);
  AddAsRead(problem.block.points, &block);
  needs.looks_bytes = looks.all;
  needs.points_bytes = points.all;
  needs.large_bytes = looks.large + points.large;
  needs.scratch_bytes = scratch ? needs.large_bytes : 0;
  needs.block_bytes = block.all - (scratch ? block.large : 0);
  needs.matrix_bytes = 2 * Doubles(system_needs.matrix + system_needs.border);
  needs.partial_sums_bytes = Doubles(system_needs.partial_sums);
  needs.factor_bytes = Doubles(factor.factor);
  needs.fronts_bytes = Doubles(factor.waiting);
  needs.sum_operations = system_needs.operations;
  needs.factor_operations = factor.operations;
  if (options.covariance == CovarianceLevel::kBlock ||
      options.covariance == CovarianceLevel::kMonteCarlo) {
    needs.inverse_bytes =
        Doubles(system_needs.matrix + system_needs.border + factor.inverse_fronts);
  }
  needs.peak_bytes = needs.looks_bytes + needs.points_bytes - needs.scratch_bytes +
                     needs.matrix_bytes + needs.factor_bytes +
                     std::max({needs.partial_sums_bytes, needs.fronts_bytes, needs.inverse_bytes});
  return needs;
}

std::string ProblemOfMemory(const ResourceNeeds& needs, const AdjustOptions& options) {
  const bool asked = options.memory_mib > 0.0;
  if (!asked && needs.peak_bytes <= kAlwaysThere) return {};
  // The block itself is in memory already.
  const std::uint64_t more = asked ? needs.peak_bytes : needs.peak_bytes - needs.block_bytes;
  const double limit_mib = asked ? options.memory_mib : AvailableMemory_bytes() / kMiB;
  if (static_cast<double>(more) <= limit_mib * kMiB) return {};
  std::string text = "the adjustment needs " + Mebibytes(static_cast<double>(more)) + " MiB" +
                     (asked ? "" : " more than the block as it was read") + ", " +
                     Mebibytes(limit_mib * kMiB) + " MiB are " + (asked ? "allowed" : "free") +
                     ": " + DescribeNeeds(needs) +
                     "; less is needed with fewer parameters per pass";
  if (options.covariance != CovarianceLevel::kNone) text += ", with covariance = \"none\"";
  if (needs.large_bytes > needs.scratch_bytes) {
    text += ", with looks and points in files (--scratch)";
  }
  text += " or for a part of the block; --memory sets another limit";
  return text;
}

}  // namespace sarblock
