// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/reduction/reduction.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "reduction/reduction.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;

// The test case that stands in the IERS Conventions' program DEHANTTIDEINEL: a station, Sun and
// Moon, 2009-04-13 0 h, and the displacement. (Sun and Moon stand where inertial axes have them.)
const Vector3d kStation_m(4075578.385, 931852.890, 4801570.154);
const Vector3d kSun_m(137859926952.015, 54228127881.4350, 23509422341.6960);
const Vector3d kMoon_m(-179996231.920342, -312468450.131567, -169288918.592160);
const Vector3d kDisplacement_m(0.07700420357108126, 0.06304056321824968, 0.05516568152597247);

TEST(SolidEarthTide, IsThatOfTheConventionsProgram) {
  TidalBodies bodies = TidalBodiesAt("2009-04-13T00:00:00");
  bodies.positions_m = {kMoon_m, kSun_m};
  EXPECT_LT((SolidEarthTide_m(bodies, kStation_m) - kDisplacement_m).norm(), 1.5e-4);
}

// The eclipse of 2017-08-21 was greatest at 18:25:32 at 36.97 N, 87.67 W (Espenak, NASA): from
// there Moon and Sun were in one line, but for the aberration of the Sun (20").
TEST(TidalBodies, EclipseEachOther) {
  const auto [moon_m, sun_m] = TidalBodiesAt("2017-08-21T18:25:32").positions_m;
  const Vector3d place_m = Frame::Geocentric(NamedEllipsoid("WGS84"))
                               .FrameFromGeodetic({36.97 * kRadPerDeg, -87.67 * kRadPerDeg, 0.0});
  const Vector3d moon = (moon_m - place_m).normalized(), sun = (sun_m - place_m).normalized();
  EXPECT_LT((moon - sun).norm(), 2e-4);
  EXPECT_NEAR(std::asin(sun.dot(place_m.normalized())), 64.0 * kRadPerDeg, 0.5 * kRadPerDeg);
}

struct Known {
  double lat_deg, lon_deg;
  std::string utc;
  Vector3d enu_m;
};

// By PySolid 9ac869b (after D. Milbert's `solid`, which is the conventions' program with an
// ephemeris of its own).
TEST(SolidEarthTide, IsThatOfAnotherProgram) {
  for (const Known& known :
       {Known{20.8933, 87.0433, "2024-01-27T14:49:00Z", {0.044274, 0.008163, -0.063159}},
        Known{75.3706, 53.6308, "2013-02-12T15:55:00Z", {0.006616, -0.003935, -0.152833}},
        Known{-37.4880, 149.8843, "2020-03-25T02:08:00Z", {0.008758, 0.058608, 0.115528}},
        Known{-3.1929, 73.6809, "2009-05-01T23:22:00Z", {0.026540, -0.024112, 0.106987}}}) {
    const Geodetic place{known.lat_deg * kRadPerDeg, known.lon_deg * kRadPerDeg, 0.0};
    EXPECT_LT((SolidEarthTide_m(place, known.utc) - known.enu_m).cwiseAbs().maxCoeff(), 1e-3)
        << known.utc << ": " << SolidEarthTide_m(place, known.utc).transpose();
  }
}

TEST(SolidEarthTide, IsThatOfAnotherProgramAtTwentyPlaces) {
  const auto path = std::filesystem::path(SARBLOCK_SHARED_DATA) / "tides" / "solid_earth_tide.txt";
  std::ifstream file(path);
  if (!file) GTEST_SKIP() << path << " is not there";
  int count = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    double lat_deg, lon_deg, second_of_day_s;
    int year, month, day, hour, minute;
    Vector3d enu_m;
    words >> lat_deg >> lon_deg >> year >> month >> day >> hour >> minute >> second_of_day_s >>
        enu_m.x() >> enu_m.y() >> enu_m.z();
    ASSERT_TRUE(words) << line;
    std::array<char, 80> utc;
    std::snprintf(
        utc.data(), utc.size(), "%04d-%02d-%02dT%02d:%02d:00Z", year, month, day, hour, minute);
    const Geodetic place{lat_deg * kRadPerDeg, lon_deg * kRadPerDeg, 0.0};
    const Vector3d difference_m = SolidEarthTide_m(place, utc.data()) - enu_m;
    EXPECT_LT(difference_m.cwiseAbs().maxCoeff(), 1e-3) << line << ": " << difference_m.transpose();
    ++count;
  }
  EXPECT_EQ(count, 20);
}

TEST(SolidEarthTide, RefusesWhatIsNoTimeOfItsTable) {
  const auto problem = [](const char* utc) -> std::string {
    try {
      (void)SolidEarthTide_m(Geodetic{}, utc);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem("yesterday"), testing::StartsWith("utc: 'yesterday' is no time in UTC"));
  EXPECT_THAT(problem("1971-12-31T23:59:59Z"), testing::HasSubstr("from 1972 on"));
  EXPECT_THAT(problem("2035-01-01T00:00:00Z"), testing::HasSubstr("from 1972 to 2034"));
  EXPECT_EQ(problem("2034-12-31T23:59:59Z"), "");
}

}  // namespace
}  // namespace sarblock
