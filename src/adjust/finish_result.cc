// SPDX-License-Identifier: Apache-2.0
#include "finish_result.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "block/read_recorded.h"
#include "core/threads.h"
#include "leberl_prediction.h"
#include "quality/reliability.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;

void CountAndTest(const AdjustmentProblem& problem,
                  const AdjustOptions& options,
                  const SquareSum& square_sum,
                  AdjustResult* result) {
  const ProblemCounts counts = CountProblem(problem);
  result->looks_used = counts.looks;
  result->observation_count = counts.observations;
  result->parameter_count = counts.parameters;
  result->datum_defects = counts.defects;
  if (std::isnan(square_sum.kept_1)) return;  // a prediction has no residuals to test
  const GlobalTest test =
      TestGlobally(problem, options.test_level, square_sum.kept_1, square_sum.left_out_1);
  if (std::isnan(test.sigma0_squared)) {
    Warn(result, "no redundancy: the variance factor and its test do not exist");
    return;
  }
  result->sigma0_squared = test.sigma0_squared;
  result->chi_square = test.chi_square;
  result->chi_square_passed = test.passed;
}

/// A standard deviation beyond this part of the shortest range leaves a direction open: no linear
/// statement holds there (the intersection of a point alone refuses it at the same part).
constexpr double kMaxDeviationPart_1 = 0.5;

void WarnOfOpenPoints(const AdjustmentProblem& problem, AdjustResult* result) {
  if (result->points.covariance_m2.empty()) return;
  const Looks& looks = problem.block.looks;
  std::size_t open = 0, first = 0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    double shortest_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] != 0) shortest_m = std::min(shortest_m, looks.range_m[i]);
    }
    const SymmetricEnu& c = result->points.covariance_m2[point];
    if (std::sqrt(c[0] + c[1] + c[2]) <= kMaxDeviationPart_1 * shortest_m) continue;
    if (open++ == 0) first = point;
  }
  if (open == 0) return;
  Warn(result,
       std::to_string(open) +
           " points have a standard deviation of more than half their range, the first is " +
           std::string(problem.block.points.ids[first]) +
           ": a direction is open (zero base, touching circles or corrections without a datum), "
           "their positions and sigmas cannot be used");
}

void MarkRejected(const AdjustmentProblem& problem, AdjustResult* result) {
  result->looks.rejected.resize(problem.look_used.size());
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    result->looks.rejected[i] = problem.look_used[i] == 0 ? 1 : 0;
  }
  // Looks of a point that is left out were not rejected; they have no residual.
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) continue;
    const auto& offsets = problem.block.looks.offsets;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      result->looks.rejected[i] = problem.block.looks.rejected(i) ? 1 : 0;
    }
  }
}

}  // namespace

void FinishResult(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const AdjustOptions& options,
                  const SquareSum& square_sum,
                  const PointDefects& defects,
                  AdjustResult* result) {
  CountAndTest(problem, options, square_sum, result);
  FillPoints(problem, state, result);
  const bool measured = !std::isnan(square_sum.kept_1);
  if (measured && result->looks.range_residual_m.empty()) FillResiduals(problem, state, result);
  if (measured) FillChecks(problem.block, options, result);
  MarkRejected(problem, result);
  for (const Finding& finding : DescribePoints(problem, defects)) Warn(result, finding.text);
  WarnOfOpenPoints(problem, result);
  if (options.covariance != CovarianceLevel::kNone) FillLeberlPrediction(problem, state, result);
}

void FillPoints(const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result) {
  const Block& block = problem.block;
  const std::size_t points = block.points.size();
  PointResults& out = result->points;
  out.status = problem.point_status;
  out.reason = problem.point_reason;
  out.looks.assign(points, 0);
  out.position_m.assign(points, Eigen::Vector3d::Constant(kNaN));
  out.intersection_rad.assign(points, kNaN);
  const auto fill = [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Sight> sights;
    for (std::size_t point = begin; point < end; ++point) {
      out.looks[point] = static_cast<std::uint32_t>(problem.CountLooks(point));
      if (problem.point_status[point] == PointStatus::kApart) {
        out.position_m[point] = state.Position(point);
      }
      if (!problem.Solves(point)) continue;
      out.position_m[point] = state.Position(point);
      sights.clear();
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem.look_used[i] == 0) continue;
        if (const auto sight = problem.model.SightOf(i, state.corrections)) {
          sights.push_back(*sight);
        }
      }
      if (sights.size() >= 2) {
        out.intersection_rad[point] = LargestIntersectionAngle(out.position_m[point], sights);
      }
    }
  };
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByItem(&out.looks),
                    SharedArray::ByItem(&out.position_m),
                    SharedArray::ByItem(&out.intersection_rad)},
                   fill);
}

