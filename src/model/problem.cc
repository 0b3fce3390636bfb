// SPDX-License-Identifier: Apache-2.0
#include "problem.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>

#include "core/threads.h"
#include "linear/dense.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 4096;

double RelativeChange(double now, double before) { return std::abs(now - before) / now; }

}  // namespace

ControlEquations MakeControl(const Frame& frame,
                             const KnownPosition& known,
                             const Eigen::Vector3d& known_m,
                             const std::string& id) {
  ControlEquations control;
  control.point = known.point;
  control.known_m = known_m;
  std::array<int, 3> fixed{};
  for (int i = 0; i < 3; ++i) {
    if (known.fixed[static_cast<std::size_t>(i)])
      fixed[static_cast<std::size_t>(control.rows++)] = i;
  }
  control.height_only =
      control.rows == 1 && fixed[0] == 2 && frame.kind() == FrameKind::kGeocentric;
  const Eigen::Matrix3d enu_from_frame = frame.EnuFromFrame(control.known_m);
  Eigen::MatrixXd covariance(control.rows, control.rows), rotation(control.rows, 3);
  for (int i = 0; i < control.rows; ++i) {
    rotation.row(i) = enu_from_frame.row(fixed[static_cast<std::size_t>(i)]);
    for (int j = 0; j < control.rows; ++j) {
      covariance(i, j) = known.covariance_enu_m2(fixed[static_cast<std::size_t>(i)],
                                                 fixed[static_cast<std::size_t>(j)]);
    }
  }
  const dense::Cholesky factor(covariance);
  if (!factor.positive_definite()) {
    throw InputError("point " + id, "the covariance of the control is not positive definite");
  }
  control.weight.topRows(control.rows) = factor.SolveLower(rotation);
  return control;
}

ControlEvaluation EvaluateControl(const Frame& frame,
                                  const ControlEquations& control,
                                  const Eigen::Vector3d& start_m,
                                  const Eigen::Vector3d& displacement_m) {
  ControlEvaluation out;
  if (control.height_only) {
    const Vertical at = frame.VerticalAt(start_m + displacement_m);
    const double known_h_m = frame.VerticalAt(control.known_m).height_m;
    const double weight = control.weight.row(0).norm();
    out.residual[0] = weight * (at.height_m - known_h_m);
    out.d_point.row(0) = weight * at.up.transpose();
    return out;
  }
  out.residual = control.weight * ((start_m - control.known_m) + displacement_m);
  out.d_point = control.weight;
  return out;
}

AdjustmentProblem::AdjustmentProblem(const Block& source,
                                     const std::vector<CorrectionGroup>& asked,
                                     const Simplified& simplified,
                                     const std::vector<JointPrior>& joint_priors)
    : block(source),
      groups(asked),
      priors(joint_priors),
      layout(MakeParameterLayout(source, groups, priors)),
      model(source, layout, simplified) {
  const std::size_t points = block.points.size(), looks = block.looks.size();
  look_used.resize(looks);
  for (std::size_t i = 0; i < looks; ++i) look_used[i] = block.looks.rejected(i) ? 0 : 1;
  point_status.assign(points, PointStatus::kAdjusted);
  point_reason.resize(points);
  mirrored.resize(points, 0);
  weights.assign(looks, {0.0, 0.0});
  control_of.assign(points, -1);
  for (const KnownPosition& known : block.points.known) {
    const bool any = known.fixed[0] || known.fixed[1] || known.fixed[2];
    if (block.points.role[known.point] != PointRole::kControl || !any) continue;
    control_of[known.point] = static_cast<std::int32_t>(control.size());
    control.push_back(MakeControl(block.frame,
                                  known,
                                  block.points.given_m[known.point],
                                  std::string(block.points.ids[known.point])));
  }
}

AdjustmentProblem::AdjustmentProblem(const Block& source, const AdjustmentProblem& like)
    : AdjustmentProblem(source, like.groups, like.model.simplified(), like.priors) {}

CorrectionModel GivenCorrections(const AdjustOptions& options) {
  if (options.corrections != CorrectionChoice::kGiven) return {};
  return {options.groups, options.priors};
}

