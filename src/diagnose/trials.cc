// SPDX-License-Identifier: Apache-2.0
#include "trials.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "normals/point.h"
#include "normals/reduced_system.h"
#include "sample.h"
#include "solve/reduced_engine.h"
#include "solve/start.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

constexpr int kQuicklyFormed = 6, kMostFormed = 16;
/// Steps of an intersection to start from: circles far from each other creep.
constexpr int kStepsToStart = 12;
/// Newton decrement in sigmas: v'Pv to its square.
constexpr double kSettled_1 = 0.03;

/// Looks of the sample that ought to have a place: not rejected, of points that can be solved.
bool Counts(const Block& sample, std::size_t point, std::size_t look) {
  if (sample.looks.rejected(look)) return false;
  if (sample.points.FindKnown(static_cast<std::uint32_t>(point)) != nullptr) return true;
  std::size_t looks = 0;
  for (std::size_t i = sample.looks.offsets[point]; i < sample.looks.offsets[point + 1]; ++i) {
    looks += sample.looks.rejected(i) ? 0U : 1U;
  }
  return looks >= 2;
}

void CountPlaces(const AdjustmentProblem& problem, Fit* fit) {
  const Block& sample = problem.block;
  for (std::size_t point = 0; point < sample.points.size(); ++point) {
    for (std::size_t i = sample.looks.offsets[point]; i < sample.looks.offsets[point + 1]; ++i) {
      if (!Counts(sample, point, i)) continue;
      bool placed = problem.Solves(point) && problem.look_used[i] != 0;
      if (placed) {
        const auto sight = problem.model.SightOf(i, fit->state.corrections);
        placed = sight && LiesWhereItLooks(sample.frame, *sight, fit->state.Position(point));
      }
      ++(placed ? fit->looks : fit->lost);
    }
  }
}

/// Start values from a state of the same points. What has no place there is left out.
BlockState Continue(const BlockState& warm, AdjustmentProblem* problem) {
  BlockState state = warm;
  if (state.corrections.size() != problem->layout.size()) {
    state.corrections = Eigen::VectorXd::Zero(problem->layout.size());
  }
  const auto& offsets = problem->block.looks.offsets;
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!state.Position(point).allFinite()) {
      problem->LeaveOut(point, PointStatus::kUndetermined, "no place");
      continue;
    }
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem->look_used[i] != 0 && !problem->model.SightOf(i, state.corrections)) {
        problem->look_used[i] = 0;
      }
    }
    const int control = problem->control_of[point];
    const int rows = control < 0 ? 0 : problem->control[static_cast<std::size_t>(control)].rows;
    const int looks = problem->CountLooks(point);
    if (looks == 0 || 2 * looks + rows < 3) {
      problem->LeaveOut(point, PointStatus::kTooFewLooks, "no place");
    }
  }
  UpdateWeights(state, problem);
  return state;
}

}  // namespace

double Fit::SquareSum() const { return square_sum_1 + kLost_1 * static_cast<double>(lost); }

Fit SolveSample(const Block& sample,
                const CorrectionModel& corrections,
                const FitOptions& asked,
                ProgressSink* progress) {
  Fit fit;
  try {
    AdjustmentProblem problem(sample, corrections.groups, {}, corrections.priors);
    const bool fits = asked.warm != nullptr && asked.warm->start_m.size() == sample.points.size();
    fit.state =
        fits ? Continue(*asked.warm, &problem)
             : std::move(
                   ComputeStartValues(&problem, progress, {.max_iterations = kStepsToStart}).state);
    SolveOptions options;
    options.useless_above_1 = asked.useless_above_1;
    options.max_formed = asked.effort == Effort::kQuick ? kQuicklyFormed : kMostFormed;
    options.settled_1 = kSettled_1;
    ReducedSystem system(problem);
    const SolveReport report = SolveReduced(problem, {}, options, &system, &fit.state, progress);
    fit.formed = report.formed;
    fit.settled = report.converged;
    UpdateWeights(fit.state, &problem);
    system.Form(fit.state, {}, progress);
    fit.square_sum_1 = 2.0 * system.cost();
    fit.redundancy_1 = CountProblem(problem).redundancy();
    CountPlaces(problem, &fit);
    fit.solved = std::isfinite(fit.square_sum_1) && fit.looks > 0;
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // what cannot be solved explains nothing
    fit.solved = false;
  }
  if (!fit.solved) {
    fit.square_sum_1 = 0.0;
    fit.lost = sample.looks.size();
  }
  return fit;
}

