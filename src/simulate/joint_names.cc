// SPDX-License-Identifier: Apache-2.0
#include "joint_names.h"

#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sarblock {
namespace {

constexpr int kMostDrawnDegree = 2;
constexpr std::array<const char*, 4> kDrawnBiases = {
    "range.bias", "range.scale", "time.bias", "squint.bias"};

}  // namespace

std::optional<DrawnParameter> ParseDrawn(const JointPrior& prior, const std::string& name) {
  const auto* const bias = std::find(kDrawnBiases.begin(), kDrawnBiases.end(), name);
  if (bias != kDrawnBiases.end()) {
    return DrawnParameter{{}, {}, static_cast<DrawnBias>(bias - kDrawnBiases.begin())};
  }
  std::vector<JointPrior::Axes> tried{prior.axes};
  if (prior.axes == JointPrior::Axes::kCorrection) {
    tried = {JointPrior::Axes::kTrack, JointPrior::Axes::kFrame};
  }
  for (const JointPrior::Axes axes : tried) {
    const auto position = ParsePositionName(name, axes);
    if (position && position->degree <= kMostDrawnDegree) return DrawnParameter{position, axes, {}};
  }
  return std::nullopt;
}

std::optional<JointErrorProblem> FindJointProblem(const std::vector<JointPrior>& joint,
                                                  const std::vector<std::string>& passes) {
  for (const JointPrior& prior : joint) {
    const std::string key = "navigation." + KeyOf(prior);
    if (const auto problem = FindOwnProblem(prior)) {
      return JointErrorProblem{key + "." + problem->field, problem->problem};
    }
    for (const std::string& pass : prior.passes) {
      if (std::find(passes.begin(), passes.end(), pass) != passes.end()) continue;
      return JointErrorProblem{
          key + ".passes",
          "no pass '" + pass + "' in the scene" + DidYouMean(NearestName(pass, passes))};
    }
    for (const std::string& name : prior.parameters) {
      if (ParseDrawn(prior, name)) continue;
      return JointErrorProblem{
          key + ".parameters",
          "'" + name +
              "' cannot be drawn, position parameters of degree 0 to 2 in the axes given, "
              "range.bias, range.scale, time.bias and squint.bias can"};
    }
  }
  return std::nullopt;
}

JointSigmas SumJointSigmas(const std::vector<JointPrior>& joint) {
  constexpr std::array<double, 3> kEndSlopes = {0.0, 1.0, 3.0};  // of Legendre polynomials
  JointSigmas out;
  for (const JointPrior& prior : joint) {
    const Eigen::VectorXd sigma = prior.Covariance().diagonal().cwiseSqrt();
    for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
      const double own = sigma[static_cast<Eigen::Index>(i)];
      const auto drawn = ParseDrawn(prior, prior.parameters[i]);
      if (!drawn) continue;
      if (drawn->position) {
        out.shift_m += own;
        out.end_slope_m += own * kEndSlopes[static_cast<std::size_t>(drawn->position->degree)];
      } else if (drawn->bias == DrawnBias::kTime) {
        out.time_bias_s += own;
      } else if (drawn->bias == DrawnBias::kSquint) {
        out.squint_bias_rad += own;
      }
    }
  }
  return out;
}

}  // namespace sarblock
