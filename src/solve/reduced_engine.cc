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

constexpr const char* kUnsolvable = "the equations cannot be solved where the steps have led";

std::string Rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", value);
  return text.data();
}

double OwnStepOf(double decrement, const AdjustmentProblem& problem) {
  const auto points = static_cast<double>(problem.block.points.size());
  return std::clamp(kOwnStepPart * decrement / std::sqrt(points), kMinOwnStep, kMaxOwnStep);
}

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

/// A state that a step leads to, before it is judged.
struct Trial {
  BlockState state;
  double predicted = 0.0;  ///< decrease of the cost
  double bend = 0.0;       ///< second order of the step as a part of its length
  Newton newton;           ///< there
  bool solved = false;     ///< every look has a value there, and the system a solution
  double gain = 0.0;       ///< decrease of the cost
  bool unclear = false;    ///< the gain may be rounding, or an effect of other weights
};

/// A solution on its way: Newton steps, damped or not (SolveReduced).
class NewtonSteps {
 public:
  NewtonSteps(const AdjustmentProblem& problem,
              const Weighting& weighting,
              const SolveOptions& options,
              ReducedSystem* system,
              BlockState* state,
              ProgressSink* progress)
      : problem_(problem),
        options_(options),
        system_(*system),
        state_(*state),
        progress_(progress),
        weighting_(weighting),
        weights_(std::exchange(weighting_.renewed, nullptr)),
        renews_(weights_ != nullptr),
        least_squares_(weighting.loss == RobustLoss::kNone),
        can_bend_(least_squares_ && problem.layout.size() > 0) {
    damping() =
        options.undamped ? 0.0 : std::clamp(options.damping, kFirstDamping, kMaxKeptDamping);
  }

  [[nodiscard]] SolveReport Run();

 private:
  /// What follows a decision: a step is taken, the state is looked at again, the solution ends.
  enum class Next { kStep, kAgain, kEnd };

  [[nodiscard]] double& damping() { return report_.damping; }
  /// How the looks are weighted where the system is formed, weights kept.
  [[nodiscard]] Weighting WeightingOf(bool curved) const {
    Weighting weighting = weighting_;
    weighting.curved = curved;
    return weighting;
  }
  /// The steps of the points that belong to a step of the corrections from the present state.
  [[nodiscard]] PointSteps PointStepsOf(const Newton& newton) const {
    return SubstituteBack(
        problem_, state_, WeightingOf(newton.curved), newton.damping, newton.step);
  }

  void Form(BlockState* at, double with_damping, bool curved);
  /// The Newton step of the system that was formed.
  [[nodiscard]] bool Solve(double with_damping, bool curved, Newton* out);
  /// Forms a state and solves it; where the second derivatives leave no minimum, without them.
  [[nodiscard]] bool FormAndSolve(BlockState* at, double with_damping, Newton* out);
  /// Forms the present state and its step, damped as much as that takes.
  [[nodiscard]] bool Restart();
  Next BeginAgain() { return Restart() ? Next::kAgain : Stop(kUnsolvable); }
  Next Stop(const std::string& reason) {
    report_.message = reason;
    return Next::kEnd;
  }

  /// Whether to take the present step, to look again at the state as it is now, or to end.
  [[nodiscard]] Next Decide();
  /// The end, unless weights that were kept have to follow.
  [[nodiscard]] Next Settle();
  [[nodiscard]] Next TryStep();
  /// The state after the present step, along the valley where steps leave it; false if that bends
  /// too much.
  [[nodiscard]] bool Propose(Trial* trial) const;
  /// Forms and solves the system at the proposed state.
  void Evaluate(Trial* trial);
  void Accept(Trial* trial);
  /// The same step along the valley, one without second derivatives, a shorter one, or the end.
  [[nodiscard]] Next Refuse(const Trial& trial);

  const AdjustmentProblem& problem_;
  const SolveOptions& options_;
  ReducedSystem& system_;
  BlockState& state_;
  ProgressSink* progress_;
  SolveReport report_;
  Newton newton_;  // of the present state
  ProgressOfSteps progress_of_steps_;

