// SPDX-License-Identifier: Apache-2.0
// The configurations of Leberl (1979), Fig. 3 to 5, 8 and 9, against closed forms.
#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "leberl/pairs.h"
#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using leberl::Arrangement;
using leberl::StereoConfiguration;

const FigureOptions kOptions{
    .ground = {.base_m = 7300.0, .height_m = 9600.0, .ground_range_m = 18100.0},
    .sigma_range_m = 1.7,
    .sigma_azimuth_m = 2.3};

const FigureRow& Find(const std::vector<FigureRow>& rows, const std::string& name) {
  for (const FigureRow& row : rows) {
    if (row.name == name) return row;
  }
  throw std::logic_error("no configuration " + name);
}

// Closed form: Eq. 25 across and up; along, the mean of two azimuths.
void ExpectEq25(const FigureRow& row, const StereoConfiguration& c) {
  const leberl::RangeNoise noise = leberl::NoiseOfRange(c, kOptions.sigma_range_m);
  ASSERT_TRUE(row.sigmas.has_value()) << row.name;
  EXPECT_NEAR(row.sigmas->along_m, kOptions.sigma_azimuth_m / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(row.sigmas->across_m, noise.sigma_y_m, 1e-9 * noise.sigma_y_m);
  EXPECT_NEAR(row.sigmas->up_m, noise.sigma_z_m, 1e-9 * noise.sigma_z_m);
  EXPECT_NEAR(row.exaggeration.value(), leberl::Exaggeration(c), 1e-9);
  EXPECT_NEAR(row.intersection_rad, IntersectionAngle(c), 1e-12);
  EXPECT_NEAR(row.base_m.value(), c.base_m, 1e-9);
}

TEST(PaperFiguresTest, ParallelPairsAreEq25) {
  const auto rows = PaperFigures(kOptions);
  ExpectEq25(Find(rows, "same side"), kOptions.ground);
  StereoConfiguration opposite = kOptions.ground;  // '' as far beyond the point as before it
  opposite.base_m = 2.0 * 18100.0 - 7300.0;
  opposite.arrangement = Arrangement::kOppositeSide;
  ExpectEq25(Find(rows, "opposite side"), opposite);
  EXPECT_NEAR(
      Find(rows, "opposite side").second_look_rad, Find(rows, "same side").second_look_rad, 1e-12);
}

// Dense normal equations of range and Doppler written out: unit sights (0, s, -c) and (s, 0, -c).
TEST(PaperFiguresTest, CrossingFlightsGiveEachOtherWhatTheyLack) {
  const double ground_m = kOptions.ground.ground_range_m, height_m = kOptions.ground.height_m;
  const double s = ground_m / std::hypot(ground_m, height_m);
  const double c = height_m / std::hypot(ground_m, height_m);
  Eigen::Matrix<double, 4, 3> jacobian;
  jacobian << 0.0, s, -c, s, 0.0, -c, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  jacobian.topRows(2) /= kOptions.sigma_range_m;
  jacobian.bottomRows(2) /= kOptions.sigma_azimuth_m;
  const Eigen::Matrix3d normal = jacobian.transpose() * jacobian;
  const Eigen::Matrix3d covariance = normal.ldlt().solve(Eigen::Matrix3d::Identity());
  const FigureRow row = Find(PaperFigures(kOptions), "cross-wise");
  ASSERT_TRUE(row.sigmas.has_value());
  EXPECT_NEAR(row.sigmas->along_m, std::sqrt(covariance(0, 0)), 1e-9);
  EXPECT_NEAR(row.sigmas->across_m, std::sqrt(covariance(1, 1)), 1e-9);
  EXPECT_NEAR(row.sigmas->up_m, std::sqrt(covariance(2, 2)), 1e-9);
  EXPECT_NEAR(std::cos(row.intersection_rad), c * c, 1e-12);  // of the two sights
  EXPECT_FALSE(row.base_m.has_value());
  EXPECT_FALSE(row.exaggeration.has_value());
}

// The two ranges alone: y n_y - h n_z = r, solved by Cramer's rule.
TEST(PaperFiguresTest, TwoHeightsIntersectByTheirHeightsAlone) {
  const FigureRow row = Find(PaperFigures(kOptions), "two heights");
  const double y = kOptions.ground.ground_range_m, sigma_m = kOptions.sigma_range_m;
  const double low_m = 0.6 * 9600.0, high_m = 1.2 * 9600.0;
  const double r1 = std::hypot(y, low_m), r2 = std::hypot(y, high_m);
  const double determinant = y * (low_m - high_m) / (r1 * r2);
  ASSERT_TRUE(row.sigmas.has_value());
  EXPECT_NEAR(row.sigmas->across_m,
              sigma_m * std::hypot(high_m / r2, low_m / r1) / std::abs(determinant),
              1e-9);
  EXPECT_NEAR(row.sigmas->up_m, sigma_m * std::hypot(y / r2, y / r1) / std::abs(determinant), 1e-9);
  EXPECT_NEAR(row.exaggeration.value(), 5.0 * (high_m - low_m) / y, 1e-12);  // cot = h/y
  EXPECT_EQ(row.base_m.value(), 0.0);
}

// A squinted look of a straight flight measures x = v t + r sin(tau) and the distance from the line
// r cos(tau): dense normal equations of both looks' pairs, correlated by r.
TEST(PaperFiguresTest, ConvergentLooksMeasureAlongAndDistanceTogether) {
  const double y = kOptions.ground.ground_range_m, height = kOptions.ground.height_m;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const auto& [across, squint_deg] :
       {std::pair{y, 20.0}, std::pair{y - kOptions.ground.base_m, -20.0}}) {
    const double sine = std::sin(squint_deg * kRadPerDeg),
                 cosine = std::cos(squint_deg * kRadPerDeg);
    const double range_m2 = std::pow(kOptions.sigma_range_m, 2);
    Eigen::Matrix2d covariance_m2;
    covariance_m2 << std::pow(kOptions.sigma_azimuth_m, 2) + sine * sine * range_m2,
        sine * cosine * range_m2, sine * cosine * range_m2, cosine * cosine * range_m2;
    Eigen::Matrix<double, 2, 3> jacobian;
    const double distance = std::hypot(across, height);
    jacobian << 1.0, 0.0, 0.0, 0.0, across / distance, -height / distance;
    normal += jacobian.transpose() * covariance_m2.ldlt().solve(jacobian);
  }
  const Eigen::Matrix3d covariance = normal.ldlt().solve(Eigen::Matrix3d::Identity());
  const FigureRow row = Find(PaperFigures(kOptions), "convergent");
  ASSERT_TRUE(row.sigmas.has_value());
  EXPECT_NEAR(row.sigmas->along_m, std::sqrt(covariance(0, 0)), 1e-9);
  EXPECT_NEAR(row.sigmas->across_m, std::sqrt(covariance(1, 1)), 1e-9);
  EXPECT_NEAR(row.sigmas->up_m, std::sqrt(covariance(2, 2)), 1e-9);
}

