// SPDX-License-Identifier: Apache-2.0
// Blocks filled by hand with the mistakes of a beginner. Evidence: a table by hand of what each
// entry point must name; none is accepted, none crashes (as seen under the sanitizers).
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Twelve points, four passes, 48 looks; points 3 and 7 are control, 10 is a check point.
test::KnownBlock SoundBlock() {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  test::AddKnownPoint(3, {0.3, 0.3, 0.4}, &known);
  test::AddKnownPoint(7, {0.3, 0.3, 0.4}, &known);
  test::AddKnownPoint(10, {0.1, 0.1, 0.1}, &known, PointRole::kCheck);
  test::AddNoise(7, 1.0, &known);
  return known;
}

AdjustOptions FreePositions() {
  PositionCorrection position;
  position.prior_sigma_m = {std::vector<double>{3.0}, {3.0}, {3.0}};
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

/// Which entry points refuse a mistake: those that need measured values, or all.
enum class By { kAll, kMeasured, kAllButCheck };

struct Mistake {
  const char* name;   ///< of the test
  const char* named;  ///< array and index that a message names
  const char* says;   ///< what is allowed
  std::function<void(Block*)> make;
  By by = By::kAll;
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

std::vector<Mistake> Mistakes() {
  return {
      {"PassesTwice",
       "passes[2]",
       "one of its own",
       [](Block* b) { b->passes[2].id = b->passes[0].id; }},
      {"NoPath", "passes[1]", "no flight path", [](Block* b) { b->passes[1].path = FlightPath(); }},
      {"SpanReversed",
       "passes[3]",
       "start_s less than end_s",
       [](Block* b) { std::swap(b->passes[3].start_s, b->passes[3].end_s); }},
      {"SpanForgotten",
       "passes[0]",
       "SetStripSpans()",
       [](Block* b) { b->passes[0].start_s = b->passes[0].end_s = 0.0; }},
      {"SpanNotANumber",
       "passes[0]",
       "start_s less than end_s",
       [](Block* b) { b->passes[0].end_s = kNotGiven; }},
      {"NoSide", "passes[1]", "kLeft or kRight", [](Block* b) { b->passes[1].side = LookSide{0}; }},
      {"LocalCoordinatesInAGeocentricFrame",
       "pass A1",
       "geocentric coordinates",
       [](Block* b) { b->frame = Frame::Geocentric(NamedEllipsoid("WGS84")); },
       By::kAllButCheck},
      {"RoleOneShort",
       "points.role",
       "must have 12 entries",
       [](Block* b) { b->points.role.pop_back(); }},
      {"RolesEmpty",
       "points.role",
       "must have 12 entries",
       [](Block* b) { b->points.role.clear(); }},
      {"NoSuchRole",
       "points.role[5]",
       "kTie, kControl or kCheck",
       [](Block* b) { b->points.role[5] = static_cast<PointRole>(9); }},
      {"GivenPositionsEmpty",
       "points.given_m",
       "must have 12 entries",
       [](Block* b) { b->points.given_m.clear(); }},
      {"OffsetsEmpty", "looks.offsets", "13, got 0", [](Block* b) { b->looks.offsets.clear(); }},
      {"OffsetsOneShort",
       "looks.offsets",
       "13, got 12",
       [](Block* b) { b->looks.offsets.pop_back(); }},
      {"OffsetsFromOne",
       "looks.offsets[0]",
       "must be 0",
       [](Block* b) { b->looks.offsets[0] = 1; }},
      {"OffsetsDescend",
       "looks.offsets[6]",
       "SortLooksByPoint()",
       [](Block* b) { std::swap(b->looks.offsets[5], b->looks.offsets[6]); }},
      {"OffsetsBeyond",
       "looks.offsets[8]",
       "the number of looks, 48",
       [](Block* b) { b->looks.offsets[8] = 99; }},
      {"OffsetsTooFew",
       "looks.offsets[12]",
       "must be the number of looks, 48",
       [](Block* b) { b->looks.offsets[12] = 47; }},
      {"LooksNotSorted",
       "looks.pass[1]",
       "a second look of pass",
       [](Block* b) { std::stable_sort(b->looks.pass.begin(), b->looks.pass.end()); }},
      {"FlagsEmpty",
       "looks.flags",
       "must have 48 entries",
       [](Block* b) { b->looks.flags.clear(); }},
      {"TimesOneShort",
       "looks.time_s",
       "must have 48 entries",
       [](Block* b) { b->looks.time_s.pop_back(); }},
      {"RangesEmpty",
       "looks.range_m",
       "must have 48 entries",
       [](Block* b) { b->looks.range_m.clear(); }},
      {"ConeOneLong",
       "looks.cone",
       "48 entries, or none",
       [](Block* b) { b->looks.cone.assign(49, 0.0); }},
      {"RangeSigmasOneShort",
       "looks.range_sigma_m",
       "48 entries, or none",
       [](Block* b) { b->looks.range_sigma_m.assign(47, 0.5); }},
      {"AzimuthSigmasOneShort",
       "looks.azimuth_sigma",
       "48 entries, or none",
       [](Block* b) { b->looks.azimuth_sigma.assign(47, 0.5); }},
      {"PassBeyond", "looks.pass[5]", "must be below 4", [](Block* b) { b->looks.pass[5] = 99; }},
      {"NoSuchFlag", "looks.flags[9]", "Looks::Flag", [](Block* b) { b->looks.flags[9] = 64; }},
      {"TwoUnits",
       "looks.flags[9]",
       "exclude each other",
       [](Block* b) { b->looks.flags[9] = Looks::kAzimuthSeconds | Looks::kAzimuthHertz; }},
      {"SameLookTwice",
       "looks.pass[17]",
       "a second look of pass 'A1' at point 'P5'; one is allowed",
       [](Block* b) { b->looks.pass[17] = b->looks.pass[16]; }},
      {"RangeNegative",
       "looks.range_m[4]",
       "above 0",
       [](Block* b) { b->looks.range_m[4] = -1e4; }},
      {"RangeZero", "looks.range_m[4]", "above 0", [](Block* b) { b->looks.range_m[4] = 0.0; }},
      {"RangeInfinite",
       "looks.range_m[4]",
       "a number from 1e-60 to 1e60, got inf",
       [](Block* b) { b->looks.range_m[4] = kInfinity; }},
      {"TimeInfinite",
       "looks.time_s[4]",
       "finite",
       [](Block* b) { b->looks.time_s[4] = -kInfinity; }},
      {"RangeNotGiven",
       "looks.range_m[4]",
       "Predict()",
       [](Block* b) { b->looks.range_m[4] = kNotGiven; },
       By::kMeasured},
      {"TimeNotGiven",
       "looks.time_s[11]",
       "Predict()",
       [](Block* b) { b->looks.time_s[11] = kNotGiven; },
       By::kMeasured},
      {"SquintInDegrees",
       "looks.cone[2]",
       "[rad]",
       [](Block* b) {
         b->looks.cone.assign(48, 0.0);
         b->looks.cone[2] = 19.5;
       }},
      {"SquintNotANumber",
       "looks.cone[2]",
       "[rad]",
       [](Block* b) {
         b->looks.cone.assign(48, 0.0);
         b->looks.cone[2] = kNotGiven;
       }},
      {"DopplerWithoutWavelength",
       "looks.flags[2]",
       "wavelength_m of pass 'A3' must be a number above 0",
       [](Block* b) {
         b->looks.cone.assign(48, 0.0);
         b->looks.flags[2] = Looks::kDoppler;
         b->passes[2].wavelength_m = kNotGiven;
       }},
      {"DopplerWithoutCones",
       "looks.flags[2]",
       "looks.cone",
       [](Block* b) {
         b->looks.cone.clear();
         b->looks.flags[2] = Looks::kDoppler;
       }},
      {"RangeSigmaMissing",
       "looks.range_sigma_m[1]",
       "of its pass 'A2'",
       [](Block* b) { b->passes[1].sigma.range_m = kNotGiven; }},
      {"AzimuthSigmaZero",
       "looks.azimuth_sigma[1]",
       "above 0",
       [](Block* b) { b->passes[1].sigma.azimuth = 0.0; }},
      {"RangeSigmaNegative",
       "looks.range_sigma_m[6]",
       "above 0",
       [](Block* b) {
         b->looks.range_sigma_m.assign(48, 0.5);
         b->looks.range_sigma_m[6] = -0.5;
       }},
      {"HertzWithoutDoppler",
       "looks.azimuth_sigma[0]",
       "needs a Doppler",
       [](Block* b) { b->passes[0].sigma.azimuth_unit = AzimuthUnit::kHertz; }},
      {"KnownBeyond",
       "points.known[2]",
       "must be below 12",
       [](Block* b) { b->points.known[2].point = 12; }},
      {"KnownNotSorted",
       "points.known[1]",
       "sorted by point",
       [](Block* b) { std::swap(b->points.known[0], b->points.known[1]); }},
      {"KnownTwice",
       "points.known[1]",
       "each once",
       [](Block* b) { b->points.known[1].point = b->points.known[0].point; }},
      {"KnownTiePoint",
       "points.known[0]",
       "tie point",
       [](Block* b) { b->points.role[3] = PointRole::kTie; }},
      {"ControlUnknown",
       "points.role[5]",
       "without an entry in points.known",
       [](Block* b) { b->points.role[5] = PointRole::kControl; }},
      {"KnownPositionNotANumber",
       "points.given_m[7]",
       "must be finite",
       [](Block* b) { b->points.given_m[7].y() = kNotGiven; }},
      {"ControlWithoutVariance",
       "points.known[1]",
       "component 2",
       [](Block* b) { b->points.known[1].covariance_enu_m2(2, 2) = 0.0; }},
      {"CovarianceNotSymmetric",
       "points.known[0]",
       "symmetric",
       [](Block* b) { b->points.known[0].covariance_enu_m2(0, 1) = 0.01; }},
      {"CovarianceNotPositive",
       "points.known[0]",
       "positive definite",
       [](Block* b) {
         Eigen::Matrix3d& q = b->points.known[0].covariance_enu_m2;
         q(0, 1) = q(1, 0) = 0.1;
       }},
  };
}

class MistakeTest : public testing::TestWithParam<Mistake> {};

TEST_P(MistakeTest, IsNamed) {
  const Mistake& mistake = GetParam();
  test::KnownBlock known = SoundBlock();
  mistake.make(&known.block);
  const Block& block = known.block;
  const auto refuses = [&](const char* by, auto call) {
    try {
      call();
      ADD_FAILURE() << by << " accepts it";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(mistake.named)) << by;
      EXPECT_THAT(error.what(), HasSubstr(mistake.says)) << by;
    }
  };
  const AdjustOptions options = FreePositions();
  refuses("Adjust", [&] { (void)Adjust(block, options); });
  refuses("Adjust in place", [&] {
    Block copy = block;
    (void)Adjust(&copy, options);
  });
  refuses("IntersectBlock", [&] { (void)IntersectBlock(block, options); });
  if (mistake.by == By::kMeasured) return;
  refuses("Predict", [&] { (void)Predict(block, options, known.truth_m); });
  if (mistake.by == By::kAllButCheck) return;
  refuses("CheckBlock", [&] { (void)CheckBlock(block, options); });
}

INSTANTIATE_TEST_SUITE_P(Blocks,
                         MistakeTest,
                         testing::ValuesIn(Mistakes()),
                         [](const auto& mistake) { return mistake.param.name; });

TEST(MistakeTest, LeavesASoundBlockAlone) {
  const test::KnownBlock known = SoundBlock();
  EXPECT_NO_THROW(Validate(known.block));
  EXPECT_TRUE(Adjust(known.block, FreePositions()).usable());
}

TEST(MistakeTest, LeavesValuesOfRejectedLooksAlone) {
  test::KnownBlock known = SoundBlock();
  known.block.looks.flags[4] = Looks::kRejected;
  known.block.looks.range_m[4] = -1.0;
  known.block.looks.time_s[4] = kNotGiven;
  EXPECT_NO_THROW(Validate(known.block));
}

TEST(MistakeTest, NamesPairsThatThereAreNot) {
  const test::KnownBlock known = SoundBlock();
  AdjustOptions options = FreePositions();
  options.pairs = PairChoice::kList;
  const auto refuses = [&](const PointPairs& pairs) {
    for (const bool predict : {false, true}) {
      try {
        (void)(predict ? Predict(known.block, options, known.truth_m, pairs)
                       : Adjust(known.block, options, pairs));
        ADD_FAILURE() << "accepted";
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("pairs[1]: must be two points below 12"));
      }
    }
  };
  refuses({{0, 5}, {3, 3}});
  refuses({{0, 5}, {0, 9999}});
  EXPECT_EQ(Adjust(known.block, options, {{0, 5}, {8, 2}}).pairs.size(), 2U);
}

