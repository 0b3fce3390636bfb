// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <variant>

#include "model/priors.h"
#include "study/densification.h"

namespace sarblock {
namespace {

[[noreturn]] void Refuse(const CorrectionGroup& group, const std::string& why) {
  throw InputError("verify.navigation",
                   "'priors' cannot draw the corrections '" + group.name + "' (" + why +
                       "); 'scene' draws the scene's [navigation]");
}

/// Prior, or what the scene has where there is none.
double Or(double prior, double scene) { return std::isnan(prior) ? scene : prior; }

void Take(const CorrectionGroup& group,
          const PositionCorrection& position,
          const SceneNavigation& scene,
          SceneNavigation* drawn) {
  if (position.basis != PositionCorrection::Basis::kPolynomial) Refuse(group, "splines");
  if (position.axes != PositionCorrection::Axes::kTrack) Refuse(group, "frame axes");
  if (position.degree > 2) Refuse(group, "a degree above 2");
  if (group.shared) Refuse(group, "shared by passes");
  const std::array<std::array<double, 3> SceneNavigation::*, 3> members = {
      &SceneNavigation::constant_sigma_m,
      &SceneNavigation::drift_sigma_m,
      &SceneNavigation::curvature_sigma_m};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!position.components[axis]) continue;
    const std::vector<double>& prior = position.prior_sigma_m[axis];
    for (std::size_t degree = 0; degree <= static_cast<std::size_t>(position.degree); ++degree) {
      const double sigma_m = prior.empty()       ? kNotGiven
                             : prior.size() == 1 ? prior[0]
                                                 : prior[degree];
      (drawn->*members[degree])[axis] = Or(sigma_m, (scene.*members[degree])[axis]);
    }
  }
}

/// Which of the corrections that are not shared have joint priors, in the order of the groups.
std::set<int> JointParameters(const AdjustOptions& options) {
  const JointPriorBindings bindings = BindJointPriors({"pass"}, options.groups, options.priors);
  for (const JointPrior& prior : options.priors) {
    if (prior.passes.empty()) continue;
    throw InputError("verify.navigation",
                     "'priors' cannot draw " + KeyOf(prior) +
                         " (single passes); 'scene' draws the scene's [navigation]");
  }
  if (bindings.problem) throw InputError("adjust.prior", bindings.problem->problem);
  std::set<int> joint;
  for (const JointPriorBinding& binding : bindings.bound) {
    joint.insert(binding.parameters.begin(), binding.parameters.end());
  }
  return joint;
}

}  // namespace

SceneNavigation NavigationFromPriors(const AdjustOptions& options, const SceneNavigation& scene) {
  SceneNavigation drawn;
  drawn.shared_biases = scene.shared_biases;
  if (options.corrections != CorrectionChoice::kGiven) return drawn;
  drawn.joint = options.priors;
  const std::set<int> joint = JointParameters(options);
  int next = 0;  // parameter that is not shared
  for (const CorrectionGroup& group : options.groups) {
    if (!group.passes.empty()) Refuse(group, "single passes");
    if (!group.shared) {
      const auto parameters = static_cast<int>(ParametersOf(group).size());
      const auto of_joint =
          std::distance(joint.lower_bound(next), joint.lower_bound(next + parameters));
      next += parameters;
      if (of_joint > 0 && of_joint == parameters) continue;
      if (of_joint > 0) Refuse(group, "a joint prior for a part of its parameters");
    }
    if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
      Take(group, *position, scene, &drawn);
      continue;
    }
    if (group.shared != scene.shared_biases) {
      Refuse(group, "shared where navigation.shared_biases is not, or the other way round");
    }
    if (const auto* range = std::get_if<RangeCorrection>(&group.model)) {
      if (range->bias) {
        drawn.range_bias_sigma_m = Or(range->bias_prior_sigma_m, scene.range_bias_sigma_m);
      }
      if (range->scale) {
        drawn.range_scale_sigma_1 = Or(range->scale_prior_sigma, scene.range_scale_sigma_1);
      }
    } else if (const auto* time = std::get_if<TimeCorrection>(&group.model)) {
      drawn.time_bias_sigma_s = Or(time->bias_prior_sigma_s, scene.time_bias_sigma_s);
    } else if (const auto* squint = std::get_if<SquintCorrection>(&group.model)) {
      drawn.squint_bias_sigma_rad = Or(squint->bias_prior_sigma_rad, scene.squint_bias_sigma_rad);
    } else {
      Refuse(group, "velocity or troposphere");
    }
  }
  return drawn;
}

}  // namespace sarblock
