// SPDX-License-Identifier: Apache-2.0
#include "ceres_engine.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "core/threads.h"
#include "cost/look_cost.h"
#include "model/problem.h"
#include "normals/point.h"
#include "reduced_engine.h"
#include <ceres/iteration_callback.h>
#include <ceres/loss_function.h>
#include <ceres/solver.h>

namespace sarblock {
namespace {

/// Our loss functions (model/problem.h) as one of Ceres.
class Loss final : public ceres::LossFunction {
 public:
  Loss(RobustLoss loss, double scale) : loss_(loss), scale_(scale) {}
  void Evaluate(double square, double out[3]) const override {
    const RobustValue value = EvaluateLoss(loss_, scale_, square);
    out[0] = value.loss;
    out[1] = value.weight;
    // The second derivative only tunes the step; Gauss-Newton weights (zero) keep it positive.
    out[2] = 0.0;
  }

 private:
  RobustLoss loss_;
  double scale_;
};

/// A step below this part of what may be left was the last: those to come are shorter still.
constexpr double kLastStepPart = 0.3;
/// Under a loss: a change of the cost by this part of it. The reduced engine goes on from there.
constexpr double kSettledCost = 1e-9;
ceres::LinearSolverType TypeOf(CeresSolver solver) {
  switch (solver) {
    case CeresSolver::kDenseSchur:
      return ceres::DENSE_SCHUR;
    case CeresSolver::kIterativeSchur:
      return ceres::ITERATIVE_SCHUR;
    default:
      return ceres::SPARSE_SCHUR;
  }
}

/// Damps at first by 1e-10 of the diagonal, which grows with the points: with hundreds of thousands
/// of them 1e-8 held what only priors of hundreds of metres hold. With 1e-12 a recorded flight with
/// several minima ends in another one than with the reduced engine (RecordedEnginesTest).
constexpr double kFirstRadius = 1e10;
/// Damping of a point that follows, as small as that of the engine.
constexpr double kFollowDamping = 1e-8;
/// Steps creep that are so many in turn longer than this part of the one before, and shorter than
/// that many sigmas over all unknowns.
constexpr int kCreepingSteps = 2;
constexpr double kCreepingPart = 0.3, kCreepingBelow = 10.0;
/// How much better the quadratic model may still get where conjugate gradients end.
constexpr double kConjugateGradients = 1e-3;

/// Reports each iteration and ends the solution at a step below `settled` sigmas. The relative
/// change of cost that Ceres tests is not enough: 1e-6 sigmas change a cost of a thousand by less
/// than its rounding. Without a loss it ends too where steps creep.
class IterationWatch final : public ceres::IterationCallback {
 public:
  IterationWatch(ProgressSink* sink, const SolveOptions& options, bool least_squares)
      : sink_(sink),
        most_(options.max_iterations),
        least_squares_(least_squares),
        last_step_(kLastStepPart * options.settle_below) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (sink_ != nullptr) {
      sink_->Update("solve",
                    static_cast<std::size_t>(summary.iteration),
                    static_cast<std::size_t>(most_),
                    "cost " + std::to_string(summary.cost));
      if (sink_->Cancelled()) return ceres::SOLVER_ABORT;
    }
    if (least_squares_ && summary.iteration > 0 && summary.step_is_valid) {
      if (Settled(summary)) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      if (summary.step_is_successful) CountCreeping(LengthOf(summary));
      if (creeps()) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    stagnates_ = progress_.Stagnates(
        summary.iteration, summary.cost, std::numeric_limits<double>::infinity());
    return stagnates_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  [[nodiscard]] bool stagnates() const { return stagnates_; }
  [[nodiscard]] bool creeps() const { return creeping_ == kCreepingSteps; }

 private:
  /// In sigmas: the linear model promises half the square. A cost that does not move at all has no
  /// ratio to the promise: the step is then below the root of its rounding.
  [[nodiscard]] static double LengthOf(const ceres::IterationSummary& summary) {
    if (summary.cost_change == 0.0) return 0.0;
    return std::sqrt(2.0 * summary.cost_change / summary.relative_decrease);
  }
  [[nodiscard]] bool Settled(const ceres::IterationSummary& summary) const {
    return LengthOf(summary) <= last_step_;
  }
  void CountCreeping(double length) {
    const bool creeps = length > kCreepingPart * length_ && length < kCreepingBelow;
    creeping_ = creeps ? creeping_ + 1 : 0;
    length_ = length;
  }

  ProgressSink* sink_;
  int most_;
  bool least_squares_;
  double last_step_;
  ProgressOfSteps progress_;
  bool stagnates_ = false;
  double length_ = std::numeric_limits<double>::infinity();  ///< of the last step taken
  int creeping_ = 0;                                         ///< steps in turn
};

}  // namespace

std::unique_ptr<ceres::Problem> MakeCeresProblem(const AdjustmentProblem& problem,
                                                 const Weighting& weighting,
                                                 const BlockState& state,
                                                 const CeresUnknowns& unknowns) {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  options.evaluation_callback = unknowns.before_evaluation;
  auto out = std::make_unique<ceres::Problem>(options);
  const Looks& looks = problem.block.looks;
  ceres::LossFunction* loss =
      weighting.loss == RobustLoss::kNone ? nullptr : new Loss(weighting.loss, weighting.scale);
  bool loss_taken = false;
  std::vector<double*> blocks;
  LookColumns columns;
  for (std::size_t b = 0; b < problem.layout.blocks.size(); ++b) {
    const ParameterBlock& block = problem.layout.blocks[b];
    out->AddParameterBlock(unknowns.corrections + block.offset, block.size);
    PriorOfBlock prior = PriorCostOf(problem.layout, static_cast<int>(b));
    if (prior.cost == nullptr) continue;
    blocks.clear();
    for (const int of : prior.blocks) {
      const ParameterBlock& taken = problem.layout.blocks[static_cast<std::size_t>(of)];
      blocks.push_back(unknowns.corrections + taken.offset);
    }
    out->AddResidualBlock(prior.cost.release(), nullptr, blocks);
  }
  const std::vector<FlightPointer> flights = FlightsOf(problem);
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    double* displacement = unknowns.displacements_m + 3 * point;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      problem.model.ColumnsOf(i, &columns);
      blocks.assign(1, displacement);
      for (int b = 0; b < columns.block_count; ++b) {
        const std::size_t block =
            static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)]);
        blocks.push_back(unknowns.corrections + problem.layout.blocks[block].offset);
      }
      CostPointer cost = LookCostOf(problem, flights[looks.pass[i]], &state.start_m[point], i);
      out->AddResidualBlock(cost.release(), loss, blocks);
      loss_taken = true;
    }
    if (problem.control_of[point] >= 0) {
      const auto index = static_cast<std::size_t>(problem.control_of[point]);
      CostPointer cost =
          ControlCostOf(problem.block.frame, problem.control[index], &state.start_m[point]);
      out->AddResidualBlock(cost.release(), nullptr, displacement);
    }
  }
  if (!loss_taken) delete loss;
  return out;
}

