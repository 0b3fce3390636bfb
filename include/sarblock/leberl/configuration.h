// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock::leberl {

// F. Leberl, "Accuracy Analysis of Stereo Side-Looking Radar" (1979), cited here as Leberl (1979).
//
// Frame of the paper: x along track, y across, z up, z = 0 the datum. Station ' (first) stands at
// (x, 0, H), station '' (second) at (x, B, H), both fly along +x, the point is (x, y, 0). Every
// closed form of this module holds for a point of the datum; for a point at height z put H - z.
// docs/theory/leberl.md derives what the paper leaves out.

/// Same-side: both stations stand on one side of the point. Opposite-side: it lies between them.
enum class Arrangement { kSameSide, kOppositeSide };

/// Stereo base B, flying height H and ground range y of the point from the nadir line of station '.
struct StereoConfiguration {
  double base_m = 0.0;          ///< B; not 0, negative if station '' stands at smaller y
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

/// Four of the printed equations (13, 19, 22, 24) carry terms whose sign does not follow from the
/// geometry (docs/theory/leberl.md). Both versions are kept: the first to compare with the paper's
/// numbers, the second to predict.
enum class Signs {
  kPrinted,  ///< as the paper prints them
  kDerived,  ///< as the derivation from Eq. 1-4 gives them
};

}  // namespace sarblock::leberl