// Two routes: looks left at their default, and an empty list for each point.
TEST(MistakeTest, PredictTakesABlockWithoutLooks) {
  test::KnownBlock known = SoundBlock();
  known.block.looks = {};
  const AdjustResult predicted = Predict(known.block, FreePositions(), known.truth_m);
  known.block.looks.offsets.assign(13, 0);
  const AdjustResult expected = Predict(known.block, FreePositions(), known.truth_m);
  ASSERT_EQ(predicted.points.covariance_m2.size(), 12U);
  EXPECT_EQ(predicted.looks_used, expected.looks_used);
  EXPECT_GT(predicted.looks_used, 36U);
  for (std::size_t j = 0; j < 12; ++j) {
    EXPECT_EQ(predicted.points.covariance_m2[j], expected.points.covariance_m2[j]);
  }
}

TEST(MistakeTest, NamesPositionsOfTheWrongNumber) {
  test::KnownBlock known = SoundBlock();
  std::vector<Eigen::Vector3d> positions_m = known.truth_m;
  positions_m.pop_back();
  EXPECT_THROW((void)FillMeasurements(known.block, positions_m), InputError);
  positions_m.resize(13, Eigen::Vector3d::Zero());
  EXPECT_THROW((void)Predict(known.block, FreePositions(), positions_m), InputError);
}

}  // namespace
}  // namespace sarblock
