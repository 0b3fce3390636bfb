// SPDX-License-Identifier: Apache-2.0
#include "size_search.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "edits.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

constexpr int kQuickRounds = 2, kMostRounds = 6;
/// Of a standard deviation, from which on a size counts as found.
constexpr double kFound_1 = 0.05;

bool MayHoldPoint(const KnownPosition& known) {
  int held = 0;
  for (const bool component : known.held) held += component ? 1 : 0;
  if (held < 3) return held > 0;
  return Eigen::LLT<Eigen::Matrix3d>(known.covariance_enu_m2).info() == Eigen::Success;
}

/// Sum of ln sigma^2 of all measurements.
double LogSigmas(const Block& block) {
  double sum_1 = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const LookSigma sigma = block.SigmaOf(i);
    sum_1 += 2.0 * std::log(sigma.range_m * sigma.azimuth);
  }
  return sum_1;
}

void HoldCheckPoints(Block* block) {
  for (const KnownPosition& known : block->points.known) {
    PointRole& role = block->points.role[known.point];
    if (role == PointRole::kCheck && MayHoldPoint(known)) role = PointRole::kControl;
  }
}

constexpr double kMostLogMove_1 = 3.0;
/// Of what the parabola through three solutions takes off the cost, how much may be there.
constexpr double kPromised_1 = 4.0;

}  // namespace

Trials::Trials(const Block& sample, CorrectionModel corrections, Work work, ProgressSink* progress)
    : sample_(sample),
      given_(sample),
      corrections_(std::move(corrections)),
      work_(work),
      progress_(progress) {
  HoldCheckPoints(&given_);
  for (const Pass& pass : sample_.passes) states_ += pass.RecordedStates().size();
}

Fit Trials::Solve(const Block& block, const FitOptions& options) {
  ++solutions_;
  Fit fit = SolveSample(block, corrections_, options, progress_);
  const auto start = options.warm == nullptr ? Work::Start::kOfItsOwn : Work::Start::kOfAnother;
  work_.AddSolution(block.looks.size(), fit, start, states_);
  return fit;
}

Fit Trials::AsItIs() { return Solve(given_, {}); }

Fit Trials::Without(const std::vector<std::uint32_t>& points, const FitOptions& options) {
  std::vector<std::uint8_t>& flags = given_.looks.flags;
  const std::vector<std::uint8_t> before = flags;
  for (const std::uint32_t point : points) {
    for (std::size_t i = given_.looks.offsets[point]; i < given_.looks.offsets[point + 1]; ++i) {
      flags[i] |= Looks::kRejected;
    }
  }
  Fit fit = Solve(given_, options);
  flags = before;
  return fit;
}

Fit Trials::With(const Hypothesis& hypothesis, double value, const FitOptions& options) {
  Block block = sample_;
  hypothesis.undo(&block, value);
  FitStrips(&block);
  HoldCheckPoints(&block);
  work_.AddSmoothed(hypothesis.smoothed_states);
  Fit fit = Solve(block, options);
  if (block.looks.size() == sample_.looks.size() && fit.looks > 0) {
    const double part_1 =
        std::clamp(fit.redundancy_1 / (2.0 * static_cast<double>(fit.looks)), 0.0, 1.0);
    fit.log_sigmas_1 = part_1 * (LogSigmas(block) - LogSigmas(sample_));
  }
  return fit;
}

Solved SearchSize(const Hypothesis& hypothesis,
                  const Fit& first,
                  const SearchOptions& options,
                  Trials* trials) {
  Solved best{hypothesis.value, kNotGiven, first};
  if (!hypothesis.free || !first.solved) return best;
  double step = hypothesis.step;
  const auto at = [&](double value) {
    return trials->With(hypothesis, value, {.warm = &best.fit.state, .effort = options.effort});
  };
  const int rounds = options.effort == Effort::kQuick ? kQuickRounds : kMostRounds;
  for (int round = 0; round < rounds; ++round) {
    if (!trials->work().Allows(options.part_of_work_1)) break;
    Fit above = at(best.value + step), below = at(best.value - step);
    const double here_1 = best.fit.Cost();
    const double slope = (above.Cost() - below.Cost()) / (2.0 * step);
    const double curvature = (above.Cost() - 2.0 * here_1 + below.Cost()) / (step * step);
    const auto take = [&best](double value, Fit fit) {
      if (!fit.solved || !(fit.Cost() < best.fit.Cost())) return false;
      best.fit = std::move(fit);
      best.value = value;
      return true;
    };
    if (!(curvature > 0.0) || !std::isfinite(curvature)) {
      const double from = best.value;
      if (!take(from + step, std::move(above))) take(from - step, std::move(below));
      step *= 4.0;
      continue;
    }
    best.sigma = std::sqrt(2.0 / curvature);
    const double promised_1 = 0.5 * slope * slope / curvature;
    if (here_1 - kPromised_1 * promised_1 > options.useless_above_1) break;
    double move = -slope / curvature;
    // Standard deviations far off bend the cost: a parabola is good for a few powers of e.
    if (hypothesis.logarithm) move = std::clamp(move, -kMostLogMove_1, kMostLogMove_1);
    bool moved = false;
    for (int shorter = 0; shorter < 3 && !moved; ++shorter, move *= 0.25) {
      if (!trials->work().Allows(options.part_of_work_1)) break;
      moved = take(best.value + move, at(best.value + move));
      if (std::abs(move) < kFound_1 * best.sigma) break;
    }
    const bool fine = step < 5.0 * best.sigma && step > 0.2 * best.sigma;
    if (fine && (std::abs(slope / curvature) < kFound_1 * best.sigma || !moved)) break;
    step = hypothesis.logarithm ? std::min(best.sigma, 1.0) : best.sigma;
  }
  return best;
}

}  // namespace sarblock
