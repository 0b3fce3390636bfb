// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/adjust.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sarblock::test {

/// How a user may ask for the adjustment of a block with gross errors.
struct BasinWay {
  std::string name;
  RobustLoss robust = RobustLoss::kNone;
  Snooping snooping = Snooping::kNone;
};
[[nodiscard]] const std::vector<BasinWay>& BasinWays();

/// Gross errors of tie looks: of the range, of the time, or two points of a pass exchanged.
enum class GrossError { kRange, kAzimuth, kMatch };
[[nodiscard]] const char* NameOf(GrossError kind);

/// One cell of the basin: how far the given paths are off and how many looks are wrong.
struct BasinCell {
  double path_m = 0.0;    ///< expected length of the constant error of a path; 0: the scene's own
  double fraction = 0.0;  ///< of the tie looks
  GrossError kind = GrossError::kRange;
};

/// What came of one draw.
struct BasinOutcome {
  bool accepted = false;   ///< and the global test at kBasinTestLevel passed
  bool refused = false;    ///< an exception
  bool recovered = false;  ///< accepted, untouched points realistic, at most 5 percent of them lost
  bool wrong = false;      ///< accepted, an untouched point off by more than 10 sigma
  bool mirror = false;     ///< accepted, an untouched point off by more than a fifth of its range
  double lost_share = 0.0;   ///< part of the untouched points without a position
  double worst_sigma = 0.0;  ///< largest sqrt(e'C^-1 e) of an untouched point
  double sigma0_squared = 0.0;
  int iterations = 0;
  double wall_s = 0.0;
  std::string words;  ///< why it was refused or not accepted, else the last warning
};

/// Level of the global test: one clean block in 10,000 fails it.
inline constexpr double kBasinTestLevel = 0.9999;

/// A shipped scene whose draws are adjusted from poor starts and with gross errors. Paths: the true
/// flights stay as planned, the given ones are displaced by a constant in track axes, drawn in the
/// proportions that the scene's navigation has, and the priors of the corrections say so.
class BasinScene {
 public:
  /// `points` tie points, 0: the scene's own number.
  BasinScene(const std::string& name, std::size_t points);
  /// As before there was one (docs/theory/consensus.md).
  void LeaveConsensusAway() { options_.quality.consensus = false; }
  [[nodiscard]] BasinOutcome Run(const BasinCell& cell, const BasinWay& way, std::uint64_t seed);

 private:
  Scene scene_;
  SimulatedBlock simulated_;
  AdjustOptions options_;
  std::vector<std::uint8_t> solvable_;  ///< by point: adjusted where nothing is wrong
};

}  // namespace sarblock::test
