// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/intersection.h"
#include "sarblock/leberl/formulas.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace sarblock::leberl {

/// A vector of the block's frame (any Cartesian axes).
using Triple = std::array<double, 3>;

/// One look of a pair as the reduction needs it.
struct ReducedLook {
  Triple antenna_m{};
  Triple velocity_mps{};
};

/// How far a real pair may be from the paper's: parallel tracks, equal heights, no squint.
inline constexpr double kMaxConvergence_rad = 0.17;  ///< of tracks (10 deg: cosine off by 1.5 %)
inline constexpr double kMaxSquint_rad = 0.17;       ///< of each look, against the mean track
inline constexpr double kMaxHeightRatio = 0.1;       ///< |H' - H''| / mean H

/// Reduces a pair of looks at a point to the paper's B, H, y.
///
/// Along is the mean track (a pass flown the other way is turned), up the local vertical at the
/// point made orthogonal to it, across = up x along. H is the mean height of the antennas above
/// the point's tangent plane, y the point's across distance from antenna ', B that of antenna ''
/// from antenna '. On an ellipsoid the look angles so become incidence angles at the point, which
/// is what its errors depend on. In the paper's frame the reduction returns B, H and y themselves.
///
/// Empty where the paper has no counterpart: tracks that converge, looks that are squinted or
/// heights that differ by more than that, a point above an antenna, a base below 1e-9 H, or
/// a point below an antenna. Antennas on different sides give the opposite-side arrangement.
[[nodiscard]] std::optional<StereoConfiguration> ReducePair(const Triple& point_m,
                                                            const Triple& vertical,
                                                            const ReducedLook& first,
                                                            const ReducedLook& second);

}  // namespace sarblock::leberl

namespace sarblock {

// Rigorous counterparts of Leberl (1979), Eq. 6-8 and 12-25: nothing here uses a closed form of
// the paper, only the range spheres and Doppler planes (Eq. 1-4). They share the paper's types.
//
// What is computed: the true point (0, y, z) gives the true slant ranges and zero Doppler. The
// reconstruction takes antenna positions, velocity directions and ranges with errors added (used
// minus true) and solves |p - s'| = r', |p - s''| = r'', u'.(p - s') = 0, u''.(p - s'') = 0 for p
// by least squares with equal weights, u the unit vector along (1, dydot0, dzdot0). The result is
// reconstructed minus true. Equal weights make dx the mean of the two planes, as Eq. 13 has it.
// 64-bit mantissa throughout. docs/theory/leberl.md, section 2.

/// First order: the derivative of the intersection in the direction of `errors`, by the implicit
/// function theorem, dp = -(J'J)^-1 J'E e. Accuracy: 1e-12 relative for dtheta > 0.1 degree.
/// `terrain_height_m` is the z of the point, below the stations.
[[nodiscard]] leberl::PointError StereoErrorDerivative(const leberl::StereoConfiguration& c,
                                                       const leberl::StereoErrors& errors,
                                                       double terrain_height_m = 0.0);

/// Finite size: the intersection itself. Empty where the perturbed circles have no intersection
/// (they do not meet, or meet on the other side of their common tangent).
[[nodiscard]] std::optional<leberl::PointError> StereoErrorExact(
    const leberl::StereoConfiguration& c,
    const leberl::StereoErrors& errors,
    double terrain_height_m = 0.0);

/// First-order error of a coordinate difference: the derivative of StereoErrorDerivative along
/// (Dy, Dz) at (y, 0), times that difference. Counterpart of Eq. 18, 19, 22-24.
[[nodiscard]] leberl::PointError DifferenceErrorDerivative(const leberl::StereoConfiguration& c,
                                                           const leberl::StereoErrors& errors,
                                                           const leberl::Difference& difference);

/// Error of the difference between the points (y + Dy, Dz) and (y, 0), both finite. Empty where
/// one of them has no intersection.
[[nodiscard]] std::optional<leberl::PointError> DifferenceErrorExact(
    const leberl::StereoConfiguration& c,
    const leberl::StereoErrors& errors,
    const leberl::Difference& difference);

/// Covariance of the two-look intersection (geometry::Intersect) by range noise, paths fixed.
/// Counterpart of Eq. 25. Throws UndeterminedError where the looks do not determine the point.
[[nodiscard]] leberl::RangeNoise StereoRangeNoise(const leberl::StereoConfiguration& c,
                                                  double range_sigma_m);

/// Spherical wave fronts: parallax difference between the points (y, h) and (y, 0), each image's
/// displacement counted towards its antenna, second -/+ first as in Eq. 6 and 7 [m]. Empty where
/// the point is closer to an antenna than the datum (no ground range).
[[nodiscard]] std::optional<double> ExactParallaxFromHeight(const leberl::StereoConfiguration& c,
                                                            double height_m,
                                                            leberl::Presentation presentation);

/// Inverse of ExactParallaxFromHeight by Newton's method; empty where it finds no height.
[[nodiscard]] std::optional<double> ExactHeightFromParallax(const leberl::StereoConfiguration& c,
                                                            double parallax_m,
                                                            leberl::Presentation presentation);

}  // namespace sarblock

