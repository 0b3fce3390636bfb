// SPDX-License-Identifier: Apache-2.0
#include "montecarlo.h"

#include "sarblock/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/nan.h"
#include "core/parallel.h"
#include "model/symmetric_enu.h"
#include "redraw_solution.h"
#include "solve/solve_block.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

constexpr double kConfidence_1 = 0.99;
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
  AdjustmentProblem again(block, problem.groups, problem.model.simplified());
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
  std::uint32_t point = 0;
  Eigen::Matrix3d enu_from_frame;
  Eigen::Matrix3d whiten;  // inverse Cholesky factor of the covariance
  Eigen::Vector3d variance_m2;
};

std::vector<Reference> ReferencesOf(const AdjustmentProblem& problem,
                                    const BlockState& state,
                                    const std::vector<SymmetricEnu>& covariance_m2) {
  std::vector<Reference> out;
  for (std::size_t point = 0; point < covariance_m2.size(); ++point) {
    if (!problem.Solves(point)) continue;
    const SymmetricEnu& q = covariance_m2[point];
    const Eigen::Matrix3d matrix = MatrixOf(q);
    const Eigen::LLT<Eigen::Matrix3d> factor(matrix);
    if (factor.info() != Eigen::Success) continue;
    Reference reference;
    reference.point = static_cast<std::uint32_t>(point);
    reference.enu_from_frame = problem.block.frame.EnuFromFrame(state.Position(point));
    reference.whiten = factor.matrixL().solve(Eigen::Matrix3d::Identity());
    reference.variance_m2 = matrix.diagonal();
    out.push_back(reference);
  }
  return out;
}

/// Sum and square sum of a figure over the runs.
struct RunSum {
  double sum = 0.0, square = 0.0;
  void Add(double value) {
    sum += value;
    square += value * value;
  }
  /// `least_variance` is what the figure has if the points of a run were independent: few runs may
  /// show less by chance (all points inside).
  [[nodiscard]] RunMean Mean(int runs, double expected, double least_variance) const {
    const double n = runs;
    RunMean out;
    out.expected_1 = expected;
    out.mean_1 = sum / n;
    const double variance = runs > 1 ? (square - sum * out.mean_1) / (n - 1.0) : least_variance;
    out.standard_error_1 = std::sqrt(std::max(variance, least_variance) / n);
    return out;
  }
};

/// Collects the runs one after the other, in their order.
class Collector {
 public:
  Collector(std::size_t points, std::vector<Reference> references, MonteCarloReport* report)
      : references_(std::move(references)), report_(*report) {
    report_.points = references_.size();
    report_.sample_m2.assign(points, {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN});
    report_.square_1.assign(points, kNaN);
    for (auto& inside : report_.inside) inside.assign(points, 0);
    for (const Reference& reference : references_) {
      report_.sample_m2[reference.point].fill(0.0);
      report_.square_1[reference.point] = 0.0;
    }
    for (std::size_t i = 0; i < limit_.size(); ++i) {
      limit_[i] = ChiSquareQuantile(MonteCarloReport::kLevels[i], 3.0);
    }
  }

  void Add(const RunErrors& errors) {
    if (errors.empty()) {
      ++report_.failed;
      return;
    }
    ++report_.runs;
    std::array<double, 3> ratio{}, inside{};
    double square = 0.0;
    for (const Reference& reference : references_) {
      const std::size_t point = reference.point;
      const Eigen::Vector3d e = reference.enu_from_frame * errors[point];
      const double s = (reference.whiten * e).squaredNorm();
      std::array<double, 6>& sample = report_.sample_m2[point];
      for (Eigen::Index i = 0; i < 3; ++i) {
        sample[static_cast<std::size_t>(i)] += e[i] * e[i];
        ratio[static_cast<std::size_t>(i)] += e[i] * e[i] / reference.variance_m2[i];
      }
      sample[3] += e[0] * e[1];
      sample[4] += e[0] * e[2];
      sample[5] += e[1] * e[2];
      report_.square_1[point] += s;
      square += s / 3.0;
      for (std::size_t i = 0; i < limit_.size(); ++i) {
        if (s > limit_[i]) continue;
        ++report_.inside[i][point];
        inside[i] += 1.0;
      }
    }
    const auto count = static_cast<double>(references_.size());
    for (std::size_t i = 0; i < 3; ++i) {
      ratio_[i].Add(ratio[i] / count);
      inside_[i].Add(inside[i] / count);
    }
    square_.Add(square / count);
  }

