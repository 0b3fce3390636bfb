// SPDX-License-Identifier: Apache-2.0
#include "solve_block.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/threads.h"
#include "rank.h"
#include "reduced_engine.h"

namespace sarblock {
namespace {

/// Least part of its looks that such a pass loses, and how much more often than the others: matches
/// of one image are worse than those of another.
constexpr double kMinPart = 0.2, kMoreOften = 2.0;

}  // namespace

std::vector<PassLooks> CountPassLooks(const Block& block,
                                      const std::vector<std::uint8_t>& look_used) {
  const Looks& looks = block.looks;
  std::vector<PassLooks> by_pass(block.passes.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    std::size_t given = 0;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      given += looks.rejected(i) ? 0U : 1U;
    }
    if (given < 2) continue;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (looks.rejected(i)) continue;
      PassLooks& of_pass = by_pass[looks.pass[i]];
      const bool kept = look_used[i] != 0;
      ++(kept ? of_pass.all.kept : of_pass.all.lost);
      if (given > 2) ++(kept ? of_pass.deciding.kept : of_pass.deciding.lost);
    }
  }
  return by_pass;
}

std::optional<std::size_t> UndecidedPass(const std::vector<PassLooks>& by_pass) {
  for (std::size_t pass = 0; pass < by_pass.size(); ++pass) {
    if (!by_pass[pass].deciding.Decide()) return pass;
  }
  return std::nullopt;
}

std::optional<std::size_t> PassThatLosesMore(const std::vector<PassLooks>& by_pass, double chance) {
  LookCounts all;
  for (const PassLooks& of_pass : by_pass) {
    all.kept += of_pass.deciding.kept;
    all.lost += of_pass.deciding.lost;
  }
  const double level = chance / static_cast<double>(std::max<std::size_t>(1, by_pass.size()));
  for (std::size_t pass = 0; pass < by_pass.size(); ++pass) {
    const LookCounts& own = by_pass[pass].deciding;
    const auto lost = static_cast<double>(own.lost), kept = static_cast<double>(own.kept);
    const double others_lost = static_cast<double>(all.lost) - lost;
    const double others_kept = static_cast<double>(all.kept) - kept;
    // One look more of each kind: a frequency of 0 is not known from any number of looks.
    const double frequency = (others_lost + 1.0) / (others_lost + others_kept + 2.0);
    if (own.LostShare() < std::max(kMinPart, kMoreOften * frequency)) continue;
    const double odds = frequency / (1.0 - frequency);
    // P(X >= l) of n = l + k binomial trials by the F distribution (Abramowitz and Stegun (1964),
    // 26.5.24 and 26.6.2).
    const double tail =
        FisherTailProbability(lost / ((kept + 1.0) * odds), 2.0 * (kept + 1.0), 2.0 * lost);
    if (tail < level) return pass;
  }
  return std::nullopt;
}

namespace {

/// Newton decrement, in sigmas over all unknowns together, at which a solution under a loss is
/// done, and the change of weights below which it is. It decides which looks stay, nothing else:
/// residuals are known to a thousandth of their sigma. Further steps would creep over places where
/// the loss is flat, such as two looks that contradict each other.
constexpr double kLossSettled = 1e-3;
constexpr double kWeightsSettled = 1e-3;
/// Newton decrement, in sigmas over all unknowns together, at which a solver without a loss hands
/// over to the finishing Newton steps; they start from up to ten times as much.
constexpr double kApproached = 1.0;
/// The same of the damped solution of the second round; whole steps are then tried again. Later
/// rounds go to the end.
constexpr double kNearEnough = 0.1;
/// Part of a step of the anchors by which a time bias may leave the interval around its anchor
/// before the looks are read anew: at first, and once they were read near the solution.
constexpr double kAnchorSlack = 0.25, kLateAnchorSlack = 30.0;
constexpr int kMaxFinishingSteps = 25;
constexpr int kMaxRounds = 5;
/// Rounds of leaving out mirror solutions and taking back points that fit then.
constexpr int kMaxRecoveries = 10;
/// Probability of v'Pv with which the looks of a point still agree.
constexpr double kAgree = 0.999;

/// A point's looks on the fixed corrected paths.
std::vector<FixedPathLook> FixPaths(const AdjustmentProblem& problem,
                                    const BlockState& state,
                                    std::size_t point) {
  std::vector<FixedPathLook> observations;
  const auto& offsets = problem.block.looks.offsets;
  for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    if (const auto observation = problem.model.FixPath(i, state.corrections))
      observations.push_back(*observation);
  }
  return observations;
}

}  // namespace

