// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock::leberl {

// F. Leberl, "Accuracy Analysis of Stereo Side-Looking Radar" (1979), cited here as Leberl (1979).
//
// Frame of the paper: x along track, y across, z up, z = 0 the datum. Station ' (first) is at
// (x, 0, H), station '' (second) at (x, B, H), both fly along +x, the point is (x, y, 0). Every
// closed form of this module is for a point of the datum; for a point at height z put H - z.
// docs/theory/leberl.md derives what the paper leaves out.

/// Same-side: both stations are on one side of the point. Opposite-side: it lies between them.
enum class Arrangement { kSameSide, kOppositeSide };

/// Stereo base B, flying height H and ground range y of the point from the nadir line of station '.
struct StereoConfiguration {
  double base_m = 0.0;          ///< B; not 0, negative if station '' is at smaller y
  double height_m = 0.0;        ///< H > 0
  double ground_range_m = 0.0;  ///< y; not 0 and not B (nadir of a station)
  Arrangement arrangement = Arrangement::kSameSide;
};

/// Throws InputError naming the value unless the configuration is finite, B != 0, H > 0, and
/// y (y - B) > 0 for same-side, y (y - B) < 0 for opposite-side.
void Validate(const StereoConfiguration& configuration);

/// Signed look angles off nadir: tan(theta') = y/H, tan(theta'') = (y - B)/H. Both have the same
/// sign for same-side, different signs for opposite-side. In (-pi/2, pi/2).
[[nodiscard]] double FirstLookAngle(const StereoConfiguration& c);   // [rad]
[[nodiscard]] double SecondLookAngle(const StereoConfiguration& c);  // [rad]

/// Intersection angle dtheta = |theta' - theta''| [rad], in (0, pi).
[[nodiscard]] double IntersectionAngle(const StereoConfiguration& c);

/// Slant ranges at z = 0: r'^2 = H^2 + y^2, r''^2 = H^2 + (y - B)^2 [m].
[[nodiscard]] double FirstSlantRange(const StereoConfiguration& c);
[[nodiscard]] double SecondSlantRange(const StereoConfiguration& c);

/// The viewing guidance the paper quotes, as a check of one configuration: best viewing with look
/// angles of 37 to 67 degrees and dtheta of about 12 to 15 degrees; in the conclusion look angles
/// not below 40 degrees. Magnitudes of the look angles are compared.
struct ViewingGuidance {
  double first_look_rad = 0.0;    ///< |theta'|
  double second_look_rad = 0.0;   ///< |theta''|
  double intersection_rad = 0.0;  ///< dtheta
  bool looks_within_37_and_67_deg = false;
  bool looks_not_below_40_deg = false;
  bool intersection_within_12_and_15_deg = false;
};
[[nodiscard]] ViewingGuidance CheckViewing(const StereoConfiguration& c);
/// The same from the magnitudes of both look angles, in (0, pi/2).
[[nodiscard]] ViewingGuidance CheckViewing(double first_look_rad,
                                           double second_look_rad,
                                           Arrangement arrangement);

/// Four of the printed equations (13, 19, 22, 24) carry terms whose sign does not follow from the
/// geometry (docs/theory/leberl.md). Both versions are kept: the first to compare with the paper's
/// numbers, the second to predict.
enum class Signs {
  kPrinted,  ///< as the paper prints them
  kDerived,  ///< as the derivation from Eq. 1-4 gives them
};

/// How the image shows range: projected on the datum, or as measured.
enum class Presentation { kGroundRange, kSlantRange };

/// Displacement of a point of height h in one image, wave fronts replaced by planes:
/// ground range p = h cot(theta), slant range p = h cos(theta). Leberl (1979), Eq. 6 and 7.
/// `look_rad` is the magnitude of the look angle, in (0, pi/2). Positive towards the antenna. [m]
[[nodiscard]] double HeightDisplacement(double look_rad,
                                        double height_m,
                                        Presentation presentation);

/// Parallax difference dp of two points that differ in height by h: [m]
///     ground range: dp = h (cot(theta'') -/+ cot(theta')),
///     slant range:  dp = h (cos(theta'') -/+ cos(theta')),
/// minus for same-side, plus for opposite-side. Leberl (1979), Eq. 6 and 7.
[[nodiscard]] double ParallaxFromHeight(const StereoConfiguration& c,
                                        double height_m,
                                        Presentation presentation);

/// Inverse of ParallaxFromHeight: h = dp / (cot(theta'') -/+ cot(theta')), and with cosines for
/// slant range. [m] Leberl (1979), Eq. 6 and 7.
[[nodiscard]] double HeightFromParallax(const StereoConfiguration& c,
                                        double parallax_m,
                                        Presentation presentation);

/// Absolute parallax of a point of the datum [m]. Slant range: a = r' - r'', Leberl (1979), Eq. 8,
/// with the plus sign under the second root; points of equal height have different a, so that a
/// flat surface appears as a hyperbola-like cylinder. Ground range: a = y - (y - B) = B everywhere,
/// so that the datum appears as a plane.
[[nodiscard]] double AbsoluteParallax(const StereoConfiguration& c, Presentation presentation);