  void Finish() {
    if (report_.runs == 0 || references_.empty()) return;
    const double runs = report_.runs, count = static_cast<double>(references_.size());
    const Interval allowed = ChiSquareInterval(kConfidence_1, 3.0 * runs);
    for (const Reference& reference : references_) {
      for (double& element : report_.sample_m2[reference.point]) element /= runs;
      double& square = report_.square_1[reference.point];
      if (!allowed.Contains(square)) ++report_.points_outside;
      square /= 3.0 * runs;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const double p = MonteCarloReport::kLevels[i];
      // Variances of a chi-square of one degree, of three over 3, of a yes or no.
      report_.variance_ratio[i] = ratio_[i].Mean(report_.runs, 1.0, 2.0 / count);
      report_.coverage[i] = inside_[i].Mean(report_.runs, p, p * (1.0 - p) / count);
    }
    report_.square_ratio = square_.Mean(report_.runs, 1.0, 2.0 / 3.0 / count);
  }

 private:
  std::vector<Reference> references_;
  MonteCarloReport& report_;
  std::array<double, 3> limit_{};
  std::array<RunSum, 3> ratio_, inside_;
  RunSum square_;
};

std::string SentenceOf(const MonteCarloReport& report) {
  const RunMean& ratio = report.square_ratio;
  const bool agrees = ratio.Agrees() && std::all_of(report.coverage.begin(),
                                                    report.coverage.end(),
                                                    [](const RunMean& c) { return c.Agrees(); });
  const char* verdict = agrees                ? "the stated covariance is realistic"
                        : ratio.lower() > 1.0 ? "the stated covariance is too small"
                        : ratio.upper() < 1.0 ? "the stated covariance is too large"
                                              : "the errors are not as normal as stated";
  std::array<char, 400> text;
  std::snprintf(text.data(),
                text.size(),
                "%s: over %d runs the squared errors of %zu points are %.3f times what it says "
                "(99 %% confidence %.3f to %.3f), and its 50, 90 and 99 %% ellipsoids hold %.1f, "
                "%.1f and %.1f %% of them",
                verdict,
                report.runs,
                report.points,
                ratio.mean_1,
                ratio.lower(),
                ratio.upper(),
                100.0 * report.coverage[0].mean_1,
                100.0 * report.coverage[1].mean_1,
                100.0 * report.coverage[2].mean_1);
  return text.data();
}

}  // namespace

MonteCarloReport RunMonteCarlo(const AdjustmentProblem& problem,
                               const BlockState& state,
                               const AdjustOptions& options,
                               const std::vector<SymmetricEnu>& covariance_m2,
                               ProgressSink* progress) {
  MonteCarloReport report;
  report.seed = options.montecarlo_seed;
  AdjustOptions alone = options;
  alone.threads = 1;  // of Ceres, whose sums depend on its threads
  Collector collector(
      problem.block.points.size(), ReferencesOf(problem, state, covariance_m2), &report);
  const ExactReadings exact = ReadExactly(problem, state);
  const auto runs = static_cast<std::size_t>(options.montecarlo_runs);
  std::vector<RunErrors> errors(kRunsPerBatch);
  for (std::size_t first = 0; first < runs; first += kRunsPerBatch) {
    Step(progress, "montecarlo", first, runs);
    const std::size_t count = std::min(kRunsPerBatch, runs - first);
    ParallelForChunks(count, 1, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        errors[i] = AdjustRun(problem, state, alone, exact, first + i);
      }
    });
    for (std::size_t i = 0; i < count; ++i) collector.Add(errors[i]);
  }
  Step(progress, "montecarlo", runs, runs);
  collector.Finish();
  report.sentence = report.runs > 0 ? SentenceOf(report) : "no run converged: nothing is shown";
  return report;
}

}  // namespace sarblock
