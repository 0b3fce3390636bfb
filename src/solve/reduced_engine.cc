// SPDX-License-Identifier: Apache-2.0
#include "reduced_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "normals/back.h"
#include "normals/reduced_system.h"

namespace sarblock {

double ToleranceFor(double tolerance, const AdjustmentProblem& problem) {
  const double share = 1e-3 * static_cast<double>(problem.block.points.size());
  return tolerance * std::clamp(share, 1e-2, 1.0);
}

const char kStagnates[] =
    "the steps no longer shrink, more iterations would not end it (contradicting observations, "
    "start values too far off, or corrections that are hardly determined)";

std::string LimitReached(int max_iterations) {
  return "the steps still shrank when max_iterations = " + std::to_string(max_iterations) +
         " ended them; raise it";
}

bool ProgressOfSteps::Stagnates(int iteration, double cost, double decrement) {
  constexpr int kWindow = 50;
  if (iteration < iteration_ + kWindow) return false;
  const bool shrinks = cost < 0.999 * cost_ || decrement < 0.5 * decrement_;
  iteration_ = iteration;
  cost_ = cost;
  decrement_ = decrement;
  return !shrinks;
}

Engine Resolve(Engine asked) { return asked == Engine::kAuto ? Engine::kReduced : asked; }

CovarianceMethod Resolve(CovarianceMethod asked) {
  return asked == CovarianceMethod::kAuto ? CovarianceMethod::kReduced : asked;
}

CeresSolver Resolve(CeresSolver asked, int corrections) {
  /// Above, a sparse reduced matrix is faster.
  constexpr int kMaxDense = 600;
  if (asked != CeresSolver::kAuto) return asked;
  return corrections <= kMaxDense ? CeresSolver::kDenseSchur : CeresSolver::kSparseSchur;
}

namespace {

constexpr double kFirstDamping = 1e-8;
constexpr double kMinDamping = 1e-12;
constexpr double kMaxDamping = 1e12;
/// The most damping that a part of a solution takes over from the one before: a larger one is left
/// where no step lowered the cost, and says nothing of the next steps.
constexpr double kMaxKeptDamping = 1e-2;
constexpr double kNear = 0.5;
/// Changes of the cost below this part of it may be rounding: residuals of a sigma with an error of
/// 1e-12 m in ranges of 1e4 m make 1e-13 of it, with 1e-9 m in ranges of 1e6 m 1e-10.
constexpr double kUnclear = 1e-9;
/// Weights that a step changes by no more than this part of them are kept; where later steps creep
/// they are formed once more at the end.
constexpr double kWeightsKept = 1e-9;
/// A step below this is near enough to its end to be left alone where nothing shrinks any more.
constexpr double kSettledAnyway = 1e-6;
/// A step must take this part of what it promises off the cost. One that achieves the second part
/// could have been damped less.
constexpr double kMinGain = 0.1;
constexpr double kKept = 0.75;
/// Newton decrement, in sigmas over all unknowns, from which on second derivatives are taken into
/// account where steps creep: farther off they often leave no minimum.
constexpr double kCurved = 3.0;
/// Most that a step may bend (BendOfStep), as a part of its length: with more it is longer than
/// its second order holds (Transtrum and Sethna 2012 ask for 0.375). Below the second part it is
/// straight again.
constexpr double kMaxBend = 0.5;
constexpr double kStraight = 0.01;
/// A step that leaves more than this part of the one before shows a direction that creeps.
constexpr double kSlow = 0.15;
/// Shorter steps are too near rounding to say whether they creep.
constexpr double kMinLearned = 1e-5;
/// Own steps of points that are left to the step of all unknowns, as a part of that step's share of
/// a point, in sigmas.
constexpr double kOwnStepPart = 0.3;
constexpr double kMinOwnStep = 1e-8;
/// Largest contraction that is assumed: the rest of the way counts as a hundred times the last step
/// at most.
constexpr double kMaxContraction = 0.99;
/// Where v'Pv has a limit: steps before it is asked for, and how far one step is trusted.
constexpr int kMinSteps = 3;
constexpr double kPromised = 4.0;

std::string Rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", value);
  return text.data();
}

double OwnStepOf(double decrement, const AdjustmentProblem& problem) {
  const auto points = static_cast<double>(problem.block.points.size());
  return std::clamp(kOwnStepPart * decrement / std::sqrt(points), kMinOwnStep, kMaxOwnStep);
}

/// Why a solution stopped early. Looks without a value refuse steps: that is said, its cure is not
/// more iterations.
std::string WhyStopped(const char* reason, int refused) {
  std::string text = reason;
  if (refused > 0) {
    text += "; " + std::to_string(refused) +
            " steps were refused because looks have no value there (a flight path too short for a "
            "time bias, or a line of sight that does not come from above)";
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
  double decrement = 0.0;
  double damping = 0.0;  ///< of the equations
  bool curved = false;   ///< second derivatives of the looks taken into account
};

/// Length of a step in units of what each correction would be known to alone.
double LengthOf(const Eigen::VectorXd& step, const ReducedSystem& system) {
  return system.full_diagonal().cwiseSqrt().cwiseProduct(step).norm();
}

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
  weighting.renewed = nullptr;  // but where the system is formed
  bool renews = asked.renewed != nullptr;
  double change = 0.0;  // of the weights, at the last state that was formed
  double& damping = report.damping;
  damping = options.undamped ? 0.0 : std::clamp(options.damping, kFirstDamping, kMaxKeptDamping);
  double settle_below = kMaxOwnStep;
  int refused = 0;
  std::string left_text;
  ProgressOfSteps steps_so_far;
  Newton newton;
  double contraction = 0.0;  // Newton decrement over that of the step before
  bool curved = false;
  bool plain = false;  // without second derivatives at the present state
  const auto form = [&](BlockState* at, double with_damping) {
    Weighting renewing = weighting;
    if (renews) renewing.renewed = asked.renewed;
    if (options.points_follow) {
      system.FormSettled(renewing, with_damping, settle_below, at, nullptr);
    } else {
      system.Form(*at, renewing, nullptr, with_damping);
    }
    change = std::max(change, system.weight_change());
    ++report.formed;
  };
  const auto solve = [&](double with_damping, Newton* out) {
    const bool rank = with_damping == 0.0 && !system.weak_points().empty();
    if (rank || !system.FactorDamped()) return false;
    out->step = system.Step();
    out->decrement = system.NewtonDecrement(out->step);
    out->damping = with_damping;
    out->curved = weighting.curved;
    return std::isfinite(out->decrement);
  };
  // Forms a state and solves it; where the second derivatives leave no minimum, without them.
  const auto form_and_solve = [&](BlockState* at, double with_damping, Newton* out) {
    change = 0.0;
    weighting.curved = curved && !plain;
    form(at, with_damping);
    if (solve(with_damping, out)) return true;
    if (!weighting.curved) return false;
    weighting.curved = false;
    form(at, with_damping);
    return solve(with_damping, out);
  };
  // Forms the state as it is and its step, damped as much as that takes.
  const auto restart = [&] {
    contraction = 0.0;
    while (!form_and_solve(state, damping, &newton)) {
      damping *= 10.0;
      if (options.undamped || damping > kMaxDamping || report.formed >= options.max_formed) {
        return false;
      }
    }
    report.formed_at_state = !newton.curved;
    report.final_cost = system.cost();  // weights and points may have followed
    return true;
  };
  bool crept_on = false;  // with weights that were kept
  const bool begun = options.formed && system.looks_not_evaluated() == 0 && solve(0.0, &newton);
  report.formed_at_state = begun;
  const bool starts = begun || restart();
  // Damped steps start with the weights of their first state.
  bool weights_follow = renews && (!options.undamped || change > kWeightsKept);
  report.initial_cost = report.final_cost = system.cost();
  if (!starts) {
    report.message = "the equations at the start cannot be solved";
    return report;
  }
  int refused_in_turn = 0;
  bool kept_promise = false;
  bool slow = false;
  bool bends = false;
  const bool least_squares = weighting.loss == RobustLoss::kNone;
  const bool can_bend = least_squares && problem.layout.size() > 0;
  for (int trial = 0; trial <= 4 * options.max_iterations; ++trial) {
    Step(progress,
         "solve",
         static_cast<std::size_t>(report.iterations),
         static_cast<std::size_t>(options.max_iterations),
         "cost " + std::to_string(report.final_cost) + left_text);
    weighting.curved = newton.curved;
    double left = newton.decrement;
    left_text = ", newton decrement " + Rounded(left) + " sigmas";
    if (weighting.loss != RobustLoss::kNone && !weighting.second_order && left <= kNear) {
      weighting.second_order = true;
      if (!restart()) break;
      continue;
    }
    // Where large residuals meet bent equations each step is a part of the one before: what is left
    // is the sum of all to come.
    report.decrement = left / (1.0 - std::min(contraction, kMaxContraction));
    const bool settled = report.decrement <= options.settle_below ||
                         (left <= options.settle_below && refused_in_turn > 0);
    if (settled && std::exchange(crept_on, false)) {
      renews = true;
      if (!restart()) break;
      weights_follow = change > kWeightsKept;
      if (weights_follow) continue;
      report.decrement = left = newton.decrement;
    }
    if (settled) {
      report.converged = true;
      report.message = "the Newton decrement is " + Rounded(left) + " sigmas";
      // One that creeps, or is short by its damping, may lead anywhere beyond what it promises.
      const bool safe = !slow && !curved && refused_in_turn == 0 && damping <= kFirstDamping;
      if (options.take_last_step && safe && report.iterations < options.max_iterations) {
        state->displacement_m =
            SubstituteBack(problem, *state, weighting, newton.damping, newton.step).displacement_m;
        state->corrections += newton.step;
        report.formed_at_state = false;
        ++report.iterations;
      }
      return report;
    }
    if (report.iterations >= options.max_iterations) break;
    if (report.formed >= options.max_formed) break;
    const bool gives_up = report.formed > kMinSteps &&
                          2.0 * report.final_cost - kPromised * left * left > options.useless_above;
    if (gives_up) {
      report.message = "no step promises a v'Pv that is of use";
      return report;
    }
    if (steps_so_far.Stagnates(report.iterations, report.final_cost, left)) {
      report.message = WhyStopped(kStagnates, refused);
      return report;
    }
    // Steps near rounding creep by it.
    const bool creeps = slow && left > kMinLearned;
    if ((creeps || options.curved) && least_squares && !curved && left <= kCurved) {
      report.curved = curved = true;
      slow = false;
      if (!restart()) break;
      continue;
    }
    const Eigen::VectorXd& dx = newton.step;
    PointSteps steps = SubstituteBack(problem, *state, weighting, newton.damping, dx);
    const double predicted = steps.predicted_decrease + system.PredictedDecrease(dx);
    BlockState next;
    next.displacement_m = std::move(steps.displacement_m);
    next.corrections = state->corrections + dx;
    double bend_part = 0.0;
    if (bends) {
      const Eigen::VectorXd bend =
          -system.SolveFor(BendOfStep(problem, *state, weighting, newton.damping, dx));
      bend_part = LengthOf(bend, system) / LengthOf(dx, system);
      if (bend_part <= kMaxBend) {
        next.corrections += bend;
      } else if (!options.undamped && damping < kMaxDamping) {
        ++refused_in_turn;
        damping *= 10.0;
        if (!restart()) break;
        continue;
      }
    }
    next.start_m.swap(state->start_m);
    // What was just found to be too little is not tried again at once.
    const double part = kept_promise ? 0.01 : 0.1;
    const double lower = refused_in_turn > 0 ? damping : part * damping;
    const double next_damping = options.undamped ? 0.0 : std::max(kMinDamping, lower);
    // Weights follow whole steps, and others that shrink by themselves.
    const bool shrinks = !slow && !curved && refused_in_turn == 0;
    renews = weights_follow && (options.undamped || shrinks);
    settle_below = OwnStepOf(left, problem);
    const bool was_plain = std::exchange(plain, false);
    Newton there;
    const bool factored = form_and_solve(&next, next_damping, &there);
    next.start_m.swap(state->start_m);
    const bool valid = system.looks_not_evaluated() == 0 && std::isfinite(system.cost());
    const bool solved = valid && factored;
    const double gain = report.final_cost - system.cost();
    // A gain of less than the cost's own rounding, or than what other weights may make of it, is no
    // evidence; the step that is left keeps the digits that the cost has lost.
    const bool unclear = (options.undamped && change > 0.0) ||
                         std::abs(gain) <= (kUnclear + 2.0 * change) * report.final_cost + 1e-12;
    const bool better = solved && (unclear ? there.decrement < left : gain > kMinGain * predicted);
    if (better) {
      state->displacement_m.swap(next.displacement_m);
      state->corrections = next.corrections;
      report.final_cost = system.cost();
      report.formed_at_state = !there.curved;
      damping = next_damping;
      kept_promise = refused_in_turn == 0 && gain >= kKept * predicted;
      slow = (slow && !curved) || there.decrement > kSlow * left;
      contraction = there.decrement / left;
      bends = can_bend && (slow || bend_part > kStraight);
      crept_on = options.undamped && asked.renewed != nullptr && !renews && (slow || crept_on);
      if (renews) weights_follow = change > kWeightsKept;
      newton = std::move(there);
      ++report.iterations;
      refused_in_turn = 0;
      continue;
    }
    plain = was_plain;
    kept_promise = false;
    report.formed_at_state = false;
    if (system.looks_not_evaluated() > 0) ++refused;
    ++refused_in_turn;
    // The same step again, along the curve that the equations bend it to.
    if (solved && can_bend && !std::exchange(bends, true)) {
      if (!restart()) break;
      continue;
    }
    // Second derivatives reach less far than first ones where they nearly cancel.
    if (newton.curved && !plain) {
      plain = true;
      if (!restart()) break;
      continue;
    }
    if (unclear && left <= kSettledAnyway) {
      report.converged = true;
      report.message =
          "the Newton decrement is " + Rounded(left) + " sigmas, no more than rounding";
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
    if (damping > kMaxDamping) {
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
