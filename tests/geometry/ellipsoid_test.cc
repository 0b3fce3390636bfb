// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Published polar radii [m], computed here from a and f: NGA.STND.0036 (WGS84), Moritz 1980
// (GRS80), IAU 2000 (Mars). The Moon and Venus are spheres.
TEST(EllipsoidTest, NamedBodiesHaveTheirPublishedPolarRadii) {
  const auto polar_m = [](const char* name) {
    const Ellipsoid e = NamedEllipsoid(name);
    return e.a_m * (1.0 - e.flattening);
  };
  EXPECT_NEAR(polar_m("WGS84"), 6356752.314245, 1e-6);
  EXPECT_NEAR(polar_m("GRS80"), 6356752.314140, 1e-6);
  EXPECT_NEAR(polar_m("Mars"), 3376200.0, 1e-8);
  EXPECT_EQ(polar_m("Moon"), 1737400.0);
  EXPECT_EQ(polar_m("Venus"), 6051800.0);
  EXPECT_NEAR(1.0 / NamedEllipsoid("Mars").flattening, 169.894447223612, 1e-11);
}

TEST(EllipsoidTest, NamesAreMatchedWithoutCase) {
  EXPECT_EQ(NamedEllipsoid("wgs84").name, "WGS84");
  EXPECT_EQ(NamedEllipsoid("MOON").name, "Moon");
  for (const std::string& name : EllipsoidNames()) EXPECT_EQ(NamedEllipsoid(name).name, name);
}

TEST(EllipsoidTest, AnUnknownNameIsAnsweredWithTheNearestOne) {
  try {
    (void)NamedEllipsoid("WGS48");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean WGS84?"));
    EXPECT_THAT(error.what(), testing::HasSubstr("Venus"));
  }
}

TEST(EllipsoidTest, RefusesShapesThatAreNoOblateEllipsoid) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double a_m : {0.0, -6378137.0, inf, inf - inf}) {
    EXPECT_THROW(Validate({"x", a_m, 0.003}), InputError) << a_m;
  }
  for (const double f : {-0.003, 1.0, inf - inf}) {
    EXPECT_THROW(Validate({"x", 6378137.0, f}), InputError) << f;
  }
  EXPECT_NO_THROW(Validate({"sphere", 1737400.0, 0.0}));
}

}  // namespace
}  // namespace sarblock
