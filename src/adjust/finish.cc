// SPDX-License-Identifier: Apache-2.0
#include "finish.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "block/read_recorded.h"
#include "block/swath.h"
#include "core/threads.h"
#include "geometry/track_axes.h"
#include "leberl_prediction.h"
#include "model/look_model.h"
#include "quality/verdict_tests.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;

void CountAndTest(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const AdjustOptions& options,
                  const SquareSum& square_sum,
                  AdjustResult* result) {
  const ProblemCounts counts = CountProblem(problem);
  result->looks_used = counts.looks;
  result->observation_count = counts.observations;
  result->parameter_count = counts.parameters;
  result->datum_defects = counts.defects;
  if (std::isnan(square_sum.kept)) return;  // a prediction has no residuals to test
  const PriorSums priors =
      SumPriors(problem.layout, state.corrections, result->parameter_covariance);
  const GlobalTest test = TestMeasurements(counts, priors, square_sum, options.test_level);
  result->assessment.groups = ListGroups(problem, priors, square_sum, options.test_level, *result);
  if (std::isnan(test.sigma0_squared)) {
    Warn(result, "no redundancy: the variance factor and its test do not exist");
    return;
  }
  result->sigma0_squared = test.sigma0_squared;
  result->test_redundancy = test.redundancy;
  result->chi_square = test.chi_square;
  result->chi_square_passed = test.passed;
}

/// A standard deviation beyond this part of the shortest range leaves a direction open: no linear
/// statement holds there (the intersection of a point alone refuses it at the same part).
constexpr double kMaxDeviationPart = 0.5;

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
    if (std::sqrt(c[0] + c[1] + c[2]) <= kMaxDeviationPart * shortest_m) continue;
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
  CountAndTest(problem, state, options, square_sum, result);
  FillPoints(problem, state, result);
  const bool measured = !std::isnan(square_sum.kept);
  if (measured && result->looks.range_residual_m.empty()) FillResiduals(problem, state, result);
  if (measured) FillChecks(problem.block, options, result);
  MarkRejected(problem, result);
  for (const Finding& finding : DescribePoints(problem, defects)) Warn(result, finding.text);
  WarnOfOpenPoints(problem, result);
  for (const std::string& text :
       FindLooksOutsideSwath(problem.block, result->points.position_m, problem.look_used)) {
    Warn(result, text);
  }
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
    std::vector<FixedPathLook> observations;
    for (std::size_t point = begin; point < end; ++point) {
      out.looks[point] = static_cast<std::uint32_t>(problem.CountLooks(point));
      if (problem.point_status[point] == PointStatus::kApart) {
        out.position_m[point] = state.Position(point);
      }
      if (!problem.Solves(point)) continue;
      out.position_m[point] = state.Position(point);
      observations.clear();
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem.look_used[i] == 0) continue;
        if (const auto observation = problem.model.FixPath(i, state.corrections)) {
          observations.push_back(*observation);
        }
      }
      if (observations.size() >= 2) {
        out.intersection_rad[point] = LargestIntersectionAngle(out.position_m[point], observations);
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
    LookEvaluation at;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (!EvaluateErrors(problem.model, state, point, i, &at)) continue;
        out.range_residual_m[i] = at.whitened_error[0];
        out.azimuth_residual_m[i] = at.whitened_error[1] * at.azimuth_unit_m;
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
            EvaluateLoss(weighting.loss, weighting.scale, at.whitened_error.squaredNorm()).weight);
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
    out.before = parameter.before;
    out.carried = parameter.carried;
    out.step_sigma = parameter.step_sigma;
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

namespace {

/// Covariances of a result by pair of parameters.
class CovarianceOfPairs {
 public:
  explicit CovarianceOfPairs(const std::vector<ParameterCovariance>& list) {
    of_pair_.reserve(list.size());
    for (const ParameterCovariance& entry : list)
      of_pair_[Key(entry.a, entry.b)] = entry.covariance;
  }
  /// NaN where the result has none.
  [[nodiscard]] double Covariance(std::uint32_t a, std::uint32_t b) const {
    const auto found = of_pair_.find(Key(std::min(a, b), std::max(a, b)));
    return found == of_pair_.end() ? kNotGiven : found->second;
  }