SampleResiduals ResidualsOf(const Block& sample,
                            const CorrectionModel& corrections,
                            const Fit& fit) {
  const auto looks = static_cast<Eigen::Index>(sample.looks.size());
  SampleResiduals out{Eigen::MatrixX2d::Constant(looks, 2, kNotGiven),
                      Eigen::MatrixX2d::Constant(looks, 2, kNotGiven)};
  if (!fit.solved) return out;
  AdjustmentProblem problem(sample, corrections.groups, {}, corrections.priors);
  UpdateWeights(fit.state, &problem);
  WhitenedLook at;
  PointFactor factor;
  for (std::size_t point = 0; point < sample.points.size(); ++point) {
    if (!fit.state.Position(point).allFinite()) continue;
    for (std::size_t i = sample.looks.offsets[point]; i < sample.looks.offsets[point + 1]; ++i) {
      if (sample.looks.rejected(i)) continue;
      if (EvaluateWhitened(problem, fit.state, {}, point, i, &at)) {
        out.whitened_1.row(static_cast<Eigen::Index>(i)) = at.error_1.transpose();
      }
    }
    if (!problem.Solves(point)) continue;
    FactorPoint(problem, fit.state, {}, 0.0, point, &factor);
    const auto rows = static_cast<std::size_t>(factor.row_count);
    for (std::size_t k = 0; k < 2 * static_cast<std::size_t>(factor.look_count); ++k) {
      const double q0 = factor.q[k], q1 = factor.q[rows + k], q2 = factor.q[2 * rows + k];
      out.redundancy_1(static_cast<Eigen::Index>(factor.looks[k / 2].look),
                       static_cast<Eigen::Index>(k % 2)) = 1.0 - q0 * q0 - q1 * q1 - q2 * q2;
    }
  }
  return out;
}

namespace {

constexpr int kQuickRounds = 2, kMostRounds = 6;
/// Of a standard deviation, from which on a size counts as found.
constexpr double kFound_1 = 0.05;

bool MayHoldPoint(const KnownPosition& known) {
  int held = 0;
  for (const bool component : known.held) held += component ? 1 : 0;
  if (held < 3) return held > 0;
  return Eigen::LLT<Eigen::Matrix3d>(known.covariance_enu_m2).info() == Eigen::Success;
}

/// Sum of ln sigma^2 of all measurements.
double LogSigmas(const Block& block) {
  double sum_1 = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const LookSigma sigma = block.SigmaOf(i);
    sum_1 += 2.0 * std::log(sigma.range_m * sigma.azimuth);
  }
  return sum_1;
}

void HoldCheckPoints(Block* block) {
  for (const KnownPosition& known : block->points.known) {
    PointRole& role = block->points.role[known.point];
    if (role == PointRole::kCheck && MayHoldPoint(known)) role = PointRole::kControl;
  }
}

constexpr double kMostLogMove_1 = 3.0;
/// Of what the parabola through three solutions takes off the cost, how much may be there.
constexpr double kPromised_1 = 4.0;

}  // namespace

Trials::Trials(const Block& sample, CorrectionModel corrections, Work work, ProgressSink* progress)
    : sample_(sample),
      given_(sample),
      corrections_(std::move(corrections)),
      work_(work),
      progress_(progress) {
  HoldCheckPoints(&given_);
  for (const Pass& pass : sample_.passes) states_ += pass.RecordedStates().size();
}

