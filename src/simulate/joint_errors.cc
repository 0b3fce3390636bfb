// SPDX-License-Identifier: Apache-2.0
#include "joint_errors.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>

#include "joint_names.h"
#include "streams.h"

namespace sarblock {
namespace {

bool Covers(const JointPrior& prior, const std::string& pass) {
  return prior.passes.empty() ||
         std::find(prior.passes.begin(), prior.passes.end(), pass) != prior.passes.end();
}

void AddDrawn(const JointPrior& prior,
              const Frame& frame,
              const Pass& pass,
              const Eigen::VectorXd& drawn,
              PassError* error) {
  const std::array<std::array<double, 3>*, 3> track = {
      &error->constant_m, &error->drift_m, &error->curvature_m};
  const std::array<double*, 4> biases = {
      &error->range_bias_m, &error->range_scale_1, &error->time_bias_s, &error->squint_bias_rad};
  for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
    const double value = drawn[static_cast<Eigen::Index>(i)];
    const auto parameter = ParseDrawn(prior, prior.parameters[i]);
    if (!parameter) continue;
    if (!parameter->position) {
      *biases[static_cast<std::size_t>(parameter->bias)] += value;
      continue;
    }
    const auto degree = static_cast<std::size_t>(parameter->position->degree);
    const int axis = parameter->position->axis;
    if (parameter->axes == JointPrior::Axes::kTrack) {
      (*track[degree])[static_cast<std::size_t>(axis)] += value;
    } else {
      const Eigen::Matrix3d axes =
          FrameFromAxes(frame, pass, parameter->axes, "navigation." + KeyOf(prior) + ".axes");
      error->frame_m[degree] += axes.col(axis) * value;
    }
  }
}

}  // namespace

void AddJointErrors(const std::vector<JointPrior>& joint,
                    const Frame& frame,
                    const Pass& pass,
                    std::size_t pass_index,
                    std::uint64_t seed,
                    PassError* error) {
  RandomStream random(seed, MixStream(kJointStream, pass_index));
  for (const JointPrior& prior : joint) {
    JointPriorTerm term;
    term.name = prior.name;
    term.Set(prior.Covariance());
    Eigen::VectorXd normal(term.factor.rows());
    for (double& value : normal) value = random.Normal();
    if (Covers(prior, pass.id)) AddDrawn(prior, frame, pass, term.factor * normal, error);
  }
}

}  // namespace sarblock
