// SPDX-License-Identifier: Apache-2.0
#include "rounding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "core/threads.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 4096;
constexpr double kRounding_1 = std::numeric_limits<double>::epsilon();
/// Of a standard deviation, above which rounding is told of.
constexpr double kTold_1 = 1e-4;

/// The worst equation met so far.
struct Worst {
  double part_1 = 0.0;
  double rounding_m = 0.0;
  std::size_t point = 0, points = 0;

  void Add(const Worst& other) {
    points += other.points;
    if (other.part_1 <= part_1) return;
    part_1 = other.part_1;
    rounding_m = other.rounding_m;
    point = other.point;
  }
};

Worst OfPoint(const AdjustmentProblem& problem, const BlockState& state, std::size_t point) {
  const Looks& looks = problem.block.looks;
  const double point_m = state.Position(point).lpNorm<Eigen::Infinity>();
  Worst worst;
  worst.point = point;
  const auto meet = [&](double rounding_m, double per_m) {
    if (!(rounding_m * per_m > worst.part_1)) return;
    worst.part_1 = rounding_m * per_m;
    worst.rounding_m = rounding_m;
  };
  for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
    if (problem.look_used[i] == 0) continue;
    const std::size_t pass = looks.pass[i];
    Motion motion;
    if (!problem.block.passes[pass].path.Evaluate(looks.time_s[i], &motion)) continue;
    double rounding_m =
        kRounding_1 *
        std::max({point_m, motion.position_m.lpNorm<Eigen::Infinity>(), looks.range_m[i]});
    // A time is no finer in its file than it is here.
    rounding_m += kRounding_1 * std::abs(looks.time_s[i]) * motion.velocity_mps.norm();
    const LookWeights& w = problem.weights[i];
    const double unit_m = problem.block.RoughAzimuthUnit_m(i, motion.velocity_mps.norm());
    meet(rounding_m, std::max(w.range_per_m, w.azimuth_per_unit / unit_m));
  }
  worst.points = worst.part_1 > kTold_1 ? 1 : 0;
  return worst;
}

}  // namespace

void WarnOfRounding(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result) {
  const std::size_t points = problem.block.points.size();
  std::vector<Worst> parts((points + kPointsPerChunk - 1) / kPointsPerChunk);
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByChunk(&parts)},
                   [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                     for (std::size_t point = begin; point < end; ++point) {
                       if (problem.Solves(point)) parts[chunk].Add(OfPoint(problem, state, point));
                     }
                   });
  Worst worst;
  for (const Worst& part : parts) worst.Add(part);
  if (worst.points == 0) return;
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.1e m, %.1e", worst.rounding_m, worst.part_1);
  Warn(result,
       std::to_string(worst.points) +
           " points have looks weighted finer than the rounding of double precision "
           "carries their coordinates or times, the worst is " +
           std::string(problem.block.points.ids[worst.point]) + ": one rounding is " + text.data() +
           " of the standard deviation; sigmas describe the weights, not the digits of the "
           "positions. Move the origin of coordinates or times nearer");
}

}  // namespace sarblock