void AdjustmentProblem::LeaveOut(std::size_t point, PointStatus status, const std::string& reason) {
  point_status[point] = status;
  point_reason[point] = reason;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    look_used[i] = 0;
  }
}

void AdjustmentProblem::LeaveOutMirrorSolution(std::size_t point) {
  LeaveOut(point,
           PointStatus::kUndetermined,
           "its looks meet only above the antennas or on the side they do not look to");
  mirrored[point] = 1;
}

void AdjustmentProblem::TakeBack(std::size_t point, const std::vector<std::size_t>& looks) {
  point_status[point] = PointStatus::kAdjusted;
  point_reason[point].clear();
  mirrored[point] = 0;
  for (const std::size_t look : looks) look_used[look] = 1;
}

int AdjustmentProblem::CountLooks(std::size_t point) const {
  const auto begin = look_used.begin() + static_cast<std::ptrdiff_t>(block.looks.offsets[point]);
  const auto end = look_used.begin() + static_cast<std::ptrdiff_t>(block.looks.offsets[point + 1]);
  return static_cast<int>(std::count(begin, end, std::uint8_t{1}));
}

std::optional<PointStatus> AdjustmentProblem::LacksEquations(std::size_t point) const {
  const int looks = CountLooks(point);
  if (looks == 0) return PointStatus::kNotSeen;
  const std::int32_t index = control_of[point];
  const int rows = index < 0 ? 0 : control[static_cast<std::size_t>(index)].rows;
  return 2 * looks + rows < 3 ? std::optional(PointStatus::kTooFewLooks) : std::nullopt;
}

bool EvaluateLook(const LookModel& model,
                  const BlockState& state,
                  std::size_t point,
                  std::size_t look,
                  const LookWeights& weights,
                  LookColumns* columns,
                  LookEvaluation* out,
                  LookCurvature* curvature) {
  model.ColumnsOf(look, columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  const double* x = LocalCorrections(model.layout(), *columns, state.corrections, &local);
  return model.Evaluate({look, *columns, state.start_m[point], state.displacement_m[point], x},
                        weights,
                        out,
                        curvature);
}

namespace {

/// The value of a look without weights and without the partials by corrections.
LookValue ValueOfErrors(const LookModel& model,
                        const BlockState& state,
                        std::size_t point,
                        std::size_t look,
                        LookEvaluation* out) {
  LookColumns columns;
  model.ColumnsOf(look, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  const double* x = LocalCorrections(model.layout(), columns, state.corrections, &local);
  columns.column_count = 0;
  return model.ValueOf(
      {look, columns, state.start_m[point], state.displacement_m[point], x}, {}, out);
}

const char* InWords(LookValue value) {
  switch (value) {
    case LookValue::kGiven:
      break;
    case LookValue::kBeyondPath:
      return "its time with the time bias lies beyond the flight path by more than the path's "
             "length";
    case LookValue::kNoCrossing:
      return "on the corrected flight its cone turns with the point, or never passes over it "
             "(corrections that are hardly determined allow such a flight; narrower priors, a "
             "lower degree or wider knots prevent it)";
    case LookValue::kNotAbove:
      return "its line of sight does not come from above";
    case LookValue::kNotFinite:
      return "its numbers overflow";
  }
  return "";
}

}  // namespace

bool EvaluateErrors(const LookModel& model,
                    const BlockState& state,
                    std::size_t point,
                    std::size_t look,
                    LookEvaluation* out) {
  return ValueOfErrors(model, state, point, look, out) == LookValue::kGiven;
}

std::string WhyNoValue(const AdjustmentProblem& problem,
                       const BlockState& state,
                       std::size_t point) {
  const Block& block = problem.block;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    LookEvaluation at;
    const LookValue value = ValueOfErrors(problem.model, state, point, i, &at);
    if (value == LookValue::kGiven) continue;
    return "the look of pass " + block.passes[block.looks.pass[i]].id + " at point " +
           std::string(block.points.ids[point]) + " has no value: " + InWords(value);
  }
  return "";
}

LookWeights WeightsAt(const LookSigma& sigma, double azimuth_unit_m) {
  const bool metres = sigma.azimuth_unit == AzimuthUnit::kMetres;
  return {1.0 / sigma.range_m, (metres ? azimuth_unit_m : 1.0) / sigma.azimuth};
}

double UpdateWeights(const BlockState& state, AdjustmentProblem* problem) {
  problem->model.Anchor(state.corrections);
  const Block& block = problem->block;
  const LookModel& model = problem->model;
  const std::size_t points = block.points.size();
  std::vector<double> largest((points + kPointsPerChunk - 1) / kPointsPerChunk, 0.0);
  ForChunksOfRanks(
      points,
      kPointsPerChunk,
      {SharedArray::ByRange(block.looks.offsets, &problem->weights),
       SharedArray::ByChunk(&largest)},
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        LookEvaluation at;
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem->Solves(point)) continue;
          for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
               ++i) {
            if (problem->look_used[i] == 0) continue;
            const LookSigma sigma = model.SigmaOf(i);
            const LookWeights old = problem->weights[i];
            LookWeights now = WeightsAt(sigma, 1.0);
            if (sigma.azimuth_unit == AzimuthUnit::kMetres) {
              const FlightPath& path = model.paths()[block.looks.pass[i]].path();
              if (path.IsStraight() && !block.MeasuresDoppler(i)) {
                now = WeightsAt(sigma, path.PieceVelocity_mps(0).norm());
              } else if (EvaluateErrors(model, state, point, i, &at)) {
                now = WeightsAt(sigma, at.azimuth_unit_m);
              } else if (old.azimuth_per_unit > 0.0) {
                now.azimuth_per_unit = old.azimuth_per_unit;
              } else {
                Motion motion;
                if (!path.Evaluate(block.looks.time_s[i], &motion)) continue;
                now = WeightsAt(sigma, motion.velocity_mps.norm());
              }
            }
            largest[chunk] = std::max({largest[chunk],
                                       RelativeChange(now.range_per_m, old.range_per_m),
                                       RelativeChange(now.azimuth_per_unit, old.azimuth_per_unit)});
            problem->weights[i] = now;
          }
        }
      });
  return largest.empty() ? 0.0 : *std::max_element(largest.begin(), largest.end());
}

