// SPDX-License-Identifier: Apache-2.0
#include "robust.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
namespace {

double Floor(double radial) { return std::max(radial, kLeastRadialCurvature_1); }

}  // namespace

double FarSquare_1() { return ChiSquareQuantile(0.999, 2.0); }

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
      return {2.0 * scale * root - b, scale / root, kLeastRadialCurvature_1};
    }
    case RobustLoss::kCauchy: {
      const double x = square_1 / b;
      return {b * std::log1p(x), 1.0 / (1.0 + x), Floor((1.0 - x) / (1.0 + x))};
    }
    case RobustLoss::kTukey: {
      if (square_1 >= b) return {b / 3.0, 0.0, 1.0};
      const double keep = 1.0 - square_1 / b;
      return {b / 3.0 * (1.0 - keep * keep * keep), keep * keep, Floor((5.0 * keep - 4.0) / keep)};
    }
  }
  return {square_1, 1.0, 1.0};
}

}  // namespace sarblock
