// SPDX-License-Identifier: Apache-2.0
#include "montecarlo.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>

#include "core/text.h"
#include "core/threads.h"
#include "linear/dense.h"
#include "normals/point.h"
#include "solve/solve_block.h"

namespace sarblock {
namespace {

constexpr std::size_t kRedrawnPerChunk = 512;
constexpr int kMaxSteps = 30;
/// A step this small in metres along track moves no position that counts.
constexpr double kCloseEnough_m = 1e-7;

// Kinds of random streams.
constexpr std::uint64_t kLookKind = 101, kControlKind = 102, kPriorKind = 103;

std::uint64_t StreamOf(std::uint64_t run, std::uint64_t kind, std::uint64_t index) {
  return MixStream(MixStream(run, kind), index);
}

/// Time or Doppler and range at which a look has no error at the solution. The model predicts them
/// from where it reads the path, which is nearer at every step; it reads what was measured from
/// `block`, which it was made of.
void SolveLook(const AdjustmentProblem& problem,
               const BlockState& state,
               std::size_t point,
               std::size_t look,
               Block* block,
               ExactReadings* out) {
  LookColumns columns;
  LookEvaluation at;
  double& azimuth =
      block->MeasuresDoppler(look) ? block->looks.cone[look] : block->looks.time_s[look];
  for (int step = 0; step < kMaxSteps; ++step) {
    if (!EvaluateLook(problem.model, state, point, look, {}, &columns, &at) || at.beyond_path) {
      break;
    }
    if (std::abs(at.whitened_error[1]) * at.azimuth_unit_m < kCloseEnough_m) {
      const LookSigma sigma = problem.model.SigmaOf(look);
      out->azimuth[look] = azimuth;
      out->range_m[look] = block->looks.range_m[look] + at.whitened_error[0];
      out->azimuth_sigma[look] = sigma.azimuth_unit == AzimuthUnit::kMetres
                                     ? sigma.azimuth / at.azimuth_unit_m
                                     : sigma.azimuth;
      return;
    }
    azimuth += at.whitened_error[1];
  }
  throw InputError("adjust.covariance",
                   "'montecarlo' cannot repeat the look of " +
                       std::string(block->points.ids[point]) + " in pass " +
                       block->passes[block->looks.pass[look]].id +
                       ": its noise-free time lies outside the path");
}

/// Noise of the fixed components of a known position with their covariance, east-north-up [m].
Eigen::Vector3d DrawKnown(const KnownPosition& known, RandomStream* random) {
  std::vector<Eigen::Index> fixed;
  for (std::size_t i = 0; i < 3; ++i) {
    if (known.fixed[i]) fixed.push_back(static_cast<Eigen::Index>(i));
  }
  Eigen::VectorXd normal(static_cast<Eigen::Index>(fixed.size()));
  for (double& value : normal) value = random->Normal();
  const Eigen::MatrixXd covariance = known.covariance_enu_m2(fixed, fixed);
  Eigen::Vector3d noise_m = Eigen::Vector3d::Zero();
  noise_m(fixed) = dense::Cholesky(covariance).L().triangularView<Eigen::Lower>() * normal;
  return noise_m;
}

}  // namespace

ExactReadings ReadExactly(const AdjustmentProblem& problem, const BlockState& state) {
  Block block = problem.block;
  AdjustmentProblem exact(block, problem);
  exact.model.ScaleSigmas(problem.model.sigma_factors());
  exact.model.AnchorLike(problem.model);
  ExactReadings out;
  for (std::vector<double>* column : {&out.range_m, &out.azimuth, &out.azimuth_sigma}) {
    column->assign(block.looks.size(), kNotGiven);
  }
  const std::vector<std::uint64_t>& offsets = block.looks.offsets;
  ParallelForChunks(
      block.points.size(), kRedrawnPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t point = begin; point < end; ++point) {
          for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
            if (problem.look_used[i] == 0) continue;
            SolveLook(exact, state, point, i, &block, &out);
          }
        }
      });
  return out;
}

