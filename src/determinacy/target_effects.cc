// SPDX-License-Identifier: Apache-2.0
#include "target_effects.h"

#include <cmath>

namespace sarblock {

TargetEffects TargetEffectsOf(const AdjustmentProblem& problem, const std::vector<int>& pass_of) {
  const Block& block = problem.block;
  double sum_m = 0.0, speed_mps = 0.0, count = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (problem.look_used[i] == 0 || !std::isfinite(block.looks.range_m[i])) continue;
    sum_m += block.looks.range_m[i];
    count += 1.0;
  }
  for (const Pass& pass : block.passes) {
    speed_mps +=
        pass.path.states().front().velocity_mps.norm() / static_cast<double>(block.passes.size());
  }
  TargetEffects out;
  out.range_m = count > 0.0 ? sum_m / count : 0.0;
  out.metres = Eigen::VectorXd::Ones(problem.layout.size());
  for (std::size_t i = 0; i < problem.layout.parameters.size(); ++i) {
    const int pass = pass_of[i];
    double& metres = out.metres[static_cast<Eigen::Index>(i)];
    switch (problem.layout.parameters[i].kind) {
      case ParameterKind::kPosition:
      case ParameterKind::kRangeBias:
      case ParameterKind::kZenithDelay:
        break;
      case ParameterKind::kTimeBias:
        metres = pass < 0 ? speed_mps
                          : block.passes[static_cast<std::size_t>(pass)]
                                .path.states()
                                .front()
                                .velocity_mps.norm();
        break;
      case ParameterKind::kVelocityAcross:
      case ParameterKind::kVelocityUp:
      case ParameterKind::kRangeScale:
      case ParameterKind::kSquintBias:
        metres = out.range_m;
    }
  }
  return out;
}

}  // namespace sarblock
