// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

namespace sarblock {

inline constexpr double kLeastRadialCurvature_1 = 0.05;

/// Scale of a loss in sigmas: options.robust_scale, or the loss's own default where that is 0.
[[nodiscard]] double RobustScale(const AdjustOptions& options);

/// Whitened square length beyond which a look is far off in a robust solution: the 99.9 percent
/// point of chi-square with two degrees of freedom.
[[nodiscard]] double FarSquare_1();

/// Weight rho'(s) of a look whose whitened squared length is s >= 0, and its loss rho(s).
///     huber   rho = s, or 2 a sqrt(s) - a^2 beyond a       (Huber 1964)
///     cauchy  rho = a^2 log(1 + s/a^2)
///     tukey   rho = a^2/3 (1 - (1 - s/a^2)^3), a^2/3 beyond a   (Beaton and Tukey 1974)
struct RobustValue {
  double loss_1 = 0.0;
  double weight_1 = 1.0;
  /// Curvature along the residual over the weight, (rho' + 2 s rho'') / rho', not below
  /// kLeastRadialCurvature_1: reweighting alone takes it for 1 and creeps.
  double radial_1 = 1.0;
};
[[nodiscard]] RobustValue EvaluateLoss(RobustLoss loss, double scale, double square_1);

}  // namespace sarblock
