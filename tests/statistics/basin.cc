// SPDX-License-Identifier: Apache-2.0
#include "statistics/basin.h"

#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "simulate/true_path.h"
#include "statistics/scene_statistics.h"
#include <Eigen/Cholesky>

namespace sarblock::test {
namespace {

constexpr std::uint64_t kPathStream = 8123;
constexpr std::uint64_t kErrorStream = 8124;
constexpr double kMinSize = 20.0, kMaxSize = 2000.0;  // of a gross error, in sigmas
constexpr double kWrong = 10.0;
constexpr double kRealisticRms = 3.0;  // of sqrt(e'C^-1 e / 3) over the untouched points
constexpr double kMaxLost = 0.05;
constexpr double kMirrorPart = 0.2;

std::size_t DrawBelow(std::size_t count, RandomStream* random) {
  return std::min(count - 1,
                  static_cast<std::size_t>(random->Uniform() * static_cast<double>(count)));
}

/// Standard deviations of a constant path error of expected length `path_m`.
std::array<double, 3> PathSigmas(const SceneNavigation& navigation, double path_m) {
  std::array<double, 3> sigma_m = navigation.constant_sigma_m;
  const double length_m = std::hypot(sigma_m[0], sigma_m[1], sigma_m[2]);
  for (double& s : sigma_m) s *= path_m / length_m;
  return sigma_m;
}

/// Displaces the given paths of `block`, which are those of `simulated`.
void DisplacePaths(const SimulatedBlock& simulated,
                   const std::array<double, 3>& sigma_m,
                   std::uint64_t seed,
                   Block* block) {
  RandomStream random(seed, kPathStream);
  for (std::size_t pass = 0; pass < block->passes.size(); ++pass) {
    PassError error;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      error.constant_m[axis] = sigma_m[axis] * random.Normal();
    }
    const Pass& planned = simulated.block.passes[pass];
    block->passes[pass].path = TruePath(block->frame, planned, error, kNotGiven).AtNominalTimes();
  }
}

/// The priors of constant position corrections, widened by these standard deviations.
void WidenPriors(const std::array<double, 3>& sigma_m, AdjustOptions* options) {
  for (CorrectionGroup& group : options->groups) {
    auto* position = std::get_if<PositionCorrection>(&group.model);
    if (position == nullptr) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double>& prior_m = position->prior_sigma_m[axis];
      if (!prior_m.empty()) prior_m[0] = std::hypot(prior_m[0], sigma_m[axis]);
    }
  }
}

/// Plants gross errors; by point, 1 where one of its looks was touched.
std::vector<std::uint8_t> PlantErrors(const SimulatedBlock& simulated,
                                      const BasinCell& cell,
                                      std::uint64_t seed,
                                      Block* block) {
  std::vector<std::uint8_t> touched(block->points.size(), 0);
  RandomStream random(seed, kErrorStream);
  Looks& looks = block->looks;
  std::vector<std::uint32_t> point_of(looks.size());
  std::vector<std::vector<std::size_t>> tie_looks(block->passes.size());
  std::size_t count = 0;
  for (std::uint32_t point = 0; point < block->points.size(); ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      point_of[i] = point;
      if (block->points.role[point] != PointRole::kTie) continue;
      tie_looks[looks.pass[i]].push_back(i);
      ++count;
    }
  }
  std::vector<std::size_t> all;
  for (const auto& of_pass : tie_looks) all.insert(all.end(), of_pass.begin(), of_pass.end());
  const auto wanted =
      static_cast<std::size_t>(std::lround(cell.fraction * static_cast<double>(count)));
  std::vector<std::uint8_t> used(looks.size(), 0);
  for (std::size_t planted = 0; planted < wanted;) {
    const std::size_t look = all[DrawBelow(all.size(), &random)];
    if (used[look] != 0) continue;
    used[look] = 1;
    touched[point_of[look]] = 1;
    ++planted;
    const double size = kMinSize * std::pow(kMaxSize / kMinSize, random.Uniform()) *
                        (random.Uniform() < 0.5 ? -1.0 : 1.0);
    const LookSigma sigma = block->SigmaOf(look);
    if (cell.kind == GrossError::kRange) {
      looks.range_m[look] += size * sigma.range_m;
    } else if (cell.kind == GrossError::kAzimuth) {
      const bool metres = sigma.azimuth_unit == AzimuthUnit::kMetres;
      looks.time_s[look] +=
          size * sigma.azimuth / (metres ? simulated.exact.azimuth_rate_mps[look] : 1.0);
    } else {
      const std::vector<std::size_t>& of_pass = tie_looks[looks.pass[look]];
      std::size_t other = look;
      for (int trial = 0; trial < 100 && used[other] != 0; ++trial) {
        other = of_pass[DrawBelow(of_pass.size(), &random)];
      }
      if (used[other] != 0) continue;
      used[other] = 1;
      touched[point_of[other]] = 1;
      ++planted;
      std::swap(looks.time_s[look], looks.time_s[other]);
      std::swap(looks.range_m[look], looks.range_m[other]);
    }
  }
  // A time beyond the path cannot be read: such a look would be refused, not mistaken.
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const FlightPath& path = block->passes[looks.pass[i]].path;
    looks.time_s[i] = std::clamp(looks.time_s[i], path.start_s(), path.end_s());
  }
  return touched;
}

}  // namespace

