// SPDX-License-Identifier: Apache-2.0
#include "gauss_markov.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "streams.h"
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace sarblock {
namespace {

/// Nodes in a time constant.
constexpr double kNodes = 64.0;

/// Steps of the process of unit rms and time constant, state (value, first, second derivative).
class UnitProcess {
 public:
  UnitProcess() {
    stationary_ << 1.0, 0.0, -1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, -1.0 / 3.0, 0.0, 1.0;
    constexpr double kStep = 1.0 / kNodes;
    Eigen::Matrix3d nilpotent;
    nilpotent << 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, -1.0, -3.0, -2.0;
    transition_ = std::exp(-kStep) * (Eigen::Matrix3d::Identity() + kStep * nilpotent +
                                      0.5 * kStep * kStep * nilpotent * nilpotent);
    step_factor_ = FactorOf(stationary_ - transition_ * stationary_ * transition_.transpose());
    stationary_factor_ = FactorOf(stationary_);
  }
  [[nodiscard]] Eigen::Vector3d First(RandomStream* random) const {
    return stationary_factor_ * Normals(random);
  }
  [[nodiscard]] Eigen::Vector3d Next(const Eigen::Vector3d& state, RandomStream* random) const {
    return transition_ * state + step_factor_ * Normals(random);
  }

 private:
  [[nodiscard]] static Eigen::Vector3d Normals(RandomStream* random) {
    Eigen::Vector3d normals;
    for (int i = 0; i < 3; ++i) normals[i] = random->Normal();
    return normals;
  }
  /// Taken from the acceleration down: the variances of a step fall by its square each.
  [[nodiscard]] static Eigen::Matrix3d FactorOf(const Eigen::Matrix3d& covariance) {
    const Eigen::LLT<Eigen::Matrix3d> factor(covariance.reverse());
    return Eigen::Matrix3d(factor.matrixL()).reverse();
  }
  Eigen::Matrix3d stationary_, transition_, step_factor_, stationary_factor_;
};

}  // namespace

SmoothCurve DrawGaussMarkov(double rms,
                            double time_constant_s,
                            double start_s,
                            double from_s,
                            double to_s,
                            std::uint64_t seed,
                            std::uint64_t stream) {
  static const UnitProcess process;
  const double step_s = time_constant_s / kNodes;
  const Eigen::Vector3d unit(rms, rms / time_constant_s, rms / (time_constant_s * time_constant_s));
  RandomStream after(seed, MixStream(stream, 0));
  const Eigen::Vector3d middle = process.First(&after);
  // Backwards in time the process is itself with the other sign of the first derivative.
  const Eigen::Vector3d turned(1.0, -1.0, 1.0);
  std::vector<SmoothCurve::Node> nodes;
  const auto append = [&](double time_s, const Eigen::Vector3d& state) {
    const Eigen::Vector3d value = unit.cwiseProduct(state);
    nodes.push_back({time_s, value[0], value[1], value[2]});
  };
  RandomStream before(seed, MixStream(stream, 1));
  Eigen::Vector3d state = turned.cwiseProduct(middle);
  for (double k = 1.0; start_s - (k - 1.0) * step_s > from_s; k += 1.0) {
    state = process.Next(state, &before);
    append(start_s - k * step_s, turned.cwiseProduct(state));
  }
  std::reverse(nodes.begin(), nodes.end());
  append(start_s, middle);
  state = middle;
  for (double k = 1.0; start_s + (k - 1.0) * step_s < to_s; k += 1.0) {
    state = process.Next(state, &after);
    append(start_s + k * step_s, state);
  }
  return SmoothCurve(std::move(nodes));
}

}  // namespace sarblock
