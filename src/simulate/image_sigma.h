// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/simulate/scene.h"

#include <Eigen/Core>

namespace sarblock {

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

/// Of a place in an image that is matched with another image of the same kind
/// (docs/theory/measurement.md). Slopes that fold over or lie in shadow count as at the edge of
/// both, one degree of local incidence from 0 and from 90 degrees.
[[nodiscard]] ImageSigma SigmaOfMatch(const SceneImage& image,
                                      const ImageView& view,
                                      const ImageView& other);

/// What the passes of a scene carry for looks that give no standard deviations: of a scene's images
/// those of level ground at snr_incidence_rad, matched with an image that sees it alike.
[[nodiscard]] LookSigma SigmaOfPass(const SceneLooks& looks);

}  // namespace sarblock