  // Reweighting brings a solution near from anywhere and then creeps; second order finishes it.
  Weighting weighting_;
  // Weights that follow the state, until they no longer change.
  std::vector<LookWeights>* weights_;
  bool renews_;                  // where the system is formed
  bool weights_follow_ = false;  // they changed where they were formed last
  double weight_change_ = 0.0;   // at the last state that was formed
  bool crept_on_ = false;        // with weights that were kept

  const bool least_squares_;
  const bool can_bend_;
  bool curved_ = false;        // second derivatives from here on
  bool plain_ = false;         // but not at the present state
  bool bends_ = false;         // steps follow the valley
  bool slow_ = false;          // the last step left much of the one before
  double contraction_ = 0.0;   // Newton decrement over that of the step before
  bool kept_promise_ = false;  // the last step lowered the cost by most of what it promised
  int refused_in_turn_ = 0;
  double settle_points_below_ = kMaxOwnStep;  // own steps of points, in sigmas
};

void NewtonSteps::Form(BlockState* at, double with_damping, bool curved) {
  Weighting weighting = WeightingOf(curved);
  if (renews_) weighting.renewed = weights_;
  if (options_.points_follow) {
    system_.FormSettled(weighting, with_damping, settle_points_below_, at, nullptr);
  } else {
    system_.Form(*at, weighting, nullptr, with_damping);
  }
  weight_change_ = std::max(weight_change_, system_.weight_change());
  ++report_.formed;
}

bool NewtonSteps::Solve(double with_damping, bool curved, Newton* out) {
  const bool rank = with_damping == 0.0 && !system_.weak_points().empty();
  if (rank || !system_.FactorDamped()) return false;
  out->step = system_.Step();
  out->decrement = system_.NewtonDecrement(out->step);
  out->damping = with_damping;
  out->curved = curved;
  return std::isfinite(out->decrement);
}

bool NewtonSteps::FormAndSolve(BlockState* at, double with_damping, Newton* out) {
  weight_change_ = 0.0;
  const bool curved = curved_ && !plain_;
  Form(at, with_damping, curved);
  if (Solve(with_damping, curved, out)) return true;
  if (!curved) return false;
  Form(at, with_damping, false);
  return Solve(with_damping, false, out);
}

bool NewtonSteps::Restart() {
  contraction_ = 0.0;
  while (!FormAndSolve(&state_, damping(), &newton_)) {
    damping() *= 10.0;
    if (options_.undamped || damping() > kMaxDamping || report_.formed >= options_.max_formed) {
      return false;
    }
  }
  report_.formed_at_state = !newton_.curved;
  report_.final_cost = system_.cost();  // weights and points may have followed
  return true;
}

SolveReport NewtonSteps::Run() {
  const bool begun =
      options_.formed && system_.looks_not_evaluated() == 0 && Solve(0.0, false, &newton_);
  report_.formed_at_state = begun;
  const bool starts = begun || Restart();
  // Damped steps start with the weights of their first state.
  weights_follow_ = renews_ && (!options_.undamped || weight_change_ > kWeightsKept);
  report_.initial_cost = report_.final_cost = system_.cost();
  if (!starts) {
    report_.message = "the equations at the start cannot be solved";
    return report_;
  }
  for (int trials = 0; trials <= 4 * options_.max_iterations; ++trials) {
    Next next = Decide();
    if (next == Next::kStep) next = TryStep();
    if (next == Next::kEnd) return report_;
  }
  Stop(LimitReached(options_.max_iterations));
  return report_;
}

