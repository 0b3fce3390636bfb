// SPDX-License-Identifier: Apache-2.0
#include "reduced_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "normals/back.h"
#include "normals/reduced_system.h"

namespace sarblock {

void StepHistory::Add(const Eigen::VectorXd& moved,
                      const Eigen::VectorXd& change,
                      const Eigen::VectorXd& weight) {
  if (!(moved.squaredNorm() > 0.0) || !change.allFinite()) return;
  unit_ = weight.cwiseSqrt();
  contraction_1_ = unit_.cwiseProduct(moved + change).norm() / unit_.cwiseProduct(moved).norm();
  differences_.push_front({moved, change});
  if (differences_.size() > kMost) differences_.pop_back();
}

Eigen::VectorXd StepHistory::Accelerate(const Eigen::VectorXd& step) const {
  // A difference of which less than this part is new beside newer ones adds nothing.
  constexpr double kLeastNew_1 = 1e-8;
  if (differences_.empty()) return step;
  Eigen::VectorXd rest = unit_.cwiseProduct(step);
  Eigen::VectorXd out = step;
  // Gram-Schmidt; each basis vector with the move that belongs to it.
  std::vector<Eigen::VectorXd> basis, moves;
  for (const Difference& difference : differences_) {
    Eigen::VectorXd column = unit_.cwiseProduct(difference.change);
    Eigen::VectorXd move = difference.moved + difference.change;
    const double length = column.norm();
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < basis.size(); ++k) {
        const double along = basis[k].dot(column);
        column -= along * basis[k];
        move -= along * moves[k];
      }
    }
    const double left = column.norm();
    if (!(left > kLeastNew_1 * length)) continue;
    basis.emplace_back(column / left);
    moves.emplace_back(move / left);
    const double theta = basis.back().dot(rest);
    rest -= theta * basis.back();
    out -= theta * moves.back();
  }
  return out.allFinite() ? out : step;
}

double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem) {
  const double share_1 = 1e-3 * static_cast<double>(problem.block.points.size());
  return tolerance_1 * std::clamp(share_1, 1e-2, 1.0);
}

const char kStagnates[] =
    "the steps no longer shrink, more iterations would not end it (contradicting observations, "
    "start values too far off, or corrections that are hardly determined)";

std::string LimitReached(int max_iterations) {
  return "the steps still shrank when max_iterations = " + std::to_string(max_iterations) +
         " ended them; raise it";
}

bool ProgressOfSteps::Stagnates(int iteration, double cost_1, double decrement_1) {
  constexpr int kWindow = 50;
  if (iteration < iteration_ + kWindow) return false;
  const bool shrinks = cost_1 < 0.999 * cost_1_ || decrement_1 < 0.5 * decrement_1_;
  iteration_ = iteration;
  cost_1_ = cost_1;
  decrement_1_ = decrement_1;
  return !shrinks;
}

Engine Resolve(Engine asked) { return asked == Engine::kAuto ? Engine::kReduced : asked; }

CovarianceMethod Resolve(CovarianceMethod asked) {
  return asked == CovarianceMethod::kAuto ? CovarianceMethod::kReduced : asked;
}

CeresSolver Resolve(CeresSolver asked, int corrections) {
  /// Above, a sparse reduced matrix is faster.
  constexpr int kMostDense = 600;
  if (asked != CeresSolver::kAuto) return asked;
  return corrections <= kMostDense ? CeresSolver::kDenseSchur : CeresSolver::kSparseSchur;
}

namespace {

constexpr double kFirstDamping_1 = 1e-8;
constexpr double kLeastDamping_1 = 1e-12;
constexpr double kMostDamping_1 = 1e12;
constexpr double kNear_1 = 0.5;
/// Changes of the cost below this part of it may be rounding: residuals of a sigma with an error of
/// 1e-12 m in ranges of 1e4 m make 1e-13 of it, with 1e-9 m in ranges of 1e6 m 1e-10.
constexpr double kUnclear_1 = 1e-9;
/// The same while weights are formed anew with each state.
constexpr double kUnclearRenewed_1 = 1e-5;
/// Whole steps are compared by costs of the same weights. From the first of these Newton decrements
/// on weights follow and steps are compared by their length; weights of a state with the second or
/// less, or with that at which the solution is done, are kept: what is left moves none by 1e-7 of
/// itself, a body of some hundred metres included.
constexpr double kWeightsFollow_1 = 0.1;
constexpr double kWeightsKept_1 = 1e-6;
/// A step below this is near enough to its end to be left alone where nothing shrinks any more.
constexpr double kSettledAnyway_1 = 1e-6;
/// A step must take this part of what it promises off the cost.
constexpr double kLeastGain_1 = 0.1;
/// Newton decrement, in sigmas over all unknowns, from which on steps are accelerated; trials with
/// what refused ones have taught before more damping is tried.
constexpr double kAccelerated_1 = 10.0;
constexpr int kMostSecantTrials = 2;
/// A step that leaves more than this part of the one before shows a direction that creeps.
constexpr double kSlow_1 = 0.3;
/// Shorter steps are too near rounding to say how the equations bend.
constexpr double kLeastLearned_1 = 1e-5;
/// Own steps of points that are left to the step of all unknowns, as a part of that step's share of
/// a point, in sigmas.
constexpr double kOwnStepPart_1 = 0.3;
constexpr double kLeastOwnStep_1 = 1e-8;
/// Of what is left behind a step no more is said than a hundred times its length.
constexpr double kMostContraction_1 = 0.99;
/// Where v'Pv has a limit: steps before it is asked for, and how far one step is trusted.
constexpr int kLeastSteps = 3;
constexpr double kPromised_1 = 4.0;

std::string Rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", value);
  return text.data();
}

