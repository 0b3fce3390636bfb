// SPDX-License-Identifier: Apache-2.0
#include "reduction/frames.h"

#include "sarblock/core/error.h"

#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;

void ExpectNear(const MovingPoint& actual, const MovingPoint& expected, const std::string& what) {
  EXPECT_LT((actual.position_m - expected.position_m).cwiseAbs().maxCoeff(), 2e-4) << what;
  EXPECT_LT((actual.velocity_mpy - expected.velocity_mpy).cwiseAbs().maxCoeff(), 2e-5)
      << what << ": " << actual.velocity_mpy.transpose();
}

// Z. Altamimi (2024), EUREF Technical Note 1, example 1: Brussels at 2010.0 in six realizations.
struct Realized {
  const char* name;
  MovingPoint point;
};
const Realized kBrussels[] = {
    {"ITRF2020", {{4027893.6750, 307045.9069, 4919475.1721}, {-0.01361, 0.01686, 0.01024}}},
    {"ITRF2014", {{4027893.6719, 307045.9064, 4919475.1704}, {-0.01361, 0.01676, 0.01044}}},
    {"ETRF2014", {{4027893.9620, 307045.5480, 4919474.9553}, {0.00020, -0.00030, 0.00020}}},
    {"ITRF2000", {{4027893.6812, 307045.9082, 4919475.1547}, {-0.01307, 0.01690, 0.00908}}},
    {"ETRF2000", {{4027894.0053, 307045.5939, 4919474.9083}, {-0.00020, -0.00050, -0.00036}}},
};

TEST(ReferenceFrames, TransformAsTheTechnicalNoteOfEuref) {
  ReferenceFrames frames;
  for (const Realized& from : kBrussels) {
    for (const Realized& to : kBrussels) {
      ExpectNear(frames.Transform(from.name, to.name, 2010.0, from.point),
                 to.point,
                 std::string(from.name) + " to " + to.name);
    }
  }
}

// Its example 2: the same place at 2020.0.
TEST(ReferenceFrames, TransformAtTheEpochOfThePoint) {
  ReferenceFrames frames;
  const MovingPoint itrf{{4027893.5389, 307046.0755, 4919475.2745}};
  EXPECT_LT((frames.Transform("ITRF2020", "ETRF2014", 2020.0, itrf).position_m -
             Vector3d(4027893.9639, 307045.5450, 4919474.9573))
                .norm(),
            3e-4);
  EXPECT_LT((frames.Transform("ITRF2020", "ITRF2014", 2020.0, itrf).position_m -
             Vector3d(4027893.5358, 307046.0740, 4919475.2748))
                .norm(),
            3e-4);
}

// ICSM, GDA2020 Technical Manual, section 3: Alice Springs in ITRF2014 at 2018.0; at rest on its
// plate it moves by 3 cm to the west, 6 cm to the north a year.
TEST(ReferenceFrames, TransformAsTheManualOfGda2020) {
  ReferenceFrames frames;
  const Vector3d itrf_m(-4052052.6588, 4212835.9938, -2545104.6946);
  const Vector3d gda_m(-4052052.7373, 4212835.9835, -2545104.5867);
  const MovingPoint there = frames.Transform("ITRF2014", "GDA2020", 2018.0, {itrf_m});
  EXPECT_LT((there.position_m - gda_m).norm(), 2e-4);
  const MovingPoint back = frames.Transform("GDA2020", "ITRF2014", 2018.0, {gda_m});
  EXPECT_LT((back.position_m - itrf_m).norm(), 2e-4);
  // Both frames coincide at 2020.0.
  EXPECT_LT((back.After(2.0).position_m - gda_m).norm(), 2e-4);
  EXPECT_NEAR(back.velocity_mpy.norm(), 0.067, 0.003);
}

// Soler and Snay (2004): NAD 83 and ITRF differ by about 2 m. Parameters at 2010.0 by hand (EPSG
// 8970): x 1.0053, y -1.9092, z -0.5416 m, rotations 26.7814, -0.4203, 10.9321 mas, scale 0.37e-9.
TEST(ReferenceFrames, TransformToNorthAmerica) {
  ReferenceFrames frames;
  const Vector3d p_m(-734971.7, -4893188.5, 4011982.8);
  const double mas = 1e-3 / 206264.80624709636;
  const Vector3d r = mas * Vector3d(26.7814, -0.4203, 10.9321);
  // Coordinate frame rotation: p + (p x r).
  const Vector3d expected_m = Vector3d(1.0053, -1.9092, -0.5416) + (1.0 + 0.37e-9) * p_m +
                              Vector3d(p_m.y() * r.z() - p_m.z() * r.y(),
                                       p_m.z() * r.x() - p_m.x() * r.z(),
                                       p_m.x() * r.y() - p_m.y() * r.x());
  const MovingPoint there = frames.Transform("ITRF2014", "NAD83(2011)", 2010.0, {p_m});
  EXPECT_LT((there.position_m - expected_m).norm(), 1e-4);
  // A point at rest on the plate moves by 1 to 2 cm a year in the international frame.
  EXPECT_NEAR(
      frames.Transform("NAD83(2011)", "ITRF2014", 2010.0, {there.position_m}).velocity_mpy.norm(),
      0.016,
      0.006);
}