const std::vector<BasinWay>& BasinWays() {
  static const std::vector<BasinWay> ways = {
      {"none", RobustLoss::kNone, Snooping::kNone},
      {"huber", RobustLoss::kHuber, Snooping::kNone},
      {"cauchy", RobustLoss::kCauchy, Snooping::kNone},
      {"tukey", RobustLoss::kTukey, Snooping::kNone},
      {"iterative", RobustLoss::kNone, Snooping::kIterative},
      {"robust", RobustLoss::kNone, Snooping::kRobust},
  };
  return ways;
}

const char* NameOf(GrossError kind) {
  switch (kind) {
    case GrossError::kRange:
      return "range";
    case GrossError::kAzimuth:
      return "azimuth";
    case GrossError::kMatch:
      return "match";
  }
  return "";
}

BasinScene::BasinScene(const std::string& name, std::size_t points)
    : scene_(points == 0
                 ? ShippedScene(name, {"check.count=0"})
                 : ShippedScene(name, {"check.count=0", "points.count=" + std::to_string(points)})),
      simulated_(Simulate(scene_)),
      options_(OptionsOf(scene_, simulated_.block)) {
  options_.test_level = kBasinTestLevel;
  const AdjustResult clean = Adjust(simulated_.block, options_);
  for (const PointStatus status : clean.points.status) {
    solvable_.push_back(status == PointStatus::kAdjusted ? 1 : 0);
  }
}

BasinOutcome BasinScene::Run(const BasinCell& cell, const BasinWay& way, std::uint64_t seed) {
  Redraw(scene_, seed, RedrawChoice{}, &simulated_);
  Block block = simulated_.block;
  AdjustOptions options = options_;
  options.robust = way.robust;
  options.quality.snooping = way.snooping;
  if (cell.path_m > 0.0) {
    const std::array<double, 3> sigma_m = PathSigmas(scene_.navigation, cell.path_m);
    DisplacePaths(simulated_, sigma_m, seed, &block);
    WidenPriors(sigma_m, &options);
  }
  const std::vector<std::uint8_t> touched = PlantErrors(simulated_, cell, seed, &block);

  BasinOutcome outcome;
  const auto start = std::chrono::steady_clock::now();
  AdjustResult result;
  try {
    result = Adjust(block, options);
  } catch (const std::exception& error) {
    outcome.refused = true;
    outcome.words = error.what();
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (outcome.refused) return outcome;
  outcome.sigma0_squared = result.sigma0_squared;
  outcome.iterations = result.iterations;
  outcome.accepted = result.usable() && result.chi_square_passed;
  if (!result.assessment.reasons.empty()) {
    outcome.words = result.assessment.reasons.front();
  } else if (!result.warnings.empty()) {
    outcome.words = result.warnings.back();
  }
  std::size_t untouched = 0, lost = 0;
  double square_sum = 0.0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (touched[point] != 0 || solvable_[point] == 0) continue;
    ++untouched;
    if (!IsSolved(result.points.status[point])) {
      ++lost;
      continue;
    }
    const Eigen::Vector3d& p_m = result.points.position_m[point];
    const Eigen::Vector3d error_m =
        block.frame.EnuFromFrame(p_m) * (p_m - simulated_.truth.points_m[point]);
    const Eigen::LLT<Eigen::Matrix3d> factor(MatrixOf(result.points.covariance_m2[point]));
    const double square =
        factor.info() == Eigen::Success ? factor.matrixL().solve(error_m).squaredNorm() : 1e12;
    square_sum += square;
    outcome.worst_sigma = std::max(outcome.worst_sigma, std::sqrt(square));
    const double range_m = block.looks.range_m[block.looks.offsets[point]];
    outcome.mirror = outcome.mirror || error_m.norm() > kMirrorPart * range_m;
  }
  const auto counted = static_cast<double>(std::max<std::size_t>(untouched, 1));
  outcome.lost_share = static_cast<double>(lost) / counted;
  const double rms = std::sqrt(square_sum / (3.0 * counted));
  outcome.wrong = outcome.accepted && outcome.worst_sigma > kWrong;
  outcome.mirror = outcome.accepted && outcome.mirror;
  outcome.recovered =
      outcome.accepted && !outcome.wrong && rms < kRealisticRms && outcome.lost_share <= kMaxLost;
  return outcome;
}

}  // namespace sarblock::test