namespace sarblock::stereo {

// The four equations of a stereo pair in any scalar type, used by rigorous.cc.

/// A number with its derivative along one direction (forward mode).
struct Dual {
  long double value = 0.0L;
  long double slope = 0.0L;
};
inline Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.slope + b.slope}; }
inline Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.slope - b.slope}; }
inline Dual operator-(Dual a) { return {-a.value, -a.slope}; }
inline Dual operator*(Dual a, Dual b) {
  return {a.value * b.value, a.slope * b.value + a.value * b.slope};
}
inline Dual operator/(Dual a, Dual b) {
  const long double ratio = a.value / b.value;
  return {ratio, (a.slope - ratio * b.slope) / b.value};
}
inline Dual sqrt(Dual a) {
  const long double root = std::sqrt(a.value);
  return {root, a.slope / (2.0L * root)};
}

template <typename T>
using Vector = std::array<T, 3>;

template <typename T>
T Dot(const Vector<T>& a, const Vector<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <typename T>
T Norm(const Vector<T>& a) {
  using std::sqrt;  // a Dual finds its own by argument-dependent lookup
  return sqrt(Dot(a, a));
}

/// Solves the symmetric 3 x 3 normal equations sum(row row') p = sum(row right side) by cofactors.
/// The condition is that of a stereo pair squared; the 64-bit mantissa keeps 12 digits of it.
template <typename T>
Vector<T> LeastSquares(const std::array<Vector<T>, 4>& rows, const std::array<T, 4>& right) {
  std::array<Vector<T>, 3> n{};
  Vector<T> b{};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      b[i] = b[i] + rows[k][i] * right[k];
      for (std::size_t j = 0; j < 3; ++j) n[i][j] = n[i][j] + rows[k][i] * rows[k][j];
    }
  }
  const auto cofactor = [&n](std::size_t i, std::size_t j) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return n[i1][j1] * n[i2][j2] - n[i1][j2] * n[i2][j1];
  };
  const T determinant =
      n[0][0] * cofactor(0, 0) + n[0][1] * cofactor(0, 1) + n[0][2] * cofactor(0, 2);
  Vector<T> p{};
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = (cofactor(i, 0) * b[0] + cofactor(i, 1) * b[1] + cofactor(i, 2) * b[2]) / determinant;
  }
  return p;
}

/// A station as the reconstruction uses it, relative to the true point's along-track coordinate.
template <typename T>
struct Station {
  Vector<T> antenna{};
  Vector<T> axis{};  ///< unit velocity direction
  T range{};
};

/// Errors (left minus measured side) and partials by p of Eq. 1-4: spheres first, then planes.
template <typename T>
struct Equations {
  std::array<T, 4> error{};
  std::array<Vector<T>, 4> row{};
};

template <typename T>
Equations<T> Evaluate(const Vector<T>& p, const std::array<Station<T>, 2>& stations) {
  Equations<T> out;
  for (std::size_t k = 0; k < 2; ++k) {
    const Station<T>& station = stations[k];
    Vector<T> observation{};
    for (std::size_t i = 0; i < 3; ++i) observation[i] = p[i] - station.antenna[i];
    const T rho = Norm(observation);
    out.error[k] = rho - station.range;
    out.error[k + 2] = Dot(station.axis, observation);
    for (std::size_t i = 0; i < 3; ++i) out.row[k][i] = observation[i] / rho;
    out.row[k + 2] = station.axis;
  }
  return out;
}

/// Derivative of Eq. 1-4's errors by the stations' errors, times `errors`, at the true point.
template <typename T>
std::array<T, 4> ErrorDirection(const Equations<T>& at_truth,
                                const std::array<Vector<T>, 2>& observations,
                                const std::array<leberl::StationErrors, 2>& errors) {
  const auto constant = [](double value) { return T{static_cast<long double>(value)}; };
  std::array<T, 4> direction{};
  for (std::size_t k = 0; k < 2; ++k) {
    const leberl::StationErrors& e = errors[k];
    const Vector<T> shift{constant(e.dx0_m), constant(e.dy0_m), constant(e.dz0_m)};
    const Vector<T> turn{constant(0.0), constant(e.dydot0), constant(e.dzdot0)};
    direction[k] = -Dot(at_truth.row[k], shift) - constant(e.dr_m) -
                   constant(e.range_scale) * Norm(observations[k]);
    direction[k + 2] = Dot(turn, observations[k]) - Dot(at_truth.row[k + 2], shift);
  }
  return direction;
}

}  // namespace sarblock::stereo