NewtonSteps::Next NewtonSteps::Decide() {
  Step(progress_,
       "solve",
       static_cast<std::size_t>(report_.iterations),
       static_cast<std::size_t>(options_.max_iterations),
       "cost " + std::to_string(report_.final_cost) + ", newton decrement " +
           Rounded(newton_.decrement) + " sigmas");
  const double left = newton_.decrement;
  if (!least_squares_ && !weighting_.second_order && left <= kNear) {
    weighting_.second_order = true;
    return BeginAgain();
  }
  // Where large residuals meet bent equations each step is a part of the one before: what is left
  // is the sum of all to come.
  report_.decrement = left / (1.0 - std::min(contraction_, kMaxContraction));
  const bool settled = report_.decrement <= options_.settle_below ||
                       (left <= options_.settle_below && refused_in_turn_ > 0);
  if (settled) return Settle();
  if (report_.iterations >= options_.max_iterations || report_.formed >= options_.max_formed) {
    return Stop(LimitReached(options_.max_iterations));
  }
  const bool gives_up = report_.formed > kMinSteps &&
                        2.0 * report_.final_cost - kPromised * left * left > options_.useless_above;
  if (gives_up) return Stop("no step promises a v'Pv that is of use");
  if (progress_of_steps_.Stagnates(report_.iterations, report_.final_cost, left)) {
    return Stop(kStagnates);
  }
  // Steps near rounding creep by it.
  const bool creeps = slow_ && left > kMinLearned;
  if ((creeps || options_.curved) && least_squares_ && !curved_ && left <= kCurved) {
    report_.curved = curved_ = true;
    slow_ = false;
    return BeginAgain();
  }
  return Next::kStep;
}

NewtonSteps::Next NewtonSteps::Settle() {
  if (std::exchange(crept_on_, false)) {
    renews_ = true;
    if (BeginAgain() == Next::kEnd) return Next::kEnd;
    weights_follow_ = weight_change_ > kWeightsKept;
    if (weights_follow_) return Next::kAgain;
    report_.decrement = newton_.decrement;
  }
  report_.converged = true;
  report_.message = "the Newton decrement is " + Rounded(newton_.decrement) + " sigmas";
  // One that creeps, or is short by its damping, may lead anywhere beyond what it promises.
  const bool safe = !slow_ && !curved_ && refused_in_turn_ == 0 && damping() <= kFirstDamping;
  if (options_.take_last_step && safe && report_.iterations < options_.max_iterations) {
    state_.displacement_m = PointStepsOf(newton_).displacement_m;
    state_.corrections += newton_.step;
    report_.formed_at_state = false;
    ++report_.iterations;
  }
  return Next::kEnd;
}

NewtonSteps::Next NewtonSteps::TryStep() {
  Trial trial;
  if (!Propose(&trial)) {
    ++refused_in_turn_;
    damping() *= 10.0;
    return BeginAgain();
  }
  Evaluate(&trial);
  const bool better = trial.solved && (trial.unclear ? trial.newton.decrement < newton_.decrement
                                                     : trial.gain > kMinGain * trial.predicted);
  if (!better) return Refuse(trial);
  Accept(&trial);
  return Next::kAgain;
}

bool NewtonSteps::Propose(Trial* trial) const {
  const Eigen::VectorXd& dx = newton_.step;
  PointSteps steps = PointStepsOf(newton_);
  trial->predicted = steps.predicted_decrease + system_.PredictedDecrease(dx);
  trial->state.displacement_m = std::move(steps.displacement_m);
  trial->state.corrections = state_.corrections + dx;
  if (!bends_) return true;
  const Eigen::VectorXd bend = -system_.SolveFor(
      BendOfStep(problem_, state_, WeightingOf(newton_.curved), newton_.damping, dx));
  trial->bend = LengthOf(bend, system_) / LengthOf(dx, system_);
  if (trial->bend <= kMaxBend) {
    trial->state.corrections += bend;
    return true;
  }
  return options_.undamped || report_.damping >= kMaxDamping;
}