/// Vertical exaggeration q of a stereo model, three forms. Dimensionless magnitudes.
/// The factor 5, "about" in the paper, is the distance of the viewed images over the eye base.
inline constexpr double kViewingRatio = 5.0;
/// Camera: q ~ 5 Bc/H. Leberl (1979), Eq. 9. base_m >= 0, height_m > 0.
[[nodiscard]] double CameraExaggeration(double base_m, double height_m);
/// Equivalent base of a radar pair: the base Bc = q H/5 with which a camera at the height H has the
/// exaggeration q [m]. Leberl (1979), Eq. 9.
[[nodiscard]] double EquivalentBase(double exaggeration, double height_m);
/// Radar: q ~ 5 |cot(theta') -/+ cot(theta'')|, minus same-side, plus opposite-side; look angles
/// are magnitudes in (0, pi/2). Leberl (1979), Eq. 10.
[[nodiscard]] double ExaggerationFromAngles(double first_look_rad,
                                            double second_look_rad,
                                            Arrangement arrangement);
/// Radar: q ~ 5 H B / (y (y - B)), magnitude. Leberl (1979), Eq. 11.
[[nodiscard]] double Exaggeration(const StereoConfiguration& c);

/// Beyond this retinal disparity the eyes would have to turn outwards.
inline constexpr double kMaxFusion_rad = 0.2;

/// How a person views a pair. The images lie at kViewingRatio eye bases from the eyes.
struct StereoViewing {
  double scale = 0.0;       ///< M of images viewed at the scale 1:M; > 0
  double eye_base_m = 0.0;  ///< > 0
  double acuity_rad = 0.0;  ///< least retinal disparity that is seen as depth; > 0
  /// Largest retinal disparity that fuses to one picture; < kMaxFusion_rad.
  double fusion_rad = 0.0;
};
/// Throws InputError naming the value unless all are finite and positive, the disparities in order
/// and the larger below the convergence of the eyes.
void Validate(const StereoViewing& viewing);

/// Retinal disparity [rad] of two points that differ in height by h in a model of exaggeration q:
/// the difference of the angles at which both eyes meet at them. The higher point appears q h/M
/// nearer to the eyes; it must not reach them. Leberl (1979), Fig. 2; docs/theory/leberl.md.
[[nodiscard]] double RetinalDisparity(double exaggeration,
                                      double height_m,
                                      const StereoViewing& viewing);
/// Inverse: the height difference of a retinal disparity [m].
[[nodiscard]] double HeightOfDisparity(double exaggeration,
                                       double disparity_rad,
                                       const StereoViewing& viewing);

/// What is wrong with one station: value used in the reconstruction minus true value.
struct StationErrors {
  double dx0_m = 0.0;        ///< antenna position along track
  double dy0_m = 0.0;        ///< antenna position across track
  double dz0_m = 0.0;        ///< antenna position up
  double dr_m = 0.0;         ///< slant range
  double dydot0 = 0.0;       ///< velocity direction, across component of a unit along vector
  double dzdot0 = 0.0;       ///< velocity direction, up component
  double range_scale = 0.0;  ///< relative error of the slant range: adds range_scale r to dr
};

/// Errors of both stations; `first` is ', `second` is ''.
struct StereoErrors {
  StationErrors first = {};
  StationErrors second = {};
};

/// Error of a reconstructed point (reconstructed minus true), frame of the paper.
struct PointError {
  double dx_m = 0.0;
  double dy_m = 0.0;
  double dz_m = 0.0;
};

/// Across-track error by dy0'' alone, dy = dy0'' (B - y)/B [m]. Leberl (1979), Eq. 12.
[[nodiscard]] double AcrossErrorOfSecondAcross(const StereoConfiguration& c, double dy0_second_m);

/// Along-track error [m], the mean of those of the two Doppler planes. Leberl (1979), Eq. 13:
///     dx = (dx0' + dx0'')/2 + dydot0' y/2 + dydot0'' (y - B)/2 + (dzdot0' + dzdot0'') H/2
/// kDerived: the line of sight is (0, y, -H), so the dydot0 terms have the opposite sign,
///     dx = (dx0' + dx0'')/2 - dydot0' y/2 - dydot0'' (y - B)/2 + (dzdot0' + dzdot0'') H/2.
[[nodiscard]] double AlongError(const StereoConfiguration& c,
                                const StereoErrors& errors,
                                Signs signs);

/// Across-track error [m], Leberl (1979), Eq. 14: illegible in our copy, derived in
/// docs/theory/leberl.md from the two range spheres,
///     dy = dy0' y/B - dy0'' (y - B)/B - (dz0' - dz0'') H/B + dr' r'/B - dr'' r''/B
/// A scale error counts as dr = range_scale r, here and in Eq. 15.
[[nodiscard]] double AcrossError(const StereoConfiguration& c, const StereoErrors& errors);