void ResampleObservations(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const ExactReadings& exact,
                          std::uint64_t seed,
                          std::uint64_t run,
                          Block* block,
                          std::vector<double>* prior_values) {
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] == 0) continue;
    RandomStream random(seed, StreamOf(run, kLookKind, i));
    const double azimuth = exact.azimuth[i] + exact.azimuth_sigma[i] * random.Normal();
    (block->MeasuresDoppler(i) ? block->looks.cone : block->looks.time_s)[i] = azimuth;
    block->looks.range_m[i] = exact.range_m[i] + problem.model.SigmaOf(i).range_m * random.Normal();
  }
  for (const ControlEquations& control : problem.control) {
    if (!problem.Solves(control.point) || problem.control_of[control.point] < 0) continue;
    RandomStream random(seed, StreamOf(run, kControlKind, control.point));
    const Eigen::Vector3d p_m = state.Position(control.point);
    block->points.given_m[control.point] =
        p_m + block->frame.EnuFromFrame(p_m).transpose() *
                  DrawKnown(*block->points.FindKnown(control.point), &random);
  }
  prior_values->assign(problem.layout.parameters.size(), 0.0);
  for (std::size_t i = 0; i < prior_values->size(); ++i) {
    const Parameter& parameter = problem.layout.parameters[i];
    if (!parameter.has_own_prior() && parameter.before < 0) continue;
    RandomStream random(seed, StreamOf(run, kPriorKind, i));
    const double value = state.corrections[static_cast<Eigen::Index>(i)];
    if (parameter.before < 0) {
      (*prior_values)[i] = value + parameter.prior_sigma * random.Normal();
    } else {
      const auto before = static_cast<std::size_t>(parameter.before);
      const double error_before = (*prior_values)[before] - state.corrections[parameter.before];
      (*prior_values)[i] =
          value + parameter.carried * error_before + parameter.step_sigma * random.Normal();
    }
  }
  for (const JointPriorTerm& prior : problem.layout.joint_priors) {
    Eigen::VectorXd normal(prior.factor.rows());
    for (Eigen::Index k = 0; k < normal.size(); ++k) {
      const int parameter = prior.parameters[static_cast<std::size_t>(k)];
      const auto stream = static_cast<std::uint64_t>(parameter);
      normal[k] = RandomStream(seed, StreamOf(run, kPriorKind, stream)).Normal();
    }
    const Eigen::VectorXd drawn = state.corrections(prior.parameters) + prior.factor * normal;
    for (Eigen::Index k = 0; k < drawn.size(); ++k) {
      const int parameter = prior.parameters[static_cast<std::size_t>(k)];
      (*prior_values)[static_cast<std::size_t>(parameter)] = drawn[k];
    }
  }
}

namespace {

/// Runs whose errors are kept at once: 24 bytes per point each.
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
  ResampleObservations(problem, state, exact, options.montecarlo_seed, run, &block, &prior_values);
  AdjustmentProblem again(block, problem);
  again.model.ScaleSigmas(problem.model.sigma_factors());
  again.look_used = problem.look_used;
  again.point_status = problem.point_status;
  again.point_reason = problem.point_reason;
  again.control_of = problem.control_of;  // without what was released as a blunder
  again.fixed = problem.fixed;
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
  std::array<double, 6> whiten;       // of these, to independent ones: lower triangle by rows
};

/// e' Q^-1 e of an error in standard deviations.
double SquareOf(const std::array<double, 6>& whiten, const Eigen::Vector3d& normal) {
  const double e = whiten[0] * normal[0];
  const double n = whiten[1] * normal[0] + whiten[2] * normal[1];
  const double u = whiten[3] * normal[0] + whiten[4] * normal[1] + whiten[5] * normal[2];
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
  }

  void Add(const RunErrors& errors) {
    MonteCarloRun run;
    run.converged = !errors.empty();
    for (std::size_t k = 0; run.converged && k < draws_.points.size(); ++k) {
      MonteCarloPoint& sums = draws_.points[k];
      const Eigen::Vector3d normal = references_[k].normal_from_frame * errors[sums.point];
      const double square = SquareOf(references_[k].whiten, normal);
      for (std::size_t i = 0; i < 3; ++i) {
        const double own = normal[static_cast<Eigen::Index>(i)];
        sums.product[i] += own * own;
        run.variance_ratio[i] += own * own;
        if (square > limit_[i]) continue;
        ++sums.inside[i];
        run.inside[i] += 1.0;
      }
      sums.product[3] += normal[0] * normal[1];
      sums.product[4] += normal[0] * normal[2];
      sums.product[5] += normal[1] * normal[2];
      sums.square += square;
      run.square += square / 3.0;
    }
    const double count = std::max(1.0, static_cast<double>(draws_.points.size()));
    for (std::size_t i = 0; i < 3; ++i) {
      run.variance_ratio[i] /= count;
      run.inside[i] /= count;
    }
    run.square /= count;
    draws_.runs.push_back(run);
  }

  MonteCarloDraws Take() && { return std::move(draws_); }

 private:
  void Compare(const AdjustmentProblem& problem,
               const BlockState& state,
               const SymmetricEnu& covariance_m2,
               std::size_t point) {
    const Eigen::Matrix3d matrix = MatrixOf(covariance_m2);
    const std::optional<Eigen::Matrix3d> lower = dense::LowerFactor(matrix);
    if (!lower || !matrix.allFinite()) return;
    const Eigen::Vector3d sigma_m = matrix.diagonal().cwiseSqrt();
    const Eigen::Matrix3d whiten = InverseOfUpper(lower->transpose()).transpose();
    const Eigen::Vector3d position_m = state.Position(point);
    Reference reference;
    reference.normal_from_frame =
        sigma_m.cwiseInverse().asDiagonal() * problem.block.frame.EnuFromFrame(position_m);
    std::size_t k = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) reference.whiten[k++] = whiten(i, j) * sigma_m[j];
    }
    references_.push_back(reference);
    draws_.points.emplace_back().point = static_cast<std::uint32_t>(point);
  }

  std::vector<Reference> references_;
  std::array<double, 3> limit_{};
  MonteCarloDraws draws_;
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
  const auto runs = static_cast<std::size_t>(options.montecarlo_runs);
  const ExactReadings exact = ReadExactly(problem, state);
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
  return std::move(collector).Take();
}

