// SPDX-License-Identifier: Apache-2.0
#include "selection_determinacy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "linear/dense.h"
#include "quadratic_model.h"
#include "solve/rank.h"
#include "solve/weak_directions.h"

namespace sarblock {

Eigen::VectorXd EffectParts(const AdjustmentProblem& problem) {
  const TargetEffects effects = TargetEffectsOf(problem, PassOfParameters(problem.layout));
  Eigen::VectorXd parts = Eigen::VectorXd::Zero(effects.metres.size());
  if (!(effects.range_m > 0.0)) return parts;
  for (Eigen::Index i = 0; i < parts.size(); ++i) {
    if (problem.layout.parameters[static_cast<std::size_t>(i)].has_prior()) continue;
    parts[i] = effects.metres[i] / effects.range_m;
  }
  return parts;
}

Determinacy DeterminacyOf(const Eigen::MatrixXd& s,
                          const Eigen::VectorXd& full_diagonal,
                          const Eigen::VectorXd& prior_weight,
                          const Eigen::VectorXd& effect_part_1,
                          const std::vector<int>& active) {
  Determinacy out;
  if (active.empty()) return out;
  constexpr double kOpen = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd part = s(active, active);
  part.diagonal() += prior_weight(active);
  const Eigen::VectorXd diagonal = full_diagonal(active) + prior_weight(active);
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return {kOpen, kOpen};
  part = scale.asDiagonal() * part * scale.asDiagonal();
  out.condition_1 = ConditionOf(part);
  if (!std::isfinite(out.condition_1)) return {kOpen, kOpen};
  const Eigen::Index n = part.rows();
  const Eigen::MatrixXd covariance = dense::Cholesky(part).Inverse();
  for (Eigen::Index k = 0; k < n; ++k) {
    const int column = active[static_cast<std::size_t>(k)];
    if (prior_weight[column] > 0.0) continue;
    const double sigma = scale[k] * std::sqrt(covariance(k, k));
    out.effect_part_1 = std::max(out.effect_part_1, effect_part_1[column] * sigma);
  }
  return out;
}

double MostCondition(const SelectionOptions& options) {
  return std::min(options.max_condition_1, 1.0 / kNearEigenvalue_1);
}

bool Stands(const Determinacy& determinacy, const SelectionOptions& options) {
  return determinacy.condition_1 <= MostCondition(options) &&
         determinacy.effect_part_1 <= kNearEffectPart_1;
}

}  // namespace sarblock
