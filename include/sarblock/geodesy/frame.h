// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geodesy/ellipsoid.h"

#include <Eigen/Core>

namespace sarblock {

enum class FrameKind { kLocal, kGeocentric };

/// Geodetic coordinates on the frame's ellipsoid.
struct Geodetic {
  double lat_rad = 0.0;
  double lon_rad = 0.0;
  double h_m = 0.0;
};

/// The outward vertical at a point, with what the model needs of its neighbourhood.
struct Vertical {
  Eigen::Vector3d up_1 = Eigen::Vector3d::UnitZ();   ///< unit vector, frame axes
  double height_m = 0.0;                             ///< above the ellipsoid; `local`: z
  Eigen::Matrix3d dup_dp = Eigen::Matrix3d::Zero();  ///< d up / d position [1/m], symmetric
};

/// The vertical along a moving point, with its first two time derivatives.
struct VerticalMotion {
  Eigen::Vector3d up_1 = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();          ///< d up / dt [1/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< d2 up / dt2 [1/s2]
};

/// The coordinate frame of a block (model.md, section 2; docs/theory/conventions.md).
/// `local`: flat Cartesian, z up. `geocentric`: body-fixed Cartesian of an ellipsoid.
class Frame {
 public:
  [[nodiscard]] static Frame Local();
  [[nodiscard]] static Frame Geocentric(const Ellipsoid& ellipsoid);

  [[nodiscard]] FrameKind kind() const { return kind_; }
  /// Meaningful for geocentric frames only.
  [[nodiscard]] const Ellipsoid& ellipsoid() const { return ellipsoid_; }

  /// Rows east, north, up at p (`local`: the identity). At a pole east is that of longitude
  /// atan2(y, x), with atan2(0, 0) = 0.
  [[nodiscard]] Eigen::Matrix3d EnuFromFrame(const Eigen::Vector3d& p_m) const;

  /// The vertical at p. Geocentric: p must not lie below the evolute (|p| > a/10 is enough for
  /// every named body).
  [[nodiscard]] Vertical VerticalAt(const Eigen::Vector3d& p_m) const;

  /// The vertical along a path through p with velocity and acceleration, exact for the ellipsoid.
  [[nodiscard]] VerticalMotion VerticalAlong(const Eigen::Vector3d& p_m,
                                             const Eigen::Vector3d& velocity_mps,
                                             const Eigen::Vector3d& acceleration_mps2) const;

  /// Geodetic coordinates and back (Karney, GeographicLib: 5 nm for the Earth within 5000 km).
  /// Geocentric frames only (throws InputError for `local`).
  [[nodiscard]] Geodetic GeodeticFromFrame(const Eigen::Vector3d& p_m) const;
  [[nodiscard]] Eigen::Vector3d FrameFromGeodetic(const Geodetic& geodetic) const;

  /// Position with the same horizontal place as p and the given height (`local`: z).
  [[nodiscard]] Eigen::Vector3d AtHeight(const Eigen::Vector3d& p_m, double height_m) const;

 private:
  FrameKind kind_ = FrameKind::kLocal;
  Ellipsoid ellipsoid_;
};

}  // namespace sarblock
