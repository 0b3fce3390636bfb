// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/robust.h"

#include <cmath>

namespace sarblock {

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

RobustValue EvaluateLoss(RobustLoss loss, double scale, double square_1) {
  const double b = scale * scale;
  switch (loss) {
    case RobustLoss::kNone:
      break;
    case RobustLoss::kHuber: {
      if (square_1 <= b) break;
      const double root = std::sqrt(square_1);
      return {2.0 * scale * root - b, scale / root};
    }
    case RobustLoss::kCauchy:
      return {b * std::log1p(square_1 / b), 1.0 / (1.0 + square_1 / b)};
    case RobustLoss::kTukey: {
      if (square_1 > b) return {b / 3.0, 0.0};
      const double keep = 1.0 - square_1 / b;
      return {b / 3.0 * (1.0 - keep * keep * keep), keep * keep};
    }
  }
  return {square_1, 1.0};
}

}  // namespace sarblock