double OwnStepOf(double decrement_1, const AdjustmentProblem& problem) {
  const auto points = static_cast<double>(problem.block.points.size());
  return std::clamp(
      kOwnStepPart_1 * decrement_1 / std::sqrt(points), kLeastOwnStep_1, kMostOwnStep_1);
}

/// Why a solution stopped early. Looks without a value refuse steps: that is said, its cure is not
/// more iterations.
std::string WhyStopped(const char* reason, int refused) {
  std::string text = reason;
  if (refused > 0) {
    text += "; " + std::to_string(refused) +
            " steps were refused because looks have no value there (a flight path too short for a "
            "time bias, or a sight line that does not come from above)";
  }
  return text;
}

}  // namespace

SolveReport SolveReduced(const AdjustmentProblem& problem,
                         const Weighting& weighting,
                         const SolveOptions& options,
                         BlockState* state,
                         ProgressSink* progress) {
  ReducedSystem system(problem);
  return SolveReduced(problem, weighting, options, &system, state, progress);
}

namespace {

/// One state of the solution: its Newton step of the corrections, and how long the step of all
/// unknowns is.
struct Newton {
  Eigen::VectorXd step;
  double decrement_1 = 0.0;
};

}  // namespace

SolveReport SolveReduced(const AdjustmentProblem& problem,
                         const Weighting& asked,
                         const SolveOptions& options,
                         ReducedSystem* formed,
                         BlockState* state,
                         ProgressSink* progress) {
  SolveReport report;
  ReducedSystem& system = *formed;
  // Reweighting brings a solution near from anywhere and then creeps; second order finishes it.
  Weighting weighting = asked;
  double damping = options.undamped ? 0.0 : kFirstDamping_1;
  double settled_1 = kMostOwnStep_1;
  int refused = 0;
  std::string left_text;
  ProgressOfSteps steps_so_far;
  StepHistory history;
  Newton newton;
  const auto form = [&](BlockState* at, double with_damping) {
    if (options.points_follow) {
      system.FormSettled(weighting, with_damping, settled_1, at, nullptr);
    } else {
      system.Form(*at, weighting, nullptr, with_damping);
    }
    ++report.formed;
  };
  const auto solve = [&](Newton* out) {
    const bool rank = options.undamped && !system.weak_points().empty();
    if (rank || !system.FactorDamped()) return false;
    out->step = system.Step();
    out->decrement_1 = system.NewtonDecrement(out->step);
    return std::isfinite(out->decrement_1);
  };
  // Forms the state as it is and its step, damped as much as that takes.
  const auto restart = [&] {
    history.Clear();
    report.formed_at_state = true;
    form(state, damping);
    while (!solve(&newton)) {
      damping *= 10.0;
      if (options.undamped || damping > kMostDamping_1 || report.formed >= options.max_formed) {
        return false;
      }
      form(state, damping);
    }
    return true;
  };
  const bool starts = restart();
  report.initial_cost_1 = report.final_cost_1 = system.cost();
  if (!starts) {
    report.message = "the equations at the start cannot be solved";
    return report;
  }
  int refused_in_turn = 0;
  bool slow = false;
  // Newton decrement where the weights of whole steps were formed.
  double weights_at_1 = asked.renewed == nullptr ? 0.0 : newton.decrement_1;
  for (int trial = 0; trial <= 4 * options.max_iterations; ++trial) {
    Step(progress,
         "solve",
         static_cast<std::size_t>(report.iterations),
         static_cast<std::size_t>(options.max_iterations),
         "cost " + std::to_string(report.final_cost_1) + left_text);
    const double left = newton.decrement_1;
    left_text = ", newton decrement " + Rounded(left) + " sigmas";
    if (weighting.loss != RobustLoss::kNone && !weighting.second_order && left <= kNear_1) {
      weighting.second_order = true;
      if (!restart()) break;
      continue;
    }
    // Where large residuals meet bent equations each step is a part of the one before: what is left
    // is the sum of all to come.
    report.decrement_1 = left / (1.0 - std::min(history.contraction(), kMostContraction_1));
    const bool settled = report.decrement_1 <= options.settled_1 ||
                         (left <= options.settled_1 && refused_in_turn > 0);
    if (settled && options.undamped && weights_at_1 > std::max(kWeightsKept_1, options.settled_1)) {
      weighting.renewed = asked.renewed;
      weights_at_1 = left;
      if (!restart()) break;
      continue;
    }
    if (settled) {
      report.converged = true;
      report.message = "the Newton decrement is " + Rounded(left) + " sigmas";
      if (options.take_last_step && report.iterations < options.max_iterations) {
        state->displacement_m =
            SubstituteBack(problem, *state, weighting, damping, newton.step).displacement_m;
        state->corrections += newton.step;
        report.formed_at_state = false;
        ++report.iterations;
      }
      return report;
    }
    if (report.iterations >= options.max_iterations) break;
    if (report.formed >= options.max_formed) break;
    const bool gives_up =
        report.formed > kLeastSteps &&
        2.0 * report.final_cost_1 - kPromised_1 * left * left > options.useless_above_1;
    if (gives_up) {
      report.message = "no step promises a v'Pv that is of use";
      return report;
    }
    if (steps_so_far.Stagnates(report.iterations, report.final_cost_1, left)) {
      report.message = WhyStopped(kStagnates, refused);
      return report;
    }
    const bool accelerated =
        left <= kAccelerated_1 && history.size() > 0 && (slow || refused_in_turn > 0);
    const Eigen::VectorXd dx = accelerated ? history.Accelerate(newton.step) : newton.step;
    PointSteps steps = SubstituteBack(problem, *state, weighting, damping, dx);
    const double predicted =
        accelerated ? 0.5 * left * left : steps.predicted_decrease_1 + system.PredictedDecrease(dx);
    BlockState next;
    next.displacement_m = std::move(steps.displacement_m);
    next.corrections = state->corrections + dx;
    next.start_m.swap(state->start_m);
    const double next_damping = options.undamped ? 0.0 : std::max(kLeastDamping_1, 0.1 * damping);
    if (options.undamped) {
      const bool follow = left <= kWeightsFollow_1 && weights_at_1 > kWeightsKept_1;
      weighting.renewed = follow ? asked.renewed : nullptr;
    }
    settled_1 = OwnStepOf(left, problem);
    form(&next, next_damping);
    next.start_m.swap(state->start_m);
    const double gain = report.final_cost_1 - system.cost();
    const bool valid = system.looks_not_evaluated() == 0 && std::isfinite(system.cost());
    Newton there;
    const bool solved = valid && solve(&there);
    // A gain of less than the cost's own rounding is no evidence; the step that is left keeps the
    // digits that the cost has lost.
    const bool other_weights = options.undamped && weighting.renewed != nullptr;
    const double unclear_1 = weighting.renewed == nullptr ? kUnclear_1 : kUnclearRenewed_1;
    const bool unclear = other_weights || std::abs(gain) <= unclear_1 * report.final_cost_1 + 1e-12;
    const bool better =
        solved && (unclear ? there.decrement_1 < left : gain > kLeastGain_1 * predicted);
    if (solved && left > kLeastLearned_1)
      history.Add(dx, there.step - newton.step, system.full_diagonal());
    if (better) {
      state->displacement_m.swap(next.displacement_m);
      state->corrections = next.corrections;
      report.final_cost_1 = system.cost();
      report.formed_at_state = true;
      damping = next_damping;
      slow = slow || there.decrement_1 > kSlow_1 * left;
      if (weighting.renewed != nullptr) weights_at_1 = there.decrement_1;
      newton = std::move(there);
      ++report.iterations;
      refused_in_turn = 0;
      continue;
    }
    report.formed_at_state = false;
    if (system.looks_not_evaluated() > 0) ++refused;
    ++refused_in_turn;
    // What was learned of the equations there may give a better step from here.
    if (solved && left <= kAccelerated_1 && refused_in_turn <= kMostSecantTrials) continue;
    if (unclear && left <= kSettledAnyway_1) {
      report.converged = true;
      report.message = "the step left is " + Rounded(left) + " sigmas, no more than rounding";
      return report;
    }
    if (options.undamped) {
      report.message = WhyStopped(
          ("a whole Newton step, " + Rounded(left) + " sigmas long, does not lower the cost")
              .c_str(),
          refused);
      return report;
    }
    damping *= 10.0;
    if (damping > kMostDamping_1) {
      report.message = WhyStopped("no step lowers the cost", refused);
      return report;
    }
    if (!restart()) break;
  }
  report.message = WhyStopped(LimitReached(options.max_iterations).c_str(), refused);
  return report;
}

BlockState AfterNewtonStep(const AdjustmentProblem& problem,
                           const BlockState& state,
                           const Eigen::VectorXd& dx) {
  BlockState next;
  next.start_m = state.start_m;
  next.displacement_m = SubstituteBack(problem, state, {}, 0.0, dx).displacement_m;
  next.corrections = state.corrections + dx;
  return next;
}

}  // namespace sarblock
