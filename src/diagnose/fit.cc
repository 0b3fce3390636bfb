// SPDX-License-Identifier: Apache-2.0
#include "fit.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <exception>
#include <utility>

#include "normals/point.h"
#include "normals/reduced_system.h"
#include "solve/reduced_engine.h"
#include "solve/start.h"

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
    const Weighting weighting{.renewed = &problem.weights};
    ReducedSystem system(problem);
    const SolveReport report =
        SolveReduced(problem, weighting, options, &system, &fit.state, progress);
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

}  // namespace sarblock