namespace {

CeresUnknowns UnknownsOf(BlockState* state) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  return {state->displacement_m.empty() ? nullptr : state->displacement_m.front().data(),
          state->corrections.data()};
}

/// Lets the points follow a trial step of the corrections before Ceres asks for its cost. Ceres
/// keeps its displacements, which it does not let others change; the start positions move.
class PointsFollow final : public ceres::EvaluationCallback {
 public:
  PointsFollow(const AdjustmentProblem& problem, const Weighting& weighting, BlockState* state)
      : problem_(problem), weighting_(weighting), state_(state), accepted_m_(state->start_m) {}

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override {
    if (new_evaluation_point) {
      state_->start_m = accepted_m_;
      ParallelForChunks(accepted_m_.size(),
                        kPointsPerChunk,
                        [&](std::size_t, std::size_t begin, std::size_t end) {
                          PointFactor factor;
                          for (std::size_t point = begin; point < end; ++point)
                            Follow(point, &factor);
                        });
    }
    // Ceres asks for Jacobians where it stays.
    if (evaluate_jacobians) accepted_m_ = state_->start_m;
  }

  /// Leaves the points as they are where Ceres stayed.
  void Settle() { state_->start_m = accepted_m_; }

 private:
  static constexpr std::size_t kPointsPerChunk = 512;

