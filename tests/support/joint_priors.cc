// SPDX-License-Identifier: Apache-2.0
#include "support/joint_priors.h"

#include "sarblock/core/statistics.h"

#include <string>

#include <gtest/gtest.h>

namespace sarblock::test {

Eigen::MatrixXd StrongCovariance(const Eigen::VectorXd& sigma, std::uint64_t seed) {
  RandomStream random(seed, 7411);
  Eigen::MatrixXd g(sigma.size(), 2);
  for (double& value : g.reshaped()) value = random.Normal();
  const Eigen::MatrixXd full =
      g * g.transpose() + 0.05 * Eigen::MatrixXd::Identity(sigma.size(), sigma.size());
  const Eigen::VectorXd scale = sigma.cwiseQuotient(full.diagonal().cwiseSqrt());
  return scale.asDiagonal() * full * scale.asDiagonal();
}

AdjustOptions WithJointPrior(PositionCorrection::Axes axes, std::uint64_t seed) {
  PositionCorrection position;
  position.degree = 1;
  position.axes = axes;
  RangeCorrection range;
  range.bias = true;
  JointPrior prior;
  prior.name = "path";
  const bool track = axes == PositionCorrection::Axes::kTrack;
  for (const char* degree : {".0", ".1"}) {
    for (const char* axis : {track ? "along" : "x", track ? "across" : "y", track ? "up" : "z"}) {
      prior.parameters.push_back(std::string("position.") + axis + degree);
    }
  }
  prior.parameters.emplace_back("range.bias");
  Eigen::VectorXd sigma(7);
  sigma << 2.3, 1.9, 2.7, 1.3, 1.7, 1.1, 0.9;
  prior.covariance = StrongCovariance(sigma, seed);
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}, {"range", range, {}, false}};
  options.priors = {prior};
  return options;
}

KnownBlock NoisyBlockWithControl(const BlockPlan& plan) {
  KnownBlock known = MakeBlock(plan);
  AddKnownPoint(0, {0.31, 0.47, 0.83}, &known);
  AddKnownPoint(5, {0.53, 0.29, kNotGiven}, &known);
  AddNoise(67, 1.0, &known);
  return known;
}

void ExpectSameCorrections(const AdjustResult& a, const AdjustResult& b) {
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    const ParameterResult &one = a.parameters[i], &other = b.parameters[i];
    EXPECT_NEAR(one.value, other.value, 1e-7 * other.sigma) << other.name;
    EXPECT_NEAR(one.sigma, other.sigma, 1e-7 * other.sigma) << other.name;
  }
}

}  // namespace sarblock::test