 private:
  static std::uint64_t Key(std::uint32_t a, std::uint32_t b) {
    return (static_cast<std::uint64_t>(a) << 32U) | b;
  }
  std::unordered_map<std::uint64_t, double> of_pair_;
};

/// One parameter of a pass at one time: delta(t), in track axes, by it.
struct Influence {
  std::uint32_t parameter = 0;
  Eigen::Vector3d by_parameter = Eigen::Vector3d::Zero();
};

/// What the looks of a pass reach.
struct Reach {
  double near_m = kNotGiven, far_m = kNotGiven;
  double height_m = kNotGiven;
  Cone cone;
};

class Sampler {
 public:
  Sampler(const Block& block,
          const std::vector<CorrectionGroup>& groups,
          const AdjustResult& result)
      : block_(block),
        result_(result),
        layout_(MakeParameterLayout(block, groups)),
        model_(block, layout_, result.selection.simplified),
        corrected_(layout_.size() > 0 &&
                   static_cast<std::size_t>(layout_.size()) == result.parameters.size()),
        covariance_(result.parameter_covariance),
        reach_(Reaches()) {}

  void Sample(std::uint32_t pass, std::vector<StripStation>* out) const {
    const Pass& source = block_.passes[pass];
    const std::size_t count = StationCount(pass);
    for (std::size_t k = 0; k < count; ++k) {
      StripStation station;
      station.pass = pass;
      const double part = static_cast<double>(k) / static_cast<double>(count - 1);
      station.strip_time = 2.0 * part - 1.0;
      station.time_s = source.start_s + part * (source.end_s - source.start_s);
      const auto motion = source.path.At(station.time_s);
      if (!motion) continue;
      station.antenna_m = motion->position_m;
      PlaceEdges(reach_[pass], source, *motion, &station);
      if (corrected_) Correct(pass, *motion, &station);
      out->push_back(station);
    }
  }

 private:
  std::size_t StationCount(std::uint32_t pass) const {
    std::size_t count = kStripStations;
    if (!corrected_) return count;
    for (const SplineTerm& term : layout_.passes[pass].splines) {
      const double pieces =
          (block_.passes[pass].end_s - block_.passes[pass].start_s) / term.spline.spacing_s();
      const auto wanted = static_cast<std::size_t>(4.0 * std::min(pieces, 1e6)) + 1;
      count = std::max(count, std::min(wanted, kMaxStripStations));
    }
    return count;
  }

  std::vector<Reach> Reaches() const {
    const std::size_t passes = block_.passes.size();
    std::vector<Reach> out(passes);
    std::vector<double> from_middle_s(passes, kNotGiven);
    std::vector<std::vector<double>> heights_m(passes);
    for (std::size_t point = 0; point < block_.points.size(); ++point) {
      const Eigen::Vector3d& p = result_.points.position_m[point];
      if (!p.allFinite()) continue;
      const double height_m = block_.frame.VerticalAt(p).height_m;
      for (std::size_t i = block_.looks.offsets[point]; i < block_.looks.offsets[point + 1]; ++i) {
        if (block_.looks.rejected(i) || !std::isfinite(block_.looks.range_m[i])) continue;
        const std::uint32_t pass = block_.looks.pass[i];
        Reach& reach = out[pass];
        reach.near_m = std::fmin(reach.near_m, block_.looks.range_m[i]);
        reach.far_m = std::fmax(reach.far_m, block_.looks.range_m[i]);
        heights_m[pass].push_back(height_m);
        const Pass& source = block_.passes[pass];
        const double apart_s =
            std::abs(block_.looks.time_s[i] - 0.5 * (source.start_s + source.end_s));
        if (!(apart_s >= from_middle_s[pass])) {
          from_middle_s[pass] = apart_s;
          reach.cone = model_.block().ConeOf(i);
        }
      }
    }
    for (std::size_t pass = 0; pass < passes; ++pass) {
      if (!heights_m[pass].empty()) out[pass].height_m = MedianInPlace(&heights_m[pass]);
    }
    return out;
  }

  void PlaceEdges(const Reach& reach,
                  const Pass& pass,
                  const Motion& motion,
                  StripStation* station) const {
    if (!std::isfinite(reach.height_m)) return;
    FixedPathLook observation;
    observation.antenna_m = motion.position_m;
    observation.velocity_mps = motion.velocity_mps;
    observation.acceleration_mps2 = motion.acceleration_mps2;
    observation.cone = reach.cone;
    observation.side = pass.side == LookSide::kLeft ? +1 : -1;
    const auto place = [&](double range_m, Eigen::Vector3d* edge_m) {
      observation.range_m = range_m;
      const Intersection met = IntersectWithHeight(observation, block_.frame, reach.height_m);
      if (met.outcome == IntersectionOutcome::kDetermined) *edge_m = met.position_m;
    };
    place(reach.near_m, &station->near_m);
    place(reach.far_m, &station->far_m);
  }