namespace sarblock {

/// One flight line, two looks at the same point, one squinted forward, one backward: the paper's
/// example (its Fig. 5) of a configuration without valid stereo.
struct SingleFlightPair {
  double height_m = 0.0;           ///< H > 0
  double ground_range_m = 0.0;     ///< y, not 0
  double first_squint_rad = 0.0;   ///< tau', in (-pi/2, pi/2); positive looks forward
  double second_squint_rad = 0.0;  ///< tau'', another one
};

/// What the four equations of the pair determine.
///
/// Why they cannot determine the point: a range sphere about s and a cone of half angle 90 deg -
/// tau about the flight line through s meet in the circle at the distance R sin(tau) ahead of s
/// with radius R cos(tau), in the plane normal to the line. For the same point both looks give the
/// same plane and the same radius: one circle. In the Jacobian: the gradients of both spheres and
/// both cones lie in the plane of the flight line and the point, so its rank is 2.
struct SingleFlightProof {
  int rank = 0;               ///< of the 4 x 3 Jacobian, singular values above 1e-10
  double singular[3] = {};    ///< its singular values, largest first
  double plane_gap_m = 0.0;   ///< distance of the planes of the two circles
  double radius_gap_m = 0.0;  ///< difference of their radii
  IntersectionOutcome outcome = IntersectionOutcome::kNotConverged;  ///< of Intersect
  std::string reason;                                                ///< a sentence for people
};

/// Throws InputError naming the value unless the pair is as described above.
[[nodiscard]] SingleFlightProof ProveSingleFlight(const SingleFlightPair& pair);

/// Where the paper's first-order formulas are valid. The figure is
///     |formula - exact| / |exact|   of the vector (dy, dz),
/// formula: Eq. 14 and 15 of the datum point (y, 0); exact: the finite intersection at (y, z). It
/// depends on ratios only: look angle theta', B/H, error/H and z/H.
/// docs/theory/leberl.md, section 6.
enum class ValiditySource { kAcrossPosition, kUpPosition, kRange };  ///< of station ''
[[nodiscard]] const char* NameOf(ValiditySource source);             ///< dy0'', dz0'', dr''

struct ValidityCase {
  ValiditySource source = ValiditySource::kAcrossPosition;
  leberl::Arrangement arrangement = leberl::Arrangement::kSameSide;
  double look_rad = 0.0;       ///< theta', in (0, pi/2)
  double base_ratio = 0.0;     ///< B/H > 0
  double terrain_ratio = 0.0;  ///< z/H, < 1
};

/// The relative difference for an error of `error_ratio` H. Empty where the arrangement has no
/// such geometry (theta' inside or outside the base) or the perturbed circles do not meet.
[[nodiscard]] std::optional<double> RelativeDifference(const ValidityCase& v, double error_ratio);

/// Smallest error/H at which the relative difference reaches `level` (0.01, 0.05, 0.20), found by
/// steps of 10^(1/8) from 1e-7 to 1 and bisection to 1e-6 of itself. 0 where terrain alone
/// exceeds the level; empty where there is no geometry or the level is not reached. Accuracy
/// 1e-6 relative of the ratio.
[[nodiscard]] std::optional<double> ErrorRatioAtLevel(const ValidityCase& v, double level);

struct ValidityOptions {
  std::vector<double> look_deg = {20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70};
  std::vector<double> base_ratio = {0.05, 0.1, 0.2, 0.4, 0.8};
  std::vector<double> terrain_ratio = {0.0, 0.005, 0.02};
  std::vector<double> error_ratio = {1e-5, 1e-4, 1e-3, 1e-2};
};

/// One row of the map: the relative difference for one size of error.
struct ValidityRow {
  ValidityCase of;
  double error_ratio = 0.0;
  std::optional<double> relative_difference;  ///< [1]
};
/// One point of the lines where the first order is off by 1, 5 and 20 percent.
struct ValidityLine {
  ValidityCase of;
  std::optional<double> error_ratio_1_percent;  ///< error/H where 1 percent is reached
  std::optional<double> error_ratio_5_percent;
  std::optional<double> error_ratio_20_percent;
};
[[nodiscard]] std::vector<ValidityRow> ValidityMap(const ValidityOptions& options);
[[nodiscard]] std::vector<ValidityLine> ValidityLines(const ValidityOptions& options);

}  // namespace sarblock
