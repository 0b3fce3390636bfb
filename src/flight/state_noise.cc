// SPDX-License-Identifier: Apache-2.0
#include "state_noise.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sarblock {
namespace {

constexpr std::size_t kLeastDifference = 3, kMostDifference = 10;
constexpr std::size_t kMostWindows = 256;
/// White noise keeps its size from one order to the next; a flight that the states can follow loses
/// at least half.
constexpr double kStillFalling_1 = 0.7;

struct Squares {
  double position = 0.0, velocity = 0.0;
};

/// Mean square of an element of the divided differences through `order + 1` states, scaled so that
/// white noise of one comes out as one.
Squares DifferenceSquares(std::span<const StateVector> states, std::size_t order) {
  const std::size_t windows = states.size() - order;
  const std::size_t step = (windows + kMostWindows - 1) / kMostWindows;
  Squares sum;
  double count = 0.0;
  for (std::size_t first = 0; first < windows; first += step) {
    std::array<double, kMostDifference + 1> weight{};
    double square = 0.0;
    const double scale_s =
        (states[first + order].time_s - states[first].time_s) / static_cast<double>(order);
    for (std::size_t i = 0; i <= order; ++i) {
      weight[i] = 1.0;
      for (std::size_t j = 0; j <= order; ++j) {
        if (j != i) weight[i] *= scale_s / (states[first + i].time_s - states[first + j].time_s);
      }
      square += weight[i] * weight[i];
    }
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i <= order; ++i) {
      position += weight[i] * (states[first + i].position_m - states[first].position_m);
      velocity += weight[i] * (states[first + i].velocity_mps - states[first].velocity_mps);
    }
    sum.position += position.squaredNorm() / square;
    sum.velocity += velocity.squaredNorm() / square;
    count += 3.0;
  }
  return {sum.position / count, sum.velocity / count};
}

/// The first order whose mean square is not significantly above the least: of those that show noise
/// alone the one of most windows.
double NoiseOf(const std::vector<double>& squares, std::size_t states) {
  const std::size_t n = squares.size();
  constexpr double kFalling = kStillFalling_1 * kStillFalling_1;
  const bool unresolved = n < 2 || (squares[n - 1] < kFalling * squares[n - 2] &&
                                    (n < 3 || squares[n - 2] < kFalling * squares[n - 3]));
  if (unresolved) return 0.0;
  const double least = *std::min_element(squares.begin(), squares.end());
  const auto windows = static_cast<double>(std::min(kMostWindows, states));
  const double most = least * (1.0 + 2.0 / std::sqrt(windows));
  return std::sqrt(*std::find_if(
      squares.begin(), squares.end(), [most](double square) { return square <= most; }));
}

/// Nine weights of the derivative at the middle one of nine times, of their polynomial.
std::array<double, 9> DerivativeWeights(std::span<const StateVector> nine) {
  constexpr std::size_t kMiddle = 4;
  std::array<double, 9> weight{};
  const double scale_s = (nine[8].time_s - nine[0].time_s) / 8.0;
  const auto barycentric = [&](std::size_t i) {
    double product = 1.0;
    for (std::size_t j = 0; j < 9; ++j) {
      if (j != i) product *= scale_s / (nine[i].time_s - nine[j].time_s);
    }
    return product;
  };
  const double middle = barycentric(kMiddle);
  for (std::size_t i = 0; i < 9; ++i) {
    if (i == kMiddle) continue;
    weight[i] = barycentric(i) / middle / (nine[kMiddle].time_s - nine[i].time_s);
    weight[kMiddle] -= weight[i];
  }
  return weight;
}

/// The velocity in the middle less the derivative of the polynomial through the positions.
Eigen::Vector3d ContradictionOf(std::span<const StateVector> nine,
                                const std::array<double, 9>& weight) {
  Eigen::Vector3d difference = nine[4].velocity_mps;
  for (std::size_t i = 0; i < nine.size(); ++i) {
    difference -= weight[i] * (nine[i].position_m - nine[4].position_m);
  }
  return difference;
}

}  // namespace

StateNoise EstimateStateNoise(std::span<const StateVector> states) {
  std::vector<double> positions, velocities;
  for (std::size_t order = kLeastDifference; order <= kMostDifference && order + 2 <= states.size();
       ++order) {
    const Squares squares = DifferenceSquares(states, order);
    positions.push_back(squares.position);
    velocities.push_back(squares.velocity);
  }
  return {NoiseOf(positions, states.size()), NoiseOf(velocities, states.size())};
}

double Contradiction_mps(std::span<const StateVector> states, const StateNoise& noise) {
  constexpr std::size_t kNine = 9, kWindows = 16;
  constexpr double kLevel = 1.0 - 1e-6;
  if (states.size() < kNine) return 0.0;
  const std::size_t centres = states.size() - kNine + 1;
  const std::size_t length = (centres + kWindows - 1) / kWindows;
  double square = 0.0, expected = 0.0, whitened = 0.0, windows = 0.0;
  std::vector<double> of_position;
  for (std::size_t begin = 0; begin < centres; begin += length) {
    const std::size_t end = std::min(centres, begin + length);
    const auto count = static_cast<double>(end - begin);
    // Weights of neighbouring centres cancel: a mean knows velocities better than its members do.
    of_position.assign(end - begin + kNine - 1, 0.0);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = begin; k < end; ++k) {
      const std::span<const StateVector> nine = states.subspan(k, kNine);
      const std::array<double, 9> weight = DerivativeWeights(nine);
      for (std::size_t i = 0; i < kNine; ++i) of_position[k - begin + i] += weight[i] / count;
      mean += Across(ContradictionOf(nine, weight), nine[4].velocity_mps) / count;
    }
    double variance = noise.velocity_mps * noise.velocity_mps / count;
    for (const double weight : of_position) {
      variance += std::pow(weight * noise.position_m, 2);
    }
    square += mean.squaredNorm();
    expected += 2.0 * variance;
    whitened += variance > 0.0 ? mean.squaredNorm() / variance : 0.0;
    windows += 1.0;
  }
  const bool noiseless = !(expected > 0.0);
  if (!noiseless && whitened <= ChiSquareQuantile(kLevel, 2.0 * windows)) return 0.0;
  return std::sqrt(std::max(0.0, square - expected) / windows);
}

double LargestContradiction_mps(std::span<const StateVector> states) {
  constexpr std::size_t kNine = 9;
  double largest_mps = 0.0;
  for (std::size_t first = 0; first + kNine <= states.size(); ++first) {
    const std::span<const StateVector> nine = states.subspan(first, kNine);
    largest_mps = std::max(largest_mps, ContradictionOf(nine, DerivativeWeights(nine)).norm());
  }
  return largest_mps;
}

}  // namespace sarblock