std::string RefusalOf(const std::function<void()>& task) {
  try {
    task();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ReferenceFrames, KnowTheirNames) {
  ReferenceFrames frames;
  EXPECT_EQ(frames.Named("itrf2020"), "ITRF2020");
  EXPECT_EQ(frames.Named("wgs 84 (g2139)"), "WGS 84 (G2139)");
  EXPECT_THAT(RefusalOf([&] { (void)frames.Named("ITRF2O14"); }),
              testing::AllOf(testing::StartsWith("realization: 'ITRF2O14' is not known"),
                             testing::HasSubstr("ITRF2008"),
                             testing::HasSubstr("did you mean ITRF2014")));
  EXPECT_THAT(RefusalOf([&] { (void)frames.Named("WGS 84"); }),
              testing::HasSubstr("stands for several realizations"));
  EXPECT_FALSE(frames.MovesWithPlate("ITRF2014"));
  EXPECT_TRUE(frames.MovesWithPlate("GDA2020"));
  EXPECT_TRUE(frames.MovesWithPlate("NAD83(2011)"));
  EXPECT_TRUE(frames.MovesWithPlate("ETRF2000"));
}

// IGS14 is ITRF2014, but by a method of EPSG's (1065) that PROJ 9.1 lacks.
TEST(ReferenceFrames, RefuseWhatProjDoesNotKnow) {
  ReferenceFrames frames;
  EXPECT_THAT(
      RefusalOf([&] {
        (void)frames.Transform(
            "ITRF2014", "IGS14", 2010.0, {Vector3d(4027893.7, 307045.9, 4919475.2)});
      }),
      testing::StartsWith("frame: PROJ's data have no transformation from ITRF2014 to IGS14"));
  EXPECT_THAT(RefusalOf([&] {
                (void)frames.Transform(
                    "GDA2020", "ITRF2014", 2020.0, {Vector3d(4027893.7, 307045.9, 4919475.2)});
              }),
              testing::StartsWith("frame: GDA2020 is not used at this place, but in: Australia"));
}

// The test values that NGA gives with EGM96; they come from the harmonics, the grid of 15' is read
// between its nodes.
TEST(ReferenceFrames, HaveTheHeightOfTheGeoid) {
  ReferenceFrames frames;
  struct Place {
    double lat_deg, lon_deg, height_m;
  };
  for (const auto& [lat_deg, lon_deg, height_m] : {Place{38.6281550, 269.7791550, -31.628},
                                                   Place{-14.6212170, 305.0211140, -2.969},
                                                   Place{46.8743190, 102.4487290, -43.575},
                                                   Place{-23.6174460, 133.8747120, 15.871},
                                                   Place{38.6254730, 359.9995000, 50.066},
                                                   Place{-0.4667440, 0.0023000, 17.329}}) {
    EXPECT_NEAR(
        frames.GeoidHeight_m("EGM96", lat_deg * kRadPerDeg, lon_deg * kRadPerDeg), height_m, 0.1)
        << lat_deg;
  }
  EXPECT_EQ(RefusalOf([&] { (void)frames.GeoidHeight_m("egm84", 0.0, 0.0); }),
            "geoid: 'egm84' is not known, egm96 or egm2008 is allowed");
}

// Three years at 7 cm are 0.21 m.
TEST(DoubtOfPlates, SpeaksWhereItMatters) {
  Block block;
  block.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  block.passes.resize(2);
  block.passes[0].epoch_utc = "2019-10-16T00:00:00Z";
  block.passes[1].epoch_utc = "2022-10-16T00:00:00Z";
  block.points.known.resize(1);
  block.points.known[0].fixed = {true, true, false};
  block.points.known[0].covariance_enu_m2 = Eigen::Vector3d(0.01, 0.01, 0.0).asDiagonal();
  EXPECT_THAT(DoubtOfPlates(block),
              testing::AllOf(testing::StartsWith("known points are good to 0.1 m"),
                             testing::HasSubstr("3 years apart"),
                             testing::HasSubstr("0.06 to 0.21 m"),
                             testing::HasSubstr("realization and epoch")));
  Block coarse = block;
  coarse.points.known[0].covariance_enu_m2 *= 9.0;
  EXPECT_EQ(DoubtOfPlates(coarse), "");
  Block same_day = block;
  same_day.passes[0].epoch_utc = block.passes[1].epoch_utc;
  EXPECT_EQ(DoubtOfPlates(same_day), "");
  same_day.epoch_year = 2010.0;
  EXPECT_THAT(DoubtOfPlates(same_day), testing::HasSubstr("13 years apart"));
  same_day.points.known[0].velocity_mpy = {0.01, 0.02, 0.03};
  EXPECT_EQ(DoubtOfPlates(same_day), "");
  block.frame = Frame::Geocentric(NamedEllipsoid("Moon"));
  EXPECT_EQ(DoubtOfPlates(block), "");
}

TEST(RequireEpoch, WantsAYear) {
  EXPECT_EQ(RefusalOf([] { RequireEpoch(2022.79); }), "");
  EXPECT_EQ(RefusalOf([] { RequireEpoch(20221016.0); }),
            "epoch: must be a year like 2022.79, from 1980 to 2100, got 20221016");
}

}  // namespace
}  // namespace sarblock
