// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/block_file.h"

#include <string>

#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// One pass over Alice Springs; [frame] and points are the test's.
class KnownFramesTest : public test::FolderTest {
 protected:
  Block Read(const std::string& frame, const std::string& points) const {
    Put("block.toml",
        "format = \"sarblock-block 1\"\nname = \"alice\"\n[frame]\nkind = "
        "\"geocentric\"\nellipsoid = "
        "\"WGS84\"\n" +
            frame +
            "[sigma]\nrange_m = 1.0\nazimuth_m = 1.0\n[[pass]]\nid = \"A\"\nlook = \"left\"\n"
            "epoch_utc = \"2022-10-16T01:50:44Z\"\n");
    Put("trajectories.csv",
        "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
        "A,0,-4500000,4700000,-2800000,0,0,7500\nA,10,-4500000,4700000,-2725000,0,0,7500\n");
    Put("observations.csv", "pass,point,time_s,range_m\nA,P,5,800000\n");
    Put("points.csv", points);
    return files::ReadBlock(folder_).block;
  }
};

constexpr const char* kPointHead = "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m";
constexpr const char* kItrf = "realization = \"itrf2014\"\nepoch = 2018.0\n";
// ICSM, GDA2020 Technical Manual, section 3: Alice Springs in GDA2020 and in ITRF2014 at 2018.0.
constexpr const char* kGda = "P,control,-4052052.7373,4212835.9835,-2545104.5867,0.01,0.01,0.01";
const Vector3d kItrf2014_m(-4052052.6588, 4212835.9938, -2545104.6946);
const Vector3d kGda2020_m(-4052052.7373, 4212835.9835, -2545104.5867);

TEST_F(KnownFramesTest, PointsComeToTheFrameOfTheBlock) {
  const Block block = Read(kItrf, std::string(kPointHead) + ",frame\n" + kGda + ",GDA2020\n");
  EXPECT_EQ(block.realization, "ITRF2014");
  EXPECT_EQ(block.epoch_year, 2018.0);
  EXPECT_LT((block.points.given_m[0] - kItrf2014_m).norm(), 2e-4);
  // At rest on its plate it moves in the international frame: both coincide at 2020.0.
  EXPECT_LT((kItrf2014_m + 2.0 * block.points.known[0].velocity_mpy - kGda2020_m).norm(), 3e-4);
}

TEST_F(KnownFramesTest, PointsComeToTheEpochOfTheBlock) {
  const Block block = Read(kItrf,
                           std::string(kPointHead) + ",epoch,vx_mpy,vy_mpy,vz_mpy\n" + kGda +
                               ",2008.0,0.01,-0.02,0.03\n");
  EXPECT_LT((block.points.given_m[0] - kGda2020_m - Vector3d(0.1, -0.2, 0.3)).norm(), 1e-9);
  EXPECT_EQ(block.points.known[0].velocity_mpy, Vector3d(0.01, -0.02, 0.03));
}

TEST_F(KnownFramesTest, WhatIsWrittenReadsBack) {
  const Block block = Read(kItrf, std::string(kPointHead) + ",frame\n" + kGda + ",GDA2020\n");
  files::WriteBlock(folder_ / "again", block, {});
  const Block again = files::ReadBlock(folder_ / "again").block;
  EXPECT_EQ(again.realization, block.realization);
  EXPECT_EQ(again.epoch_year, block.epoch_year);
  EXPECT_EQ(again.points.given_m[0], block.points.given_m[0]);
  EXPECT_EQ(again.points.known[0].velocity_mpy, block.points.known[0].velocity_mpy);
  EXPECT_THAT(Content(folder_ / "again" / "points.csv"),
              testing::AllOf(HasSubstr("vz_mpy"), testing::Not(HasSubstr("geoid"))));
}

// EGM96 by its harmonics is 15.871 m over this place (NGA), by the grid of 15' 15.93 m.
TEST_F(KnownFramesTest, HeightsAboveTheGeoid) {
  const std::string head = "point,role,lat_deg,lon_deg,h_m,sigma_e_m,sigma_n_m,sigma_u_m";
  const std::string row = "P,control,-23.6174460,133.8747120,500,0.01,0.01,0.01";
  const Block above = Read("", head + ",geoid\n" + row + ",egm96\n");
  const Block plain = Read("", head + "\n" + row + "\n");
  const Vector3d up_m = above.points.given_m[0] - plain.points.given_m[0];
  EXPECT_NEAR(up_m.norm(), 15.871, 0.1);
  EXPECT_GT(up_m.dot(plain.points.given_m[0]), 0.0);
}

}  // namespace
}  // namespace sarblock
