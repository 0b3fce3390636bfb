// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sarblock::test {

/// A shipped scene, `name` without folder and suffix.
[[nodiscard]] Scene ShippedScene(const std::string& name,
                                 const std::vector<std::string>& overrides = {});

/// The scene's own [adjust], one thread.
[[nodiscard]] AdjustOptions OptionsOf(const Scene& scene, const Block& block);

/// A sum of independent squares that should follow chi-square with `degrees` of freedom.
struct SquareSum {
  double value = 0.0;
  double degrees = 0.0;
  void Add(double square, double square_degrees) {
    value += square;
    degrees += square_degrees;
  }
  /// Share of degrees; 1 is expected.
  [[nodiscard]] double mean() const { return value / degrees; }
};

/// Sums over the draws of a scene. Within a draw all points hang together through the corrections;
/// a sum takes one square of known degrees from each draw, so that it is chi-square exactly.
struct SceneStatistics {
  std::size_t draws = 0;
  std::size_t accepted = 0;               ///< adjustments that were
  std::size_t alarms = 0;                 ///< whose tests of observations or priors failed
  std::size_t unsolved = 0;               ///< points not adjusted, over all draws
  SquareSum point;                        ///< e'Q^-1 e of one tie point a draw, seeded choice
  SquareSum pair;                         ///< of the difference of two tie points a draw
  SquareSum check;                        ///< of one check point a draw
  SquareSum corrections;                  ///< of all corrections of a draw together
  SquareSum residuals;                    ///< v'Pv
  std::vector<SquareSum> each_point;      ///< of every tie point, over the draws
  std::vector<SquareSum> each_parameter;  ///< of every correction alone, over the draws
  std::vector<std::string> parameters;    ///< "A1 position.along.0"
};

/// Redraws everything random of a scene `draws` times (seeds first_seed, first_seed + 1, ...) and
/// adjusts each draw with the scene's own [adjust]; `edit`, if given, changes the block that is
/// adjusted, not what is drawn.
[[nodiscard]] SceneStatistics RunDraws(const Scene& scene,
                                       std::size_t draws,
                                       std::uint64_t first_seed,
                                       const std::function<void(Block*)>& edit = {});

/// SARBLOCK_DRAWS, 200 without it; throws InputError where it is no whole number above 0.
[[nodiscard]] std::size_t DrawsAsked();

}  // namespace sarblock::test