TEST(PaperFiguresTest, OneStraightFlightIsNoStereo) {
  const FigureRow row = Find(PaperFigures(kOptions), "single flight");
  EXPECT_EQ(row.outcome, IntersectionOutcome::kCirclesCoincide);
  EXPECT_FALSE(row.sigmas.has_value());
  EXPECT_FALSE(row.exaggeration.has_value());
  EXPECT_NEAR(row.intersection_rad, 0.0, 1e-7);
}

// Two tangents of the orbit meet above its middle, so the planes of both flights and the point turn
// about the line from there to the point by twice atan(tan(a) sin(angle of that line off the
// vertical)), with a the angle of each antenna from the middle.
TEST(PaperFiguresTest, OneOrbitIsAStereoOfTheTurnOfItsTangents) {
  const FigureRow row = Find(PaperFigures(kOptions), "single orbit");
  ASSERT_EQ(row.outcome, IntersectionOutcome::kDetermined);
  const double earth_m = 6378137.0, orbit_m = earth_m + 700e3, look_rad = std::acos(-1.0) / 4.0;
  const double foot_m = orbit_m * std::cos(look_rad);
  const double range_m =
      foot_m - std::sqrt(foot_m * foot_m - (orbit_m * orbit_m - earth_m * earth_m));
  const double y_m = range_m * std::sin(look_rad), z_m = orbit_m - range_m * std::cos(look_rad);
  double angle_rad = 0.0;  // sin(a) z = sin(15 deg) |p - s(a)|, by bisection
  double above_rad = 0.1;
  while (above_rad - angle_rad > 1e-15) {
    const double middle = 0.5 * (angle_rad + above_rad);
    const double distance_m =
        std::hypot(orbit_m * std::sin(middle), y_m, orbit_m * std::cos(middle) - z_m);
    const bool short_of = z_m * std::sin(middle) < std::sin(std::acos(-1.0) / 12.0) * distance_m;
    (short_of ? angle_rad : above_rad) = middle;
    if (middle == angle_rad && middle == above_rad) break;
  }
  const double top_m = orbit_m / std::cos(angle_rad);
  const double sine = y_m / std::hypot(y_m, top_m - z_m);
  const double half_turn_rad = std::atan(std::tan(angle_rad) * sine);
  // dtheta is that of the sights projected on the planes normal to each velocity.
  const auto projected = [&](double a) {
    const Eigen::Vector3d along(std::cos(a), 0.0, -std::sin(a));
    Eigen::Vector3d sight(-orbit_m * std::sin(a), y_m, z_m - orbit_m * std::cos(a));
    sight -= sight.dot(along) * along;
    return Eigen::Vector3d(sight.normalized());
  };
  EXPECT_NEAR(std::sin(0.5 * row.intersection_rad),
              0.5 * (projected(angle_rad) - projected(-angle_rad)).norm(),
              1e-9);
  // The weak direction is known by the two along-track coordinates over this turn: in the plane of
  // a look their sigma lies between those of range and azimuth and a fifth more.
  const double weak_m = std::hypot(row.sigmas->across_m, row.sigmas->up_m);
  const double unit_m = weak_m * std::sqrt(2.0) * std::sin(half_turn_rad);
  EXPECT_GT(unit_m, kOptions.sigma_range_m);
  EXPECT_LT(unit_m, 1.2 * kOptions.sigma_azimuth_m);
}