  void Follow(std::size_t point, PointFactor* factor) {
    if (!problem_.Solves(point)) return;
    Eigen::Vector3d& displacement_m = state_->displacement_m[point];
    const Eigen::Vector3d given_m = displacement_m;
    FactorPoint(problem_, *state_, weighting_, kFollowDamping, point, factor);
    if (SettlePoint(problem_, weighting_, kFollowDamping, kMaxOwnStep, point, state_, factor)) {
      state_->start_m[point] += displacement_m - given_m;
      displacement_m = given_m;
    }
  }

  const AdjustmentProblem& problem_;
  const Weighting weighting_;
  BlockState* state_;
  std::vector<Eigen::Vector3d> accepted_m_;
};

}  // namespace

std::unique_ptr<ceres::Problem> MakeCeresProblem(const AdjustmentProblem& problem,
                                                 const Weighting& weighting,
                                                 BlockState* state) {
  return MakeCeresProblem(problem, weighting, *state, UnknownsOf(state));
}

SolveReport SolveWithCeres(const AdjustmentProblem& problem,
                           const Weighting& weighting,
                           const SolveOptions& options,
                           BlockState* state,
                           ProgressSink* progress) {
  PointsFollow follow(problem, weighting, state);
  CeresUnknowns unknowns = UnknownsOf(state);
  unknowns.before_evaluation = &follow;
  const std::unique_ptr<ceres::Problem> ceres_problem =
      MakeCeresProblem(problem, weighting, *state, unknowns);
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.threads;
  solver.logging_type = ceres::SILENT;
  // Least squares end by IterationWatch. Reweighted ones converge linearly and end on the cost;
  // rounding of positions of 7e6 m can keep that moving by more than 1e-14 of itself.
  const bool least_squares = weighting.loss == RobustLoss::kNone;
  solver.function_tolerance = least_squares ? 0.0 : kSettledCost;
  solver.parameter_tolerance = 1e-13;
  solver.gradient_tolerance = 0.0;
  solver.initial_trust_region_radius = kFirstRadius;
  solver.eta = kConjugateGradients;
  solver.max_num_consecutive_invalid_steps = 20;
  if (problem.layout.size() == 0) {
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  } else {
    solver.linear_solver_type = TypeOf(Resolve(options.ceres_solver, problem.layout.size()));
    solver.preconditioner_type = ceres::SCHUR_JACOBI;  // of the iterative one
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
      if (problem.Solves(point)) {
        ordering->AddElementToGroup(state->displacement_m[point].data(), 0);
      }
    }
    for (const ParameterBlock& block : problem.layout.blocks) {
      ordering->AddElementToGroup(state->corrections.data() + block.offset, 1);
    }
    solver.linear_solver_ordering.reset(ordering);
  }
  IterationWatch watch(progress, options, least_squares);
  solver.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, ceres_problem.get(), &summary);
  follow.Settle();
  if (summary.termination_type == ceres::USER_FAILURE) throw Interrupted("solve");
  SolveReport report;
  report.converged = !watch.stagnates() && (summary.termination_type == ceres::CONVERGENCE ||
                                            summary.termination_type == ceres::USER_SUCCESS);
  report.creeps = watch.creeps();
  report.iterations = summary.num_successful_steps;
  report.initial_cost = summary.initial_cost;
  report.final_cost = summary.final_cost;
  report.message = watch.stagnates() ? kStagnates
                   : summary.termination_type == ceres::NO_CONVERGENCE
                       ? LimitReached(options.max_iterations)
                       : summary.message;
  return report;
}

}  // namespace sarblock
