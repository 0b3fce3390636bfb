// SPDX-License-Identifier: Apache-2.0
#include "problem.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 4096;

ControlEquations MakeControl(const Block& block, const KnownPosition& known) {
  ControlEquations control;
  control.point = known.point;
  control.known_m = block.points.given_m[known.point];
  std::array<int, 3> held{};
  for (int i = 0; i < 3; ++i) {
    if (known.held[static_cast<std::size_t>(i)]) held[static_cast<std::size_t>(control.rows++)] = i;
  }
  control.height_only =
      control.rows == 1 && held[0] == 2 && block.frame.kind() == FrameKind::kGeocentric;
  const Eigen::Matrix3d enu_from_frame = block.frame.EnuFromFrame(control.known_m);
  Eigen::MatrixXd covariance(control.rows, control.rows), rotation(control.rows, 3);
  for (int i = 0; i < control.rows; ++i) {
    rotation.row(i) = enu_from_frame.row(held[static_cast<std::size_t>(i)]);
    for (int j = 0; j < control.rows; ++j) {
      covariance(i, j) = known.covariance_enu_m2(held[static_cast<std::size_t>(i)],
                                                 held[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) {
    throw InputError("point " + std::string(block.points.ids[known.point]),
                     "the covariance of the control is not positive definite");
  }
  control.weight.topRows(control.rows) = factor.matrixL().solve(rotation);
  return control;
}

double RelativeChange(double now, double before, double scale) {
  return std::abs(now - before) / scale;
}

}  // namespace

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
    out.by_point.row(0) = weight * at.up_1.transpose();
    return out;
  }
  out.residual = control.weight * ((start_m - control.known_m) + displacement_m);
  out.by_point = control.weight;
  return out;
}

AdjustmentProblem::AdjustmentProblem(const Block& source,
                                     const std::vector<CorrectionGroup>& asked,
                                     const Simplified& simplified)
    : block(source),
      groups(asked),
      layout(MakeParameterLayout(source, groups)),
      model(source, layout, simplified) {
  const std::size_t points = block.points.size(), looks = block.looks.size();
  look_used.resize(looks);
  for (std::size_t i = 0; i < looks; ++i) look_used[i] = block.looks.rejected(i) ? 0 : 1;
  point_status.assign(points, PointStatus::kAdjusted);
  point_reason.resize(points);
  whitening.resize(looks);
  control_of.assign(points, -1);
  for (const KnownPosition& known : block.points.known) {
    const bool any = known.held[0] || known.held[1] || known.held[2];
    if (block.points.role[known.point] != PointRole::kControl || !any) continue;
    control_of[known.point] = static_cast<std::int32_t>(control.size());
    control.push_back(MakeControl(block, known));
  }
}

void AdjustmentProblem::LeaveOut(std::size_t point, PointStatus status, const std::string& reason) {
  point_status[point] = status;
  point_reason[point] = reason;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    look_used[i] = 0;
  }
}

int AdjustmentProblem::CountLooks(std::size_t point) const {
  const auto begin = look_used.begin() + static_cast<std::ptrdiff_t>(block.looks.offsets[point]);
  const auto end = look_used.begin() + static_cast<std::ptrdiff_t>(block.looks.offsets[point + 1]);
  return static_cast<int>(std::count(begin, end, std::uint8_t{1}));
}

WhiteningChange UpdateWhitening(const BlockState& state, AdjustmentProblem* problem) {
  const Block& block = problem->block;
  const std::size_t points = block.points.size();
  std::vector<AdjustedTime>& times = problem->model.adjusted_times();
  times.resize(block.looks.size());
  std::vector<WhiteningChange> largest((points + kPointsPerChunk - 1) / kPointsPerChunk);
  ParallelForChunks(
      points, kPointsPerChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        WhiteningChange& change = largest[chunk];
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem->Solves(point)) continue;
          for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
               ++i) {
            if (problem->look_used[i] == 0) continue;
            const auto at = problem->model.Linearise(
                i, state.start_m[point], state.displacement_m[point], state.corrections);
            if (!at) continue;
            const Whitening& w = at->whitening;
            Whitening& old = problem->whitening[i];
            const double scale = std::max({std::abs(w.w00), std::abs(w.w10), std::abs(w.w11)});
            change.weight_1 = std::max({change.weight_1,
                                        RelativeChange(w.w00, old.w00, scale),
                                        RelativeChange(w.w10, old.w10, scale),
                                        RelativeChange(w.w11, old.w11, scale)});
            change.time_1 = std::max(change.time_1, at->moved_1);
            old = w;
            times[i] = at->time;
          }
        }
      });
  WhiteningChange out;
  for (const WhiteningChange& change : largest) {
    out.weight_1 = std::max(out.weight_1, change.weight_1);
    out.time_1 = std::max(out.time_1, change.time_1);
  }
  return out;
}

ProblemCounts CountProblem(const AdjustmentProblem& problem) {
  ProblemCounts counts;
  counts.defects = problem.held.size();
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

}  // namespace sarblock
