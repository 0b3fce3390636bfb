// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/frame.h"

#include "sarblock/core/error.h"

#include <cmath>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Ellipsoid kFlat{"very flat", 3.1e6, 0.11};  // makes every ellipsoidal term large

// Closed form: the textbook formula of geodetic to Cartesian coordinates.
Vector3d Textbook(const Ellipsoid& e, const Geodetic& g) {
  const double e2 = e.flattening * (2.0 - e.flattening);
  const double n_m = e.a_m / std::sqrt(1.0 - e2 * std::sin(g.lat_rad) * std::sin(g.lat_rad));
  return {(n_m + g.h_m) * std::cos(g.lat_rad) * std::cos(g.lon_rad),
          (n_m + g.h_m) * std::cos(g.lat_rad) * std::sin(g.lon_rad),
          (n_m * (1.0 - e2) + g.h_m) * std::sin(g.lat_rad)};
}

Matrix3d TextbookEnu(const Geodetic& g) {
  const double sp = std::sin(g.lat_rad), cp = std::cos(g.lat_rad);
  const double sl = std::sin(g.lon_rad), cl = std::cos(g.lon_rad);
  Matrix3d rows;
  rows << -sl, cl, 0.0, -sp * cl, -sp * sl, cp, cp * cl, cp * sl, sp;
  return rows;
}

const Geodetic kPlaces[] = {{0.8213, 0.2017, 693127.3},
                            {-1.2031, -2.9077, 1371.9},
                            {0.00037, 1.6021, -411.7},
                            {-0.3719, -0.7703, 12000.1}};

TEST(FrameTest, AgreesWithTheTextbookFormulas) {
  for (const Ellipsoid& e : {NamedEllipsoid("WGS84"), NamedEllipsoid("Mars"), kFlat}) {
    const Frame frame = Frame::Geocentric(e);
    for (const Geodetic& g : kPlaces) {
      const Vector3d p_m = Textbook(e, g);
      EXPECT_LE((frame.FrameFromGeodetic(g) - p_m).norm(), 5e-9);  // rounding of 7e6 m, degrees
      EXPECT_LE((frame.EnuFromFrame(p_m) - TextbookEnu(g)).norm(), 3e-15);
      const Vertical vertical = frame.VerticalAt(p_m);
      EXPECT_LE((vertical.up - TextbookEnu(g).row(2).transpose()).norm(), 2e-15);
      EXPECT_NEAR(vertical.height_m, g.h_m, 5e-9);
    }
  }
}

// Second route: the exact vertical, from below the ground to orbits and from the equator to a pole.
TEST(FrameTest, UpIsThatOfTheVertical) {
  for (const Ellipsoid& e : {NamedEllipsoid("WGS84"), NamedEllipsoid("Mars"), kFlat}) {
    const Frame frame = Frame::Geocentric(e);
    for (const double height_m : {-9000.0, 0.0, 7e5, 3.6e7}) {
      for (double latitude_rad = -M_PI_2; latitude_rad < 1.58; latitude_rad += M_PI / 32.0) {
        const Vector3d p_m = Textbook(e, {latitude_rad, 2.3, height_m});
        EXPECT_LE((frame.UpAt(p_m) - frame.VerticalAt(p_m).up).norm(), 1e-8)
            << latitude_rad << ' ' << height_m;
      }
    }
  }
  EXPECT_EQ(Frame::Local().UpAt({1.0, 2.0, 3.0}), Vector3d::UnitZ());
}

TEST(FrameTest, GeodeticCoordinatesReturn) {  // round trip
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  for (const Geodetic& g : kPlaces) {
    const Geodetic back = frame.GeodeticFromFrame(frame.FrameFromGeodetic(g));
    EXPECT_NEAR(back.lat_rad, g.lat_rad, 1e-15);
    EXPECT_NEAR(back.lon_rad, g.lon_rad, 2e-15);
    EXPECT_NEAR(back.h_m, g.h_m, 5e-9);
  }
}

