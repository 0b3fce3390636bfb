// SPDX-License-Identifier: Apache-2.0
#include "reduced_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "normals/back.h"
#include "normals/reduced_system.h"

namespace sarblock {

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
/// A step below this is near enough to its end to be left alone where nothing shrinks any more.
constexpr double kSettledAnyway_1 = 1e-6;
/// Steps that shrink to less than this part of the one before have nothing of note behind them.
constexpr double kFastContraction_1 = 0.1;
/// Where v'Pv has a limit: steps before it is asked for, and how far one step is trusted.
constexpr int kLeastSteps = 3;
constexpr double kPromised_1 = 4.0;

std::string Rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", value);
  return text.data();
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
  double damping = kFirstDamping_1;
  int refused = 0;
  double left_before = 0.0;  // at the last accepted step
  std::string left_text;
  ProgressOfSteps steps_so_far;
  const auto form = [&](const BlockState& at, double with_damping) {
    system.Form(at, weighting, nullptr, with_damping);
    ++report.formed;
  };
  form(*state, damping);
  report.initial_cost_1 = report.final_cost_1 = system.cost();
  for (int trial = 0; trial < 4 * options.max_iterations; ++trial) {
    Step(progress,
         "solve",
         static_cast<std::size_t>(report.iterations),
         static_cast<std::size_t>(options.max_iterations),
         "cost " + std::to_string(report.final_cost_1) + left_text);
    if (damping > kMostDamping_1) {
      report.message = WhyStopped("no step lowers the cost", refused);
      return report;
    }
    if (!system.FactorDamped()) {
      if (report.formed >= options.max_formed) break;
      damping *= 10.0;
      form(*state, damping);
      continue;
    }
    const double left = system.NewtonDecrement();
    left_text = ", newton decrement " + Rounded(left) + " sigmas";
    if (weighting.loss != RobustLoss::kNone && !weighting.second_order && left <= kNear_1) {
      weighting.second_order = true;
      form(*state, damping);
      continue;
    }
    // Where large residuals meet bent equations each step is a fixed part of the one before: what
    // is left is the sum of all to come. Steps that no longer shrink are rounding.
    const double contraction = left_before > 0.0 ? left / left_before : 0.0;
    const bool slow = contraction > kFastContraction_1 && contraction < 1.0;
    const double to_come = slow ? left / (1.0 - contraction) : left;
    const bool stands = contraction >= 1.0 && left <= std::max(options.settled_1, kSettledAnyway_1);
    if (to_come <= options.settled_1 || stands) {
      report.converged = true;
      report.message = "the Newton decrement is " + Rounded(left) + " sigmas";
      if (options.take_last_step) {
        const Eigen::VectorXd dx = system.Step();
        state->displacement_m =
            SubstituteBack(problem, *state, weighting, damping, dx).displacement_m;
        state->corrections += dx;
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
    const Eigen::VectorXd dx = system.Step();
    PointSteps steps = SubstituteBack(problem, *state, weighting, damping, dx);
    const double predicted = steps.predicted_decrease_1 + system.PredictedDecrease(dx);
    BlockState next;
    next.displacement_m = std::move(steps.displacement_m);
    next.corrections = state->corrections + dx;
    next.start_m.swap(state->start_m);
    const double next_damping = std::max(kLeastDamping_1, 0.1 * damping);
    form(next, next_damping);
    next.start_m.swap(state->start_m);
    const double gain = report.final_cost_1 - system.cost();
    // Rounding of the cost itself: a predicted decrease below it cannot be checked, and the step is
    // taken.
    const double rounding = 1e-13 * report.final_cost_1 + 1e-12;
    const bool valid = system.looks_not_evaluated() == 0 && std::isfinite(system.cost());
    bool better = valid && (gain > 0.1 * predicted || (predicted < rounding && gain > -rounding));
    if (!better && valid && std::abs(gain) <= kUnclear_1 * report.final_cost_1) {
      // The gradient keeps digits that the cost has lost.
      better = system.FactorDamped() && system.NewtonDecrement() < 0.5 * left;
      if (!better && left <= kSettledAnyway_1) {
        report.converged = true;
        report.message = "the step left is " + Rounded(left) + " sigmas, no more than rounding";
        return report;
      }
    }
    if (better) {
      state->displacement_m.swap(next.displacement_m);
      state->corrections = next.corrections;
      report.final_cost_1 = system.cost();
      damping = next_damping;
      left_before = left;
      ++report.iterations;
    } else {
      if (system.looks_not_evaluated() > 0) ++refused;
      damping *= 10.0;
      form(*state, damping);
    }
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