namespace {

constexpr double kConfidence = 0.99;

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
    out.expected = expected;
    out.mean = sum / n;
    const double variance = runs > 1 ? (square - sum * out.mean) / (n - 1.0) : least_variance;
    out.standard_error = std::sqrt(std::max(variance, least_variance) / n);
    return out;
  }
};

/// The means over the runs, each of which averages its points.
void FillMeans(const MonteCarloDraws& draws, MonteCarloReport* report) {
  std::array<RunSum, 3> ratio, inside;
  RunSum square;
  for (const MonteCarloRun& run : draws.runs) {
    if (!run.converged) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      ratio[i].Add(run.variance_ratio[i]);
      inside[i].Add(run.inside[i]);
    }
    square.Add(run.square);
  }
  const auto count = static_cast<double>(draws.points.size());
  for (std::size_t i = 0; i < 3; ++i) {
    const double p = MonteCarloReport::kLevels[i];
    // Variances of a chi-square of one degree, of three over 3, of a yes or no.
    report->variance_ratio[i] = ratio[i].Mean(report->runs, 1.0, 2.0 / count);
    report->coverage[i] = inside[i].Mean(report->runs, p, p * (1.0 - p) / count);
  }
  report->square_ratio = square.Mean(report->runs, 1.0, 2.0 / 3.0 / count);
}

/// The figures of every point.
void FillPoints(const MonteCarloDraws& draws,
                const std::vector<SymmetricEnu>& covariance_m2,
                MonteCarloReport* report) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kElements{
      {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  const double runs = report->runs;
  const Interval allowed = ChiSquareInterval(kConfidence, 3.0 * runs);
  for (const MonteCarloPoint& sums : draws.points) {
    const SymmetricEnu& rigorous_m2 = covariance_m2[sums.point];
    for (std::size_t k = 0; k < 6; ++k) {
      const auto [i, j] = kElements[k];
      const double unit_m2 =
          i == j ? rigorous_m2[i] : std::sqrt(rigorous_m2[i]) * std::sqrt(rigorous_m2[j]);
      report->sample_m2[sums.point][k] = unit_m2 * (sums.product[k] / runs);
    }
    const double square = sums.square;
    if (!allowed.Contains(square)) ++report->points_outside;
    report->square[sums.point] = square / (3.0 * runs);
    for (std::size_t i = 0; i < 3; ++i) report->inside[i][sums.point] = sums.inside[i];
  }
}

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
                ratio.mean,
                ratio.lower(),
                ratio.upper(),
                100.0 * report.coverage[0].mean,
                100.0 * report.coverage[1].mean,
                100.0 * report.coverage[2].mean);
  return text.data();
}

}  // namespace

MonteCarloReport ReportMonteCarlo(const MonteCarloDraws& draws,
                                  std::uint64_t seed,
                                  const std::vector<SymmetricEnu>& covariance_m2) {
  MonteCarloReport report;
  report.seed = seed;
  report.points = draws.points.size();
  for (const MonteCarloRun& run : draws.runs) ++(run.converged ? report.runs : report.failed);
  report.sample_m2.assign(covariance_m2.size(), {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN});
  report.square.assign(covariance_m2.size(), kNaN);
  for (auto& inside : report.inside) inside.assign(covariance_m2.size(), 0);
  if (report.runs > 0 && report.points > 0) {
    FillPoints(draws, covariance_m2, &report);
    FillMeans(draws, &report);
  }
  report.sentence = report.runs > 0 ? SentenceOf(report) : "no run converged: nothing is shown";
  return report;
}

}  // namespace sarblock