  void AddInfluence(std::uint32_t parameter,
                    PositionCorrection::Axes axes,
                    const TrackAxes& track,
                    int axis,
                    double value,
                    std::vector<Influence>* out) const {
    Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
    if (axes == PositionCorrection::Axes::kFrame) unit = track.axes.transpose() * unit;
    out->push_back({parameter, value * unit});
  }

  std::vector<Influence> InfluencesAt(std::uint32_t pass,
                                      double time_s,
                                      const TrackAxes& track) const {
    std::vector<Influence> out;
    const PassCorrections& corrections = layout_.passes[pass];
    std::vector<std::uint32_t> parameter;  // by static local column
    for (const int b : corrections.blocks) {
      const ParameterBlock& block = layout_.blocks[static_cast<std::size_t>(b)];
      for (int i = 0; i < block.size; ++i) {
        parameter.push_back(static_cast<std::uint32_t>(block.offset + i));
      }
    }
    const double x = (time_s - corrections.middle_s) / corrections.half_length_s;
    for (const PolynomialTerm& term : corrections.polynomials) {
      const auto size = static_cast<std::size_t>(term.degree) + 1;
      std::array<std::array<double, PositionCorrection::kMaxDegree + 1>, 3> values;
      LegendreValues(x,
                     {std::span(values[0]).first(size),
                      std::span(values[1]).first(size),
                      std::span(values[2]).first(size)});
      auto column = static_cast<std::size_t>(term.column);
      for (int axis = 0; axis < 3; ++axis) {
        if (!term.components[static_cast<std::size_t>(axis)]) continue;
        for (std::size_t k = 0; k < size; ++k, ++column) {
          AddInfluence(parameter[column], term.axes, track, axis, values[0][k], &out);
        }
      }
    }
    for (const SplineTerm& term : corrections.splines) {
      std::array<std::array<double, 4>, 3> values;
      const std::size_t first = term.spline.Evaluate(
          time_s, {std::span(values[0]), std::span(values[1]), std::span(values[2])});
      for (std::size_t q = 0; q < 4; ++q) {
        const ParameterBlock& block =
            layout_.blocks[static_cast<std::size_t>(term.first_block) + first + q];
        int column = block.offset;
        for (int axis = 0; axis < 3; ++axis) {
          if (!term.components[static_cast<std::size_t>(axis)]) continue;
          AddInfluence(
              static_cast<std::uint32_t>(column++), term.axes, track, axis, values[0][q], &out);
        }
      }
    }
    return out;
  }

  void Correct(std::uint32_t pass, const Motion& motion, StripStation* station) const {
    const TrackAxes track = TrackAxesOf(block_.frame, motion);
    const std::vector<Influence> influences = InfluencesAt(pass, station->time_s, track);
    if (influences.empty()) return;
    station->correction_m.setZero();
    Eigen::Vector3d variance_m2 = Eigen::Vector3d::Zero();
    for (const Influence& a : influences) {
      station->correction_m += result_.parameters[a.parameter].value * a.by_parameter;
      for (const Influence& b : influences) {
        const Eigen::Vector3d product = a.by_parameter.cwiseProduct(b.by_parameter);
        if (product.isZero(0.0)) continue;
        variance_m2 += covariance_.Covariance(a.parameter, b.parameter) * product;
      }
    }
    station->correction_sigma_m = variance_m2.cwiseSqrt();
  }

  const Block& block_;
  const AdjustResult& result_;
  ParameterLayout layout_;
  LookModel model_;
  bool corrected_;
  CovarianceOfPairs covariance_;
  std::vector<Reach> reach_;
};

}  // namespace

std::vector<StripStation> SampleStrips(const Block& block,
                                       const std::vector<CorrectionGroup>& groups,
                                       const AdjustResult& result) {
  const Sampler sampler(block, groups, result);
  std::vector<StripStation> out;
  for (std::uint32_t pass = 0; pass < block.passes.size(); ++pass) sampler.Sample(pass, &out);
  return out;
}

}  // namespace sarblock