void FillResiduals(const AdjustmentProblem& problem,
                   const BlockState& state,
                   AdjustResult* result) {
  const Block& block = problem.block;
  LookResults& out = result->looks;
  out.range_residual_m.assign(block.looks.size(), kNaN);
  out.azimuth_residual_m.assign(block.looks.size(), kNaN);
  const std::size_t points = block.points.size();
  const auto fill = [&](std::size_t, std::size_t begin, std::size_t end) {
    LookColumns columns;
    LookEvaluation at;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (!EvaluateLook(problem.model, state, point, i, {}, &columns, &at)) continue;
        out.range_residual_m[i] = at.error_1[0];
        out.azimuth_residual_m[i] = at.error_1[1] * at.azimuth_unit_m;
      }
    }
  };
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByRange(block.looks.offsets, &out.range_residual_m),
                    SharedArray::ByRange(block.looks.offsets, &out.azimuth_residual_m)},
                   fill);
}

void FillLossWeights(const AdjustmentProblem& problem,
                     const BlockState& state,
                     const Weighting& weighting,
                     AdjustResult* result) {
  const Block& block = problem.block;
  std::vector<float>& out = result->looks.weight;
  out.assign(block.looks.size(), 0.0F);
  const std::size_t points = block.points.size();
  const auto fill = [&](std::size_t, std::size_t begin, std::size_t end) {
    WhitenedLook at;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem.look_used[i] == 0) continue;
        if (!EvaluateWhitened(problem, state, {}, point, i, &at)) continue;
        out[i] = static_cast<float>(
            EvaluateLoss(weighting.loss, weighting.scale, at.error_1.squaredNorm()).weight_1);
      }
    }
  };
  ForChunksOfRanks(
      points, kPointsPerChunk, {SharedArray::ByRange(block.looks.offsets, &out)}, fill);
}

void FillParameters(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result) {
  result->parameters.clear();
  for (std::size_t i = 0; i < problem.layout.parameters.size(); ++i) {
    const Parameter& parameter = problem.layout.parameters[i];
    ParameterResult out;
    out.owner = parameter.owner;
    out.name = parameter.name;
    out.unit = parameter.unit;
    out.value = state.corrections[static_cast<Eigen::Index>(i)];
    out.prior_sigma = parameter.prior_sigma;
    result->parameters.push_back(std::move(out));
  }
  result->joint_priors.clear();
  for (const JointPriorTerm& prior : problem.layout.joint_priors) {
    result->joint_priors.push_back(
        {prior.name, {prior.parameters.begin(), prior.parameters.end()}, prior.covariance});
  }
}

namespace {

/// Times of a corrected path's states: those recorded and those of the path, and within the strip
/// as many more as cubic interpolation needs to follow a spline (its knots and seven between) or a
/// polynomial of a degree above 3.
std::vector<double> CorrectedStateTimes(const AdjustmentProblem& problem, std::size_t pass) {
  const Pass& source = problem.block.passes[pass];
  std::vector<double> times_s = PathTimes_s(source);
  const double span_s = source.end_s - source.start_s;
  double step_s = span_s;
  for (const SplineTerm& term : problem.layout.passes[pass].splines) {
    step_s = std::min(step_s, term.spline.spacing_s() / 8.0);
  }
  for (const PolynomialTerm& term : problem.layout.passes[pass].polynomials) {
    if (term.degree > 3) step_s = std::min(step_s, span_s / (8.0 * (term.degree + 1)));
  }
  if (!(step_s < span_s)) return times_s;
  const auto steps = static_cast<std::size_t>(std::lround(span_s / step_s));
  for (std::size_t k = 0; k <= steps; ++k) {
    const double time_s =
        source.start_s + span_s * static_cast<double>(k) / static_cast<double>(steps);
    if (time_s > source.path.start_s() && time_s < source.path.end_s()) times_s.push_back(time_s);
  }
  std::sort(times_s.begin(), times_s.end());
  const double least_gap_s = 1e-6 * step_s;
  times_s.erase(
      std::unique(
          times_s.begin(), times_s.end(), [&](double a, double b) { return b - a <= least_gap_s; }),
      times_s.end());
  return times_s;
}

}  // namespace

void FillCorrectedPaths(const AdjustmentProblem& problem,
                        const BlockState& state,
                        AdjustResult* result) {
  result->corrected_paths.clear();
  for (std::size_t pass = 0; pass < problem.block.passes.size(); ++pass) {
    double bias_s = 0.0;
    const PassCorrections& corrections = problem.layout.passes[pass];
    const FlightPath& nominal = problem.block.passes[pass].path;
    if (!corrections.time_bias.empty()) {
      LookColumns columns;
      problem.model.ColumnsAt(pass, nominal.start_s(), &columns);
      std::array<double, ParameterLayout::kMaxLocalColumns> local;
      GatherColumns(problem.layout, columns, state.corrections, local.data());
      for (const int column : corrections.time_bias) {
        bias_s += local[static_cast<std::size_t>(column)];
      }
    }
    std::vector<StateVector> states;
    for (const double path_s : CorrectedStateTimes(problem, pass)) {
      // The path read at t + b_t: the state of nominal time t belongs to measured time t - b_t.
      const double measured_s = path_s - bias_s;
      const auto corrected =
          problem.model.CorrectedMotionAtPathTime(pass, measured_s, path_s, state.corrections);
      if (!corrected) continue;
      states.push_back({measured_s, corrected->motion.position_m, corrected->motion.velocity_mps});
    }
    result->corrected_paths.emplace_back(std::move(states));
  }
}

}  // namespace sarblock
