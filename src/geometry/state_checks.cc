// SPDX-License-Identifier: Apache-2.0
#include "state_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/text.h"
#include "smooth_path.h"
#include <Eigen/Geometry>

namespace sarblock {

std::optional<CloseStates> FindCloseStates(std::span<const StateVector> states) {
  if (states.size() < 2) return std::nullopt;
  std::vector<double> intervals_s;
  for (std::size_t k = 1; k < states.size(); ++k) {
    intervals_s.push_back(states[k].time_s - states[k - 1].time_s);
  }
  std::vector<double> sorted_s = intervals_s;
  const auto upper = sorted_s.begin() + static_cast<std::ptrdiff_t>(sorted_s.size() * 3 / 4);
  std::nth_element(sorted_s.begin(), upper, sorted_s.end());
  constexpr std::size_t kMinIntervals = 4;
  const double usual_s = sorted_s.size() < kMinIntervals ? 0.0 : *upper;
  constexpr double kPart = 1e-3, kAcceleration_mps2 = 1.0;
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double size_m = states[k - 1].position_m.norm() + states[k].position_m.norm();
    const double rounding_s = std::sqrt(6.0 * kRounding * size_m / kAcceleration_mps2);
    if (intervals_s[k - 1] >= std::max(kPart * usual_s, rounding_s)) continue;
    return CloseStates{k, intervals_s[k - 1], usual_s};
  }
  return std::nullopt;
}

std::string Describe(const CloseStates& close) {
  return Digits(close.apart_s, 3) + " s apart: their difference is rounding and noise, no motion" +
         (close.usual_s > 0.0 ? " (states are usually " + Digits(close.usual_s, 3) + " s apart)"
                              : "") +
         "; remove one of them, or one of two merged orbits";
}