/// Height error [m], Leberl (1979), Eq. 15:
///     dz = (dy0' - dy0'') y (y - B)/(H B) - dz0' (y - B)/B + dz0'' y/B
///          + dr' r' (y - B)/(B H) - dr'' r'' y/(B H)
[[nodiscard]] double HeightError(const StereoConfiguration& c, const StereoErrors& errors);

/// Eq. 13, 14 and 15 together.
[[nodiscard]] PointError PointErrors(const StereoConfiguration& c,
                                     const StereoErrors& errors,
                                     Signs signs);

// Errors of coordinate differences, first order in the error and linear in the difference (Dy, Dz)
// between a point and the point (y, 0) of the configuration. dB = dy0'' - dy0', dH = dz0'' - dz0'.

/// dy = -(y/B) dB + const [m], without the constant (dy0'' itself). Leberl (1979), Eq. 16.
[[nodiscard]] double AcrossErrorOfBase(const StereoConfiguration& c, double base_error_m);
/// dz = ((B - y) y/(B H)) dB [m]. Leberl (1979), Eq. 17.
[[nodiscard]] double HeightErrorOfBase(const StereoConfiguration& c, double base_error_m);
/// dy = (H/B) dH [m]. Leberl (1979), Eq. 20.
[[nodiscard]] double AcrossErrorOfHeight(const StereoConfiguration& c, double height_error_m);
/// dz = (y/B) dH + const [m], without the constant. Leberl (1979), Eq. 21.
[[nodiscard]] double HeightErrorOfHeight(const StereoConfiguration& c, double height_error_m);

/// Difference of two points' coordinates: Dy across, Dz up.
struct Difference {
  double dy_m = 0.0;
  double dz_m = 0.0;
};

/// Effect of a base error [m]. Leberl (1979), Eq. 18 and 19:
///     d(Dy) = -(Dy/B) dB
///     d(Dz) = { Dy (B - 2y)/(B H) - Dz y (B - y)/(B H^2) } dB
/// kDerived: the Dz term is positive, because Dz reduces the height H above the point.
[[nodiscard]] Difference DifferenceErrorOfBase(const StereoConfiguration& c,
                                               const Difference& difference,
                                               double base_error_m,
                                               Signs signs);

/// Effect of a height difference error [m]. Leberl (1979), Eq. 22 and 23:
///     d(Dy) = (dH/B) Dz,   d(Dz) = (dH/B) Dy;   kDerived: d(Dy) = -(dH/B) Dz.
[[nodiscard]] Difference DifferenceErrorOfHeight(const StereoConfiguration& c,
                                                 const Difference& difference,
                                                 double height_error_m,
                                                 Signs signs);

/// Systematic slant range errors warp the model: d(Dy) = A Dy + F Dz, d(Dz) = C Dy + D Dz.
/// Leberl (1979), Eq. 24; the four are dimensionless. kDerived: F and D with the opposite sign.
struct Warp {
  double a = 0.0;
  double f = 0.0;
  double c = 0.0;
  double d = 0.0;
  [[nodiscard]] Difference Apply(const Difference& difference) const {
    return {a * difference.dy_m + f * difference.dz_m, c * difference.dy_m + d * difference.dz_m};
  }
};
[[nodiscard]] Warp RangeWarp(const StereoConfiguration& c,
                             double range_error_first_m,
                             double range_error_second_m,
                             Signs signs);

/// Scale errors of the ranges, dr' = e' r' and dr'' = e'' r'', which the paper does not have:
///     A = 2 (e' y - e'' (y - B))/B,                F = -2 (e' - e'') H/B,
///     C = (e' (r'^2 + 2 y (y - B)) - e'' (r''^2 + 2 y (y - B)))/(B H),
///     D = (e' (y - B)(y^2 - H^2) - e'' y ((y - B)^2 - H^2))/(B H^2).
/// docs/theory/leberl.md, section 3.
[[nodiscard]] Warp RangeScaleWarp(const StereoConfiguration& c,
                                  double range_scale_first,
                                  double range_scale_second);

/// Eq. 18, 19 and 22 to 24 together [m], with dB and dH of the stations' positions. kPrinted counts
/// a scale error as the constant dr = e r of the point (y, 0); kDerived adds RangeScaleWarp.
[[nodiscard]] Difference DifferenceErrors(const StereoConfiguration& c,
                                          const StereoErrors& errors,
                                          const Difference& difference,
                                          Signs signs);

/// Standard deviations of a point by independent range noise of both images, Leberl (1979), Eq. 25:
///     sigma_y^2 = sigma_r^2 (r'^2 + r''^2) / B^2
///     sigma_z^2 = sigma_r^2 (r'^2 (y - B)^2 + r''^2 y^2) / (B^2 H^2)
struct RangeNoise {
  double sigma_y_m = 0.0;
  double sigma_z_m = 0.0;
};
[[nodiscard]] RangeNoise NoiseOfRange(const StereoConfiguration& c, double range_sigma_m);

/// The same with a standard deviation for each image; equal ones give Eq. 25.
[[nodiscard]] RangeNoise NoiseOfRange(const StereoConfiguration& c,
                                      double first_range_sigma_m,
                                      double second_range_sigma_m);

}  // namespace sarblock::leberl