bool NewtonFinish(const AdjustOptions& options,
                  AdjustmentProblem* problem,
                  BlockState* state,
                  ReducedSystem* system,
                  SolveReport* solve,
                  ProgressSink* progress) {
  SolveOptions finish;
  finish.undamped = true;
  finish.curved = solve->curved;
  finish.max_iterations =
      std::clamp(options.max_iterations - solve->iterations, 0, kMaxFinishingSteps);
  finish.settle_below = ToleranceFor(options.tolerance, *problem);
  const SolveReport report =
      SolveReduced(*problem, {.renewed = &problem->weights}, finish, system, state, progress);
  solve->iterations += report.iterations;
  solve->final_cost = report.final_cost;
  solve->curved = solve->curved || report.curved;
  solve->message = report.message;
  if (report.iterations > 0 || !report.held_by.empty()) solve->held_by = report.held_by;
  solve->decrement = report.decrement;
  if (!report.formed_at_state) system->Form(*state, {}, progress);
  return system->looks_not_evaluated() == 0 && system->weak_points().empty() &&
         system->FactorDamped();
}

namespace {

/// One part of a solution after those before it.
void AddTo(const SolveReport& part, SolveReport* total) {
  if (total->iterations == 0) total->initial_cost = part.initial_cost;
  total->iterations += part.iterations;
  total->curved = total->curved || part.curved;
  total->converged = part.converged;
  if (part.formed > 0) total->damping = part.damping;
  total->final_cost = part.final_cost;
  total->message = part.message;
  total->held_by = part.held_by;
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
  const bool formed = system.has_value();
  if (formed) {
    system->KeepFactors(KeptFactors::kMaxBytes);
  } else {
    system.emplace(*problem, KeptFactors::kMaxBytes);
  }
  Weighting weighted = weighting;
  if (least_squares) weighted.renewed = &problem->weights;
  bool finished = false;  // at the places where the paths were read
  for (int round = 0; round < kMaxRounds; ++round) {
    SolveOptions solve;
    solve.curved = total.curved;
    solve.max_iterations = std::max(1, allowed - total.iterations);
    solve.threads = options.threads;
    solve.damping = total.damping;
    // The engine that was asked for comes near; what is left is the reduced engine's: least squares
    // are finished by steps that need no damping, a loss by second derivatives.
    const bool approach = round == 0;
    solve.formed = formed && approach && least_squares && !ceres;
    const double near_enough = !least_squares ? kLossSettled : round == 1 ? kNearEnough : 0.0;
    solve.settle_below = approach ? kApproached : std::max(options.tolerance, near_enough);
    solve.take_last_step = approach && least_squares;
    solve.ceres_solver = options.ceres_solver;
    bool comes_near = !finished;
    if (approach && ceres) {
      const SolveReport report = SolveWithCeres(*problem, weighting, solve, state, progress);
      AddTo(report, &total);
      // Ceres has no second derivatives: what creeps without them is the reduced engine's.
      comes_near = report.creeps;
      solve.max_iterations = std::max(1, allowed - total.iterations);
    }
    if (comes_near) {
      AddTo(SolveReduced(*problem, weighted, solve, &*system, state, progress), &total);
    }
    if (least_squares) {
      if (round == 0) problem->model.Anchor(state->corrections);
      const bool factored = NewtonFinish(options, problem, state, &*system, &total, progress);
      if (factored) {
        total.converged = total.decrement <= std::max(options.tolerance, kRemainingStepAccepted);
      }
      finished = factored && total.converged;
      if (total.iterations >= allowed) {
        if (!total.converged) total.message = LimitReached(options.max_iterations);
        break;
      }
      if (round + 1 == kMaxRounds) break;
      const double slack = round == 0 ? kAnchorSlack : kLateAnchorSlack;
      if (problem->model.Anchor(state->corrections, slack)) continue;
      if (finished || round > 1) break;
      continue;
    }
    const double change = UpdateWeights(*state, problem);
    if (!total.converged) break;
    if (approach && total.iterations >= allowed) {
      total.converged = false;
      total.message = LimitReached(options.max_iterations);
    }
    if (total.iterations >= allowed) break;
    if (!approach && change <= kWeightsSettled) break;
  }
  if (!least_squares && solved != nullptr) system->Form(*state, {}, progress);
  return total;
}

double NewtonDecrementUnderLoss(const Weighting& weighting,
                                const AdjustmentProblem& problem,
                                const BlockState& state,
                                ProgressSink* progress) {
  ReducedSystem system(problem);
  system.Form(state, weighting, progress);
  return system.looks_not_evaluated() == 0 && system.FactorDamped()
             ? system.NewtonDecrement()
             : std::numeric_limits<double>::infinity();
}

std::vector<std::size_t> MirrorSolutions(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const ReducedSystem& system) {
  const std::size_t points = problem.block.points.size();
  std::vector<std::uint8_t> lost(points, 0);
  for (const WeakPoint& weak : system.weak_points()) lost[weak.point] = 1;
  const auto& offsets = problem.block.looks.offsets;
  const auto look_for_lost = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point) || problem.control_of[point] >= 0 || lost[point] != 0) continue;
      const Eigen::Vector3d p_m = state.Position(point);
      for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
        if (problem.look_used[i] == 0) continue;
        const std::optional<FixedPathLook> observation =
            problem.model.FixPath(i, state.corrections);
        if (observation && !LiesWhereItLooks(problem.block.frame, *observation, p_m))
          lost[point] = 1;
      }
    }
  };
  ForChunksOfRanks(points, 1024, {SharedArray::ByItem(&lost)}, look_for_lost);
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
               std::optional<ReducedSystem>* system,
               ProgressSink* progress) {
  const SolveReport before = *solve;
  if (system != nullptr) system->reset();  // that of another state
  *solve = SolveRounds(
      {options.robust, RobustScale(options)}, options, problem, state, progress, system);
  solve->iterations += before.iterations;
  solve->initial_cost = before.initial_cost;
}