namespace {

constexpr std::size_t kDifferenceOrder = 8, kMinDifferences = 12;

/// Weights of the divided difference of nine times, the sum of their absolute values one; of an
/// alternation of +-1 they make +-1.
std::array<double, kDifferenceOrder + 1> DifferenceWeights(std::span<const StateVector> nine) {
  std::array<double, kDifferenceOrder + 1> weights{};
  const double scale_s = (nine[kDifferenceOrder].time_s - nine[0].time_s) / kDifferenceOrder;
  double sum = 0.0;
  for (std::size_t i = 0; i <= kDifferenceOrder; ++i) {
    weights[i] = 1.0;
    for (std::size_t j = 0; j <= kDifferenceOrder; ++j) {
      if (j != i) weights[i] *= scale_s / (nine[i].time_s - nine[j].time_s);
    }
    sum += std::abs(weights[i]);
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// A sum over the differences: with alternating signs, and of squares.
struct AlternatingSum {
  Eigen::Vector3d alternating = Eigen::Vector3d::Zero();
  double square = 0.0;

  void Add(const Eigen::Vector3d& difference, double sign) {
    alternating += sign * difference;
    square += difference.squaredNorm();
  }
  /// Twice the mean, if it is more than chance and noise make; else 0.
  [[nodiscard]] double Significant(double count, double noise, double least) const {
    constexpr double kPart = 0.8, kNoises = 3.0;
    const double mean = alternating.norm() / count;
    if (!(mean * mean > kPart * square / count)) return 0.0;
    return mean > kNoises * noise && 2.0 * mean > least ? 2.0 * mean : 0.0;
  }
};

}  // namespace

std::optional<Alternation> FindAlternation(std::span<const StateVector> states) {
  if (states.size() < kMinDifferences + kDifferenceOrder) return std::nullopt;
  AlternatingSum positions, velocities;
  const std::size_t count = states.size() - kDifferenceOrder;
  for (std::size_t k = 0; k < count; ++k) {
    const std::span<const StateVector> nine = states.subspan(k, kDifferenceOrder + 1);
    const auto weights = DifferenceWeights(nine);
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i <= kDifferenceOrder; ++i) {
      position += weights[i] * (nine[i].position_m - nine[0].position_m);
      velocity += weights[i] * (nine[i].velocity_mps - nine[0].velocity_mps);
    }
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    positions.Add(position, sign);
    velocities.Add(velocity, sign);
  }
  std::array<std::vector<StateVector>, 2> halves;
  for (std::size_t k = 0; k < states.size(); ++k) halves[k % 2].push_back(states[k]);
  const StateNoise even = EstimateStateNoise(halves[0]), odd = EstimateStateNoise(halves[1]);
  constexpr double kLeast_m = 1e-3, kLeast_mps = 1e-4;
  const Alternation found{
      positions.Significant(
          static_cast<double>(count), std::max(even.position_m, odd.position_m), kLeast_m),
      velocities.Significant(
          static_cast<double>(count), std::max(even.velocity_mps, odd.velocity_mps), kLeast_mps)};
  if (found.position_m == 0.0 && found.velocity_mps == 0.0) return std::nullopt;
  return found;
}

std::string Describe(const Alternation& alternation) {
  std::string off;
  if (alternation.position_m > 0.0) off = Digits(alternation.position_m, 3) + " m";
  if (alternation.velocity_mps > 0.0) {
    off += (off.empty() ? "" : " and ") + Digits(alternation.velocity_mps, 3) + " m/s";
  }
  return "its states alternate between two solutions: every second state is " + off +
         " from the flight of the others; keep the states of one of them";
}

double WrapOf_s(const FlightPath& path, double time_s) {
  for (const double shift_s : {0.0, 86400.0, -86400.0, 604800.0, -604800.0}) {
    const double shifted_s = time_s + shift_s;
    if (shifted_s >= path.start_s() && shifted_s <= path.end_s()) return shift_s;
  }
  return 0.0;
}

namespace {

using Eigen::Vector3d;

/// Mean acceleration from the first to the last state less that of the model, whose axes turn at
/// this rate about z.
Vector3d Unexplained_mps2(std::span<const StateVector> states, double gm, double rate) {
  const Vector3d turning = rate * Vector3d::UnitZ();
  const auto model_mps2 = [&](const StateVector& state) -> Vector3d {
    const Vector3d& p_m = state.position_m;
    return -gm / std::pow(p_m.norm(), 3) * p_m - 2.0 * turning.cross(state.velocity_mps) -
           turning.cross(turning.cross(p_m));
  };
  Vector3d change_mps = states.back().velocity_mps - states.front().velocity_mps;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double interval_s = states[k].time_s - states[k - 1].time_s;
    change_mps -= 0.5 * interval_s * (model_mps2(states[k - 1]) + model_mps2(states[k]));
  }
  return change_mps / (states.back().time_s - states.front().time_s);
}

}  // namespace

std::optional<InertialMotion> FindInertialMotion(std::span<const StateVector> states,
                                                 const Body& body) {
  constexpr double kDecides = 0.1;
  if (states.size() < 3 || body.rotation == 0.0) return std::nullopt;
  InertialMotion worst{0.0, std::numeric_limits<double>::infinity()};
  const std::size_t half = states.size() / 2;
  for (const auto part : {states.first(half + 1), states.subspan(half)}) {
    worst.in_fixed_axes_mps2 =
        std::max(worst.in_fixed_axes_mps2, Unexplained_mps2(part, body.gm, 0.0).norm());
    worst.in_turning_axes_mps2 =
        std::min(worst.in_turning_axes_mps2, Unexplained_mps2(part, body.gm, body.rotation).norm());
  }
  if (!(worst.in_fixed_axes_mps2 < kDecides * worst.in_turning_axes_mps2)) return std::nullopt;
  return worst;
}

std::string Describe(const InertialMotion& motion) {
  return "its states move as in axes that do not turn with the body: gravity leaves " +
         Digits(motion.in_fixed_axes_mps2, 2) +
         " m/s^2 of their acceleration unexplained there, and " +
         Digits(motion.in_turning_axes_mps2, 2) + " m/s^2 in axes that turn with it";
}

}  // namespace sarblock