TEST(PaperFiguresTest, ApolloLooksFrom14To20Degrees) {
  const auto rows = PaperFigures(kOptions);
  // hand: 5 116 3/(y (y - 3)) with y = 116 tan(14 deg) + 1.5 km, and 5 116 13/(...) at 17 degrees
  const auto q = [](double base_km, double look_deg) {
    const double middle_km = 116.0 * std::tan(look_deg * kRadPerDeg);
    return 5.0 * 116.0 * base_km / (middle_km * middle_km - 0.25 * base_km * base_km);
  };
  EXPECT_NEAR(Find(rows, "Apollo radar, 14 deg").exaggeration.value(), q(3.0, 14.0), 1e-9);
  EXPECT_NEAR(Find(rows, "Apollo radar, 20 deg").exaggeration.value(), q(3.0, 20.0), 1e-9);
  const FigureRow& wide = Find(rows, "Apollo radar, 17 deg");
  EXPECT_NEAR(wide.exaggeration.value(), q(13.0, 17.0), 1e-9);
  EXPECT_NEAR(wide.second_look_rad * kDegPerRad, 14.0, 0.1);  // both ends of the looks
  EXPECT_NEAR(wide.first_look_rad * kDegPerRad, 20.0, 0.2);
}

TEST(PaperFiguresTest, RefusesWhatIsNoGround) {
  FigureOptions bad = kOptions;
  bad.sigma_range_m = 0.0;
  EXPECT_THROW((void)PaperFigures(bad), InputError);
  bad = kOptions;
  bad.sigma_azimuth_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)PaperFigures(bad), InputError);
  bad = kOptions;
  bad.ground.ground_range_m = 7300.0;
  EXPECT_THROW((void)PaperFigures(bad), InputError);
  bad.ground.ground_range_m = 3000.0;
  bad.ground.arrangement = Arrangement::kOppositeSide;
  EXPECT_THROW((void)PaperFigures(bad), InputError);
}

}  // namespace
}  // namespace sarblock
