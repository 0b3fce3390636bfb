// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "accuracy.h"

namespace sarblock {

/// What limits the accuracy, and what would improve it; empty where control or a single look
/// decides every point.
struct Advice {
  std::string would_help;  ///< "azimuth accuracy, more looks"
  std::string sentence;
};

/// The advice follows from three numbers of the points that geometry decides (AccuracyFigures):
/// the flight paths' part of the variance of the weakest component (above 0.6: control or better
/// paths; below 0.4: better looks; between: both), the direction of that component (along track,
/// where azimuth measures it, above 0.7; across track or up, which ranges measure, below 0.3), and
/// the angle of intersection (larger ones are advised below 60 degrees only).
[[nodiscard]] Advice AdviceOf(const AccuracyFigures& accuracy, const Frame& frame);

}  // namespace sarblock
