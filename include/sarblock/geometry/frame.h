// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// An ellipsoid of revolution: equatorial radius and flattening f = (a - b)/a.
struct Ellipsoid {
  std::string name;
  double a_m = 0.0;
  double flattening = 0.0;
};

/// WGS84, GRS80, Moon (1737.4 km), Venus (6051.8 km), Mars (IAU 2000: 3396.19 km, 1/169.894447...).
/// Names are matched without regard to case; throws InputError naming the nearest known one.
[[nodiscard]] Ellipsoid NamedEllipsoid(const std::string& name);
[[nodiscard]] const std::vector<std::string>& EllipsoidNames();

/// Throws InputError unless a is finite and positive and 0 <= f < 1 (oblate or sphere).
void Validate(const Ellipsoid& ellipsoid);

/// How a body attracts and turns.
struct Body {
  std::string_view name;  ///< of its ellipsoid
  double gm = 0.0;        ///< gravity parameter [m3/s2]
  double rotation = 0.0;  ///< sidereal [rad/s], positive eastwards
};

/// The body of a named ellipsoid; null for an ellipsoid given by numbers. Moon: IAU/GRAIL GM;
/// Venus: IAU 2015 rotation, retrograde; Mars: IAU 2015.
[[nodiscard]] const Body* FindBody(const std::string& ellipsoid);

enum class FrameKind { kLocal, kGeocentric };

/// Geodetic coordinates on the frame's ellipsoid.
struct Geodetic {
  double lat_rad = 0.0;
  double lon_rad = 0.0;
  double h_m = 0.0;
};

/// The outward vertical at a point, with what the model needs of its neighbourhood.
struct Vertical {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();     ///< unit vector, frame axes
  double height_m = 0.0;                             ///< above the ellipsoid; `local`: z
  Eigen::Matrix3d dup_dp = Eigen::Matrix3d::Zero();  ///< d up / d position [1/m], symmetric
};

/// The vertical along a moving point, with its first two time derivatives.
struct VerticalMotion {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
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

  /// VerticalAt(p).up to 1e-8, in a tenth of the time: by Bowring (1985), Survey Review 28(218),
  /// where the body is not very flat and p not far below its surface. For decisions, not for
  /// coordinates.
  [[nodiscard]] Eigen::Vector3d UpAt(const Eigen::Vector3d& p_m) const;

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