TEST(FrameTest, EastAtAPoleIsThatOfLongitudeZero) {  // hand value: east is +y
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Matrix3d north_pole = frame.EnuFromFrame({0.0, 0.0, 6356800.3});
  EXPECT_LE((north_pole.row(0) - Vector3d(0, 1, 0).transpose()).norm(), 1e-15);
  EXPECT_LE((north_pole.row(1) - Vector3d(-1, 0, 0).transpose()).norm(), 1e-15);
  EXPECT_LE((north_pole.row(2) - Vector3d(0, 0, 1).transpose()).norm(), 1e-15);
}

// Central differences of up itself; step 10 m: truncation (10/2e6)^2/2e6 = 1e-17 and rounding of up
// 1e-15/20 = 5e-17 per metre, where the derivative is 3e-7 per metre.
TEST(FrameTest, VerticalTurnsByTheCurvatureOfItsPlace) {
  for (const Ellipsoid& e : {NamedEllipsoid("WGS84"), NamedEllipsoid("Moon"), kFlat}) {
    const Frame frame = Frame::Geocentric(e);
    for (const Geodetic& g : kPlaces) {
      const Vector3d p_m = Textbook(e, g);
      const Vertical vertical = frame.VerticalAt(p_m);
      EXPECT_LE((vertical.dup_dp - vertical.dup_dp.transpose()).norm(), 1e-22);
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d step_m = 10.0 * Vector3d::Unit(axis);
        const Vector3d difference =
            (frame.VerticalAt(p_m + step_m).up - frame.VerticalAt(p_m - step_m).up) / 20.0;
        EXPECT_LE((vertical.dup_dp.col(axis) - difference).norm(), 1e-16);
      }
    }
  }
}

TEST(FrameTest, AtHeightKeepsLatitudeAndLongitude) {
  const Frame frame = Frame::Geocentric(kFlat);
  for (const Geodetic& g : kPlaces) {
    const Geodetic moved{g.lat_rad, g.lon_rad, 713.27};
    EXPECT_LE((frame.AtHeight(Textbook(kFlat, g), 713.27) - Textbook(kFlat, moved)).norm(), 5e-9);
  }
  EXPECT_EQ(Frame::Local().AtHeight({3.7, -2.9, 11.3}, 713.27), Vector3d(3.7, -2.9, 713.27));
}

TEST(FrameTest, TheLocalFrameIsFlat) {
  const Frame frame = Frame::Local();
  const Vector3d p_m(913.7, -411.3, 57.9);
  EXPECT_EQ(frame.kind(), FrameKind::kLocal);
  EXPECT_EQ(frame.EnuFromFrame(p_m), Matrix3d::Identity());
  const Vertical vertical = frame.VerticalAt(p_m);
  EXPECT_EQ(vertical.up, Vector3d::UnitZ());
  EXPECT_EQ(vertical.height_m, 57.9);
  EXPECT_EQ(vertical.dup_dp, Matrix3d::Zero());
  const VerticalMotion motion = frame.VerticalAlong(p_m, {71.3, 2.1, 0.3}, {0.1, 0.2, -0.3});
  EXPECT_EQ(motion.up, Vector3d::UnitZ());
  EXPECT_EQ(motion.rate, Vector3d::Zero());
  EXPECT_EQ(motion.acceleration, Vector3d::Zero());
}

TEST(FrameTest, RefusesGeodeticCoordinatesInALocalFrame) {
  EXPECT_THROW((void)Frame::Local().GeodeticFromFrame({1.0, 2.0, 3.0}), InputError);
  EXPECT_THROW((void)Frame::Local().FrameFromGeodetic({0.1, 0.2, 3.0}), InputError);
  EXPECT_THROW((void)Frame::Geocentric({"x", -1.0, 0.0}), InputError);
}

}  // namespace
}  // namespace sarblock
