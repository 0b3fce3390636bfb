// SPDX-License-Identifier: Apache-2.0
#include "fixed_path_covariance.h"

#include "covariance/point_sweep.h"
#include "model/problem.h"

namespace sarblock {
namespace {

bool HasMeaning(const AdjustResult& result) {
  return !result.parameters.empty() && !result.parameter_covariance.empty() &&
         !result.points.covariance_m2.empty() && !result.variance_components;
}

}  // namespace

std::vector<SymmetricEnu> FixedPathCovariances(const Block& block,
                                               const std::vector<CorrectionGroup>& groups,
                                               const AdjustResult& result) {
  if (!HasMeaning(result)) return {};
  AdjustmentProblem problem(block, groups, result.selection.simplified);
  const auto parameters = static_cast<Eigen::Index>(result.parameters.size());
  if (problem.layout.size() != parameters) return {};
  BlockState state;
  state.start_m = result.points.position_m;
  state.displacement_m.assign(state.start_m.size(), Eigen::Vector3d::Zero());
  state.corrections.resize(parameters);
  for (Eigen::Index i = 0; i < parameters; ++i) {
    state.corrections[i] = result.parameters[static_cast<std::size_t>(i)].value;
  }
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    problem.point_status[point] = result.points.status[point];
    if (!IsSolved(result.points.status[point])) {
      problem.LeaveOut(point, result.points.status[point], "");
    }
  }
  const std::vector<std::uint8_t>& rejected = result.looks.rejected;
  for (std::size_t look = 0; look < rejected.size() && look < block.looks.size(); ++look) {
    if (rejected[look] != 0) problem.look_used[look] = 0;
  }
  if (result.snooping) {
    for (const BlunderFinding& finding : result.snooping->findings) {
      if (finding.action == BlunderFinding::Action::kControlReleased) {
        problem.control_of[finding.point] = -1;
      }
    }
  }
  UpdateWeights(state, &problem);
  return SweepPoints(problem, state, nullptr, false, nullptr).covariance_m2;
}

}  // namespace sarblock
