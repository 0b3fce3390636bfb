// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// What a model of corrections leaves open.
struct Determinacy {
  double condition_1 = 1.0;    ///< CandidateFigures::condition_1 of all its columns
  double effect_part_1 = 0.0;  ///< largest standard deviation of a parameter without a prior, as
                               ///< movement at the target, part of the mean slant range
};

/// Part of the mean slant range that one unit of each parameter moves a look; 0 where it has a
/// prior.
[[nodiscard]] Eigen::VectorXd EffectParts(const AdjustmentProblem& problem);

/// `s` and `full_diagonal` as in QuadraticModel::Data; `prior_weight` is added to both, and what
/// has one is not judged by its effect.
[[nodiscard]] Determinacy DeterminacyOf(const Eigen::MatrixXd& s,
                                        const Eigen::VectorXd& full_diagonal,
                                        const Eigen::VectorXd& prior_weight,
                                        const Eigen::VectorXd& effect_part_1,
                                        const std::vector<int>& active);

/// The largest condition that is asked for and that the rank analysis does not warn of.
[[nodiscard]] double MostCondition(const SelectionOptions& options);

/// True for a model of which the rank analysis of the adjustment that follows (solve/rank.h)
/// does not warn, let alone refuses it.
[[nodiscard]] bool Stands(const Determinacy& determinacy, const SelectionOptions& options);

}  // namespace sarblock