void NewtonSteps::Evaluate(Trial* trial) {
  // What was just found to be too little is not tried again at once.
  const double part = kept_promise_ ? 0.01 : 0.1;
  const double lower = refused_in_turn_ > 0 ? damping() : part * damping();
  const double next_damping = options_.undamped ? 0.0 : std::max(kMinDamping, lower);
  // Weights follow whole steps, and others that shrink by themselves.
  const bool shrinks = !slow_ && !curved_ && refused_in_turn_ == 0;
  renews_ = weights_follow_ && (options_.undamped || shrinks);
  settle_points_below_ = OwnStepOf(newton_.decrement, problem_);
  const bool was_plain = std::exchange(plain_, false);
  trial->state.start_m.swap(state_.start_m);  // lent, not copied
  const bool factored = FormAndSolve(&trial->state, next_damping, &trial->newton);
  const bool evaluated = system_.looks_not_evaluated() == 0;
  if (!evaluated) {
    report_.held_by = WhyNoValue(problem_, trial->state, system_.first_not_evaluated());
  }
  trial->state.start_m.swap(state_.start_m);
  plain_ = was_plain;
  trial->solved = evaluated && std::isfinite(system_.cost()) && factored;
  trial->gain = report_.final_cost - system_.cost();
  // A gain of less than the cost's own rounding, or than what other weights may make of it, is no
  // evidence; the step that is left keeps the digits that the cost has lost.
  trial->unclear =
      (options_.undamped && weight_change_ > 0.0) ||
      std::abs(trial->gain) <= (kUnclear + 2.0 * weight_change_) * report_.final_cost + 1e-12;
}

void NewtonSteps::Accept(Trial* trial) {
  const double left = newton_.decrement, next_left = trial->newton.decrement;
  state_.displacement_m.swap(trial->state.displacement_m);
  state_.corrections = trial->state.corrections;
  report_.final_cost = system_.cost();
  report_.formed_at_state = !trial->newton.curved;
  if (newton_.damping <= kFirstDamping) report_.held_by.clear();
  damping() = trial->newton.damping;
  kept_promise_ = refused_in_turn_ == 0 && trial->gain >= kKept * trial->predicted;
  slow_ = (slow_ && !curved_) || next_left > kSlow * left;
  contraction_ = next_left / left;
  bends_ = can_bend_ && (slow_ || trial->bend > kStraight);
  crept_on_ = options_.undamped && weights_ != nullptr && !renews_ && (slow_ || crept_on_);
  if (renews_) weights_follow_ = weight_change_ > kWeightsKept;
  plain_ = false;
  newton_ = std::move(trial->newton);
  ++report_.iterations;
  refused_in_turn_ = 0;
}

NewtonSteps::Next NewtonSteps::Refuse(const Trial& trial) {
  kept_promise_ = false;
  report_.formed_at_state = false;
  ++refused_in_turn_;
  // The same step again, along the curve that the equations bend it to.
  if (trial.solved && can_bend_ && !std::exchange(bends_, true)) return BeginAgain();
  // Second derivatives reach less far than first ones where they nearly cancel.
  if (newton_.curved && !plain_) {
    plain_ = true;
    return BeginAgain();
  }
  const std::string left = Rounded(newton_.decrement);
  if (trial.unclear && newton_.decrement <= kSettledAnyway) {
    report_.converged = true;
    report_.message = "the Newton decrement is " + left + " sigmas, no more than rounding";
    return Next::kEnd;
  }
  if (options_.undamped) {
    return Stop("a whole Newton step, " + left + " sigmas long, does not lower the cost");
  }
  damping() *= 10.0;
  if (damping() > kMaxDamping) return Stop("no step lowers the cost");
  return BeginAgain();
}

}  // namespace

SolveReport SolveReduced(const AdjustmentProblem& problem,
                         const Weighting& weighting,
                         const SolveOptions& options,
                         ReducedSystem* system,
                         BlockState* state,
                         ProgressSink* progress) {
  return NewtonSteps(problem, weighting, options, system, state, progress).Run();
}

SolveReport SolveReduced(const AdjustmentProblem& problem,
                         const Weighting& weighting,
                         const SolveOptions& options,
                         BlockState* state,
                         ProgressSink* progress) {
  ReducedSystem system(problem);
  return SolveReduced(problem, weighting, options, &system, state, progress);
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
