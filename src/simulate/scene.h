// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/priors.h"
#include <Eigen/Core>

namespace sarblock {

/// The biases that joint errors may name, in the order of DrawnParameter::bias.
enum class DrawnBias { kRange, kScale, kTime, kSquint };

/// What a parameter of SceneNavigation::joint is: a coefficient of the position or a bias.
struct DrawnParameter {
  std::optional<PositionName> position;
  JointPrior::Axes axes = JointPrior::Axes::kTrack;  ///< of the position
  DrawnBias bias = DrawnBias::kRange;
};
/// Nothing for a parameter that is not simulated.
[[nodiscard]] std::optional<DrawnParameter> ParseDrawn(const JointPrior& prior,
                                                       const std::string& name);

/// What is wrong with joint errors; the key counts from the scene ("navigation.prior.NAME.sigma").
struct JointErrorProblem {
  std::string key, problem;
};
[[nodiscard]] std::optional<JointErrorProblem> FindJointProblem(
    const std::vector<JointPrior>& joint, const std::vector<std::string>& passes);

/// The key and problem of an image that no scene can have, the key counting from its table.
[[nodiscard]] std::optional<SceneProblem> FindImageProblem(const SceneImage& image);

/// Standard deviations of the joint errors, summed over priors and axes.
struct JointSigmas {
  double shift_m = 0.0;      ///< of the position
  double end_slope_m = 0.0;  ///< its slope by strip-normalised time at the ends of the strip
  double time_bias_s = 0.0;
  double squint_bias_rad = 0.0;
};
[[nodiscard]] JointSigmas SumJointSigmas(const std::vector<JointPrior>& joint);

/// First argument of MixStream for each kind of random thing of a scene; the second is its index.
/// The numbers are part of the reproducibility of a seed: never renumber.
enum StreamKind : std::uint64_t {
  kTerrainStream = 1,
  kTieStream = 2,
  kControlPlaceStream = 3,
  kCheckPlaceStream = 4,
  kPassStream = 5,
  kBiasStream = 6,
  kLookStream = 7,
  kKnownStream = 8,
  kTrajectoryErrorStream = 9,
  kRecorderStream = 10,
  kJointStream = 11,
};

/// How an image shows a place.
struct ImageView {
  double local_incidence_rad = 0.0;  ///< between the line of sight and the normal of the ground
  /// Displacement on the ground per metre of height [e, n]: cot(incidence) away from the antenna.
  Eigen::Vector2d parallax = Eigen::Vector2d::Zero();
};

/// How an antenna sees a point whose ground has the normal `normal` (frame axes, any length).
[[nodiscard]] ImageView ViewOf(const Frame& frame,
                               const Eigen::Vector3d& point_m,
                               const Eigen::Vector3d& normal,
                               const Eigen::Vector3d& antenna_m);

/// Standard deviations of what is measured in an image [m], azimuth along track at the target.
struct ImageSigma {
  double range_m = 0.0;
  double azimuth_m = 0.0;
};

/// Standard deviations at a place in an image that is matched with another image of the same kind
/// (docs/theory/measurement.md). Slopes that fold over or lie in shadow count as at the edge of
/// both, one degree of local incidence from 0 and from 90 degrees.
[[nodiscard]] ImageSigma SigmaOfMatch(const SceneImage& image,
                                      const ImageView& view,
                                      const ImageView& other);

/// Standard deviations of the passes of a scene, for looks that give none: if the scene has images,
/// those for level ground at snr_incidence_rad, matched with an image that sees it alike.
[[nodiscard]] LookSigma SigmaOfPass(const SceneLooks& looks);

}  // namespace sarblock
