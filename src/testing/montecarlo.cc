// SPDX-License-Identifier: Apache-2.0
#include "montecarlo.h"

#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/text.h"
#include "core/threads.h"
#include "redraw_solution.h"
#include "solve/solve_block.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

/// Runs whose errors are held at once: 24 bytes a point each.
constexpr std::size_t kRunsPerBatch = 16;

/// Errors of one run by point, frame axes; empty where it did not converge.
using RunErrors = std::vector<Eigen::Vector3d>;

RunErrors AdjustRun(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const AdjustOptions& options,
                    const ExactReadings& exact,
                    std::uint64_t run) {
  Block block = problem.block;
  std::vector<double> prior_values;
  RedrawSolution(problem, state, exact, options.montecarlo_seed, run, &block, &prior_values);
  AdjustmentProblem again(block, problem);
  again.model.ScaleSigmas(problem.model.sigma_factors());
  again.look_used = problem.look_used;
  again.point_status = problem.point_status;
  again.point_reason = problem.point_reason;
  again.control_of = problem.control_of;  // without what was released as a blunder
  again.held = problem.held;
  for (std::size_t i = 0; i < prior_values.size(); ++i) {
    again.layout.parameters[i].prior_value = prior_values[i];
  }
  BlockState at = state;
  UpdateWeights(at, &again);
  if (!SolveRounds({}, options, &again, &at, nullptr).converged) return {};
  RunErrors errors(at.displacement_m.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] = at.displacement_m[i] - state.displacement_m[i];
  }
  return errors;
}

/// What a point's errors are compared with.
struct Reference {
  Eigen::Matrix3d normal_from_frame;  // east, north, up in standard deviations
  std::array<double, 6> whiten_1;     // of these, to independent ones: lower triangle by rows
};

/// e' Q^-1 e of an error in standard deviations.
double SquareOf(const std::array<double, 6>& whiten_1, const Eigen::Vector3d& normal) {
  const double e = whiten_1[0] * normal[0];
  const double n = whiten_1[1] * normal[0] + whiten_1[2] * normal[1];
  const double u = whiten_1[3] * normal[0] + whiten_1[4] * normal[1] + whiten_1[5] * normal[2];
  return e * e + n * n + u * u;
}

/// Adds up the runs, in their order.
class Collector {
 public:
  Collector(const AdjustmentProblem& problem,
            const BlockState& state,
            const std::vector<SymmetricEnu>& covariance_m2) {
    for (std::size_t point = 0; point < covariance_m2.size(); ++point) {
      if (problem.Solves(point)) Compare(problem, state, covariance_m2[point], point);
    }
    for (std::size_t i = 0; i < limit_.size(); ++i) {
      limit_[i] = ChiSquareQuantile(MonteCarloReport::kLevels[i], 3.0);
    }
    Digest(std::span(state.corrections.data(), static_cast<std::size_t>(state.corrections.size())));
  }

  void Add(std::size_t number, const RunErrors& errors) {
    MonteCarloRun run;
    run.run = static_cast<std::uint32_t>(number);
    run.converged = !errors.empty();
    for (std::size_t k = 0; run.converged && k < draws_.points.size(); ++k) {
      MonteCarloPoint& sums = draws_.points[k];
      const Eigen::Vector3d normal = references_[k].normal_from_frame * errors[sums.point];
      const double square = SquareOf(references_[k].whiten_1, normal);
      for (std::size_t i = 0; i < 3; ++i) {
        const double own = normal[static_cast<Eigen::Index>(i)];
        sums.product[i].Add(own * own);
        run.variance_ratio_1[i] += own * own;
        if (square > limit_[i]) continue;
        ++sums.inside[i];
        run.inside_1[i] += 1.0;
      }
      sums.product[3].Add(normal[0] * normal[1]);
      sums.product[4].Add(normal[0] * normal[2]);
      sums.product[5].Add(normal[1] * normal[2]);
      sums.square.Add(square);
      run.square_1 += square / 3.0;
    }
    const double count = std::max(1.0, static_cast<double>(draws_.points.size()));
    for (std::size_t i = 0; i < 3; ++i) {
      run.variance_ratio_1[i] /= count;
      run.inside_1[i] /= count;
    }
    run.square_1 /= count;
    draws_.runs.push_back(run);
  }

  MonteCarloDraws Take() && { return std::move(draws_); }

 private:
  void Compare(const AdjustmentProblem& problem,
               const BlockState& state,
               const SymmetricEnu& covariance_m2,
               std::size_t point) {
    const Eigen::Matrix3d matrix = MatrixOf(covariance_m2);
    const Eigen::LLT<Eigen::Matrix3d> factor(matrix);
    if (factor.info() != Eigen::Success || !matrix.allFinite()) return;
    const Eigen::Vector3d sigma_m = matrix.diagonal().cwiseSqrt();
    const Eigen::Matrix3d whiten = factor.matrixL().solve(Eigen::Matrix3d::Identity());
    const Eigen::Vector3d position_m = state.Position(point);
    Reference reference;
    reference.normal_from_frame =
        sigma_m.cwiseInverse().asDiagonal() * problem.block.frame.EnuFromFrame(position_m);
    std::size_t k = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) reference.whiten_1[k++] = whiten(i, j) * sigma_m[j];
    }
    references_.push_back(reference);
    draws_.points.emplace_back().point = static_cast<std::uint32_t>(point);
    Digest(std::span(position_m.data(), 3));
    Digest(std::span(covariance_m2));
  }

  void Digest(std::span<const double> values) {
    draws_.solution = Fnv1a(std::as_bytes(values), draws_.solution);
  }

  std::vector<Reference> references_;
  std::array<double, 3> limit_{};
  MonteCarloDraws draws_{.solution = kFnv1aStart, .runs = {}, .points = {}};
};

}  // namespace

MonteCarloDraws DrawMonteCarlo(const AdjustmentProblem& problem,
                               const BlockState& state,
                               const AdjustOptions& options,
                               const std::vector<SymmetricEnu>& covariance_m2,
                               ProgressSink* progress) {
  AdjustOptions alone = options;
  alone.threads = 1;  // of Ceres, whose sums depend on its threads
  Collector collector(problem, state, covariance_m2);
  const TaskPart part = options.montecarlo_part.value_or(TaskPart{});
  const std::size_t runs = part.TasksOf(static_cast<std::size_t>(options.montecarlo_runs));
  if (runs == 0) return std::move(collector).Take();
  const ExactReadings exact = ReadExactly(problem, state);
  std::vector<RunErrors> errors(kRunsPerBatch);
  for (std::size_t first = 0; first < runs; first += kRunsPerBatch) {
    Step(progress, "montecarlo", first, runs);
    const std::size_t count = std::min(kRunsPerBatch, runs - first);
    const auto number = [&](std::size_t i) { return part.index + (first + i) * part.count; };
    ParallelForChunks(count, 1, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        errors[i] = AdjustRun(problem, state, alone, exact, number(i));
      }
    });
    for (std::size_t i = 0; i < count; ++i) collector.Add(number(i), errors[i]);
  }
  Step(progress, "montecarlo", runs, runs);
  return std::move(collector).Take();
}

}  // namespace sarblock