Fit Trials::Solve(const Block& block, const FitOptions& options) {
  ++solutions_;
  Fit fit = SolveSample(block, corrections_, options, progress_);
  const auto start = options.warm == nullptr ? Work::Start::kOfItsOwn : Work::Start::kOfAnother;
  work_.AddSolution(block.looks.size(), fit, start, states_);
  return fit;
}

Fit Trials::AsItIs() { return Solve(given_, {}); }

Fit Trials::Without(const std::vector<std::uint32_t>& points, const FitOptions& options) {
  std::vector<std::uint8_t>& flags = given_.looks.flags;
  const std::vector<std::uint8_t> before = flags;
  for (const std::uint32_t point : points) {
    for (std::size_t i = given_.looks.offsets[point]; i < given_.looks.offsets[point + 1]; ++i) {
      flags[i] |= Looks::kRejected;
    }
  }
  Fit fit = Solve(given_, options);
  flags = before;
  return fit;
}

Fit Trials::With(const Hypothesis& hypothesis, double value, const FitOptions& options) {
  Block block = sample_;
  hypothesis.undo(&block, value);
  FitStrips(&block);
  HoldCheckPoints(&block);
  work_.AddSmoothed(hypothesis.smoothed_states);
  Fit fit = Solve(block, options);
  if (block.looks.size() == sample_.looks.size() && fit.looks > 0) {
    const double part_1 =
        std::clamp(fit.redundancy_1 / (2.0 * static_cast<double>(fit.looks)), 0.0, 1.0);
    fit.log_sigmas_1 = part_1 * (LogSigmas(block) - LogSigmas(sample_));
  }
  return fit;
}

Solved SearchSize(const Hypothesis& hypothesis,
                  const Fit& first,
                  const SearchOptions& options,
                  Trials* trials) {
  Solved best{hypothesis.value, kNotGiven, first};
  if (!hypothesis.free || !first.solved) return best;
  double step = hypothesis.step;
  const auto at = [&](double value) {
    return trials->With(hypothesis, value, {.warm = &best.fit.state, .effort = options.effort});
  };
  const int rounds = options.effort == Effort::kQuick ? kQuickRounds : kMostRounds;
  for (int round = 0; round < rounds; ++round) {
    if (!trials->work().Allows(options.part_of_work_1)) break;
    Fit above = at(best.value + step), below = at(best.value - step);
    const double here_1 = best.fit.Cost();
    const double slope = (above.Cost() - below.Cost()) / (2.0 * step);
    const double curvature = (above.Cost() - 2.0 * here_1 + below.Cost()) / (step * step);
    const auto take = [&best](double value, Fit fit) {
      if (!fit.solved || !(fit.Cost() < best.fit.Cost())) return false;
      best.fit = std::move(fit);
      best.value = value;
      return true;
    };
    if (!(curvature > 0.0) || !std::isfinite(curvature)) {
      const double from = best.value;
      if (!take(from + step, std::move(above))) take(from - step, std::move(below));
      step *= 4.0;
      continue;
    }
    best.sigma = std::sqrt(2.0 / curvature);
    const double promised_1 = 0.5 * slope * slope / curvature;
    if (here_1 - kPromised_1 * promised_1 > options.useless_above_1) break;
    double move = -slope / curvature;
    // Standard deviations far off bend the cost: a parabola is good for a few powers of e.
    if (hypothesis.logarithm) move = std::clamp(move, -kMostLogMove_1, kMostLogMove_1);
    bool moved = false;
    for (int shorter = 0; shorter < 3 && !moved; ++shorter, move *= 0.25) {
      if (!trials->work().Allows(options.part_of_work_1)) break;
      moved = take(best.value + move, at(best.value + move));
      if (std::abs(move) < kFound_1 * best.sigma) break;
    }
    const bool fine = step < 5.0 * best.sigma && step > 0.2 * best.sigma;
    if (fine && (std::abs(slope / curvature) < kFound_1 * best.sigma || !moved)) break;
    step = hypothesis.logarithm ? std::min(best.sigma, 1.0) : best.sigma;
  }
  return best;
}

}  // namespace sarblock