bool Agree(const std::vector<FixedPathLook>& looks, const Intersection& met, const Frame& frame) {
  const double freedom = 2.0 * static_cast<double>(looks.size()) - 3.0;
  return met.outcome == IntersectionOutcome::kDetermined &&
         met.weighted_square_sum <= ChiSquareQuantile(kAgree, freedom) &&
         std::all_of(looks.begin(), looks.end(), [&](const FixedPathLook& look) {
           return LiesWhereItLooks(frame, look, met.position_m);
         });
}

bool TakeBack(std::size_t point, AdjustmentProblem* problem, BlockState* state) {
  const Block& block = problem->block;
  if (problem->Solves(point) || problem->control_of[point] >= 0) return false;
  std::vector<FixedPathLook> observations;
  std::vector<std::size_t> looks;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i)) continue;
    if (const auto observation = problem->model.FixPath(i, state->corrections)) {
      observations.push_back(*observation);
      looks.push_back(i);
    }
  }
  if (observations.size() < 2) return false;
  const Intersection met = Intersect(observations, block.frame);
  if (!Agree(observations, met, block.frame)) {
    // What a search for blunders said of the point stays.
    if (problem->point_status[point] == PointStatus::kUndetermined &&
        met.outcome == IntersectionOutcome::kCirclesDoNotMeet) {
      problem->point_reason[point] = Explain(met.outcome);
    }
    return false;
  }
  problem->TakeBack(point, looks);
  state->start_m[point] = met.position_m;
  state->displacement_m[point].setZero();
  return true;
}

void RecoverMirrorSolutions(const AdjustOptions& options,
                            AdjustmentProblem* problem,
                            BlockState* state,
                            SolveReport* solve,
                            std::optional<ReducedSystem>* system,
                            PointDefects* defects,
                            ProgressSink* progress) {
  const auto solve_again = [&] {
    UpdateWeights(*state, problem);
    SolveOnce(options, problem, state, solve, system, progress);
  };
  std::vector<std::uint8_t> tried(problem->block.points.size(), 0);
  // Ends: a point is taken back once.
  for (int pass = 0; pass < kMaxRecoveries; ++pass) {
    std::vector<std::size_t> lost = MirrorSolutions(*problem, *state, **system);
    // Each round also mends the corrections that mirror solutions have distorted.
    for (int round = 0; round < 3 && !lost.empty(); ++round) {
      for (const std::size_t point : lost) {
        const Intersection met = Intersect(FixPaths(*problem, *state, point), problem->block.frame);
        if (met.outcome == IntersectionOutcome::kTooFewLooks) continue;
        state->start_m[point] = met.position_m;
        state->displacement_m[point].setZero();
      }
      SolveOnce(options, problem, state, solve, system, progress);
      lost = MirrorSolutions(*problem, *state, **system);
    }
    *defects = FindPointDefects(*problem, *state);
    bool left_out = LeaveOutOpenPoints(*defects, problem);
    for (const std::size_t point : lost) {
      if (!problem->Solves(point)) continue;
      const std::vector<FixedPathLook> observations = FixPaths(*problem, *state, point);
      const bool mirrored = std::any_of(
          observations.begin(), observations.end(), [&](const FixedPathLook& observation) {
            return !LiesWhereItLooks(problem->block.frame, observation, state->Position(point));
          });
      if (!mirrored || problem->control_of[point] >= 0) continue;  // weak points are named later
      problem->LeaveOutMirrorSolution(point);
      left_out = true;
    }
    if (left_out) {
      RequireSolvable(*problem);
      solve_again();
    }
    bool back = false;
    for (std::size_t point = 0; point < tried.size(); ++point) {
      if (problem->point_status[point] != PointStatus::kUndetermined || tried[point] != 0) continue;
      if (!TakeBack(point, problem, state)) continue;
      tried[point] = 1;
      back = true;
    }
    if (back) solve_again();
    if (!left_out && !back) return;
  }
}

std::vector<std::size_t> LeaveOutBeyondPaths(const BlockState& state, AdjustmentProblem* problem) {
  std::vector<std::size_t> out;
  LookEvaluation at;
  const auto& offsets = problem->block.looks.offsets;
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem->look_used[i] == 0) continue;
      if (!EvaluateErrors(problem->model, state, point, i, &at)) continue;
      if (!at.beyond_path) continue;
      problem->look_used[i] = 0;
      out.push_back(i);
    }
  }
  return out;
}

}  // namespace sarblock