ProblemCounts CountProblem(const AdjustmentProblem& problem) {
  ProblemCounts counts;
  counts.defects = problem.fixed.size();
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    counts.parameters += 3;
    counts.looks += static_cast<std::size_t>(problem.CountLooks(point));
    if (problem.control_of[point] >= 0) {
      counts.observations += static_cast<std::size_t>(
          problem.control[static_cast<std::size_t>(problem.control_of[point])].rows);
    }
  }
  counts.observations += 2 * counts.looks;
  for (const Parameter& parameter : problem.layout.parameters) {
    counts.parameters += 1;
    if (parameter.has_prior()) ++counts.observations;
  }
  return counts;
}

namespace {

double Floor(double radial) { return std::max(radial, kMinRadialCurvature); }

}  // namespace

double FarSquare() { return ChiSquareQuantile(0.999, 2.0); }

double RobustScale(const AdjustOptions& options) {
  if (options.robust_scale > 0.0) return options.robust_scale;
  // 95 percent efficiency at the normal distribution.
  switch (options.robust) {
    case RobustLoss::kHuber:
      return 1.345;
    case RobustLoss::kCauchy:
      return 2.385;
    case RobustLoss::kTukey:
      return 4.685;
    case RobustLoss::kNone:
      break;
  }
  return 0.0;
}

RobustValue EvaluateLoss(RobustLoss loss, double scale, double square) {
  const double b = scale * scale;
  switch (loss) {
    case RobustLoss::kNone:
      break;
    case RobustLoss::kHuber: {
      if (square <= b) break;
      const double root = std::sqrt(square);
      return {2.0 * scale * root - b, scale / root, kMinRadialCurvature};
    }
    case RobustLoss::kCauchy: {
      const double x = square / b;
      return {b * std::log1p(x), 1.0 / (1.0 + x), Floor((1.0 - x) / (1.0 + x))};
    }
    case RobustLoss::kTukey: {
      if (square >= b) return {b / 3.0, 0.0, 1.0};
      const double keep = 1.0 - square / b;
      return {b / 3.0 * (1.0 - keep * keep * keep), keep * keep, Floor((5.0 * keep - 4.0) / keep)};
    }
  }
  return {square, 1.0, 1.0};
}

}  // namespace sarblock
