// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "support/paper_block.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

std::size_t PassOf(const Block& block, const std::string& id) {
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    if (block.passes[pass].id == id) return pass;
  }
  ADD_FAILURE() << "no pass " << id;
  return 0;
}

/// Looks of tie points of a pass.
std::vector<std::size_t> TieLooks(const Block& block, std::size_t pass) {
  std::vector<std::size_t> out;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (block.points.role[point] != PointRole::kTie) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.pass[i] == pass) out.push_back(i);
    }
  }
  return out;
}

/// block-12-strips, most points seen by two or three strips; every third tie look of S4 is off by
/// `error_m` in range, `alternating` in sign.
test::SceneBlock StripsWithErrors(double error_m, bool alternating) {
  test::SceneBlock scene =
      test::SimulatedSceneBlock("scenes", "block-12-strips", {"points.count=600"});
  const std::vector<std::size_t> looks = TieLooks(scene.block, PassOf(scene.block, "S4"));
  for (std::size_t k = 0; k < looks.size(); k += 3) {
    scene.block.looks.range_m[looks[k]] += alternating && k % 2 == 1 ? -error_m : error_m;
  }
  return scene;
}

std::string AllOf(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += text + "\n";
  return out;
}

struct Way {
  const char* name;
  Snooping snooping;
  RobustLoss robust;
};

class MismatchesTest : public testing::TestWithParam<Way> {
 protected:
  static AdjustResult AdjustThisWay(test::SceneBlock scene) {
    scene.options.quality.snooping = GetParam().snooping;
    scene.options.robust = GetParam().robust;
    return Adjust(scene.block, scene.options);
  }
};

// The mistake is known: a third of the looks of S4 are 9 sigma too long. Points of three looks and
// more show it; those of two do not, and hold points that are off.
TEST_P(MismatchesTest, LooksThatAreOffAlikeAreNotAccepted) {
  const AdjustResult result = AdjustThisWay(StripsWithErrors(9.0, false));
  EXPECT_FALSE(result.usable());
  ASSERT_FALSE(result.assessment.reasons.empty());
  const std::string reason = result.assessment.reasons.front();
  EXPECT_EQ(reason.find("pass S4: "), 0U) << reason;
  EXPECT_NE(reason.find("off alike by "), std::string::npos) << reason;
  EXPECT_NE(reason.find(" m in range"), std::string::npos) << reason;
  EXPECT_EQ(reason.find("in azimuth"), std::string::npos) << reason;
  EXPECT_NE(reason.find("no other look would show"), std::string::npos) << reason;
}

// The same errors with both signs are scattered blunders.
TEST_P(MismatchesTest, ErrorsOfBothSignsAreNoMismatch) {
  const AdjustResult result = AdjustThisWay(StripsWithErrors(9.0, true));
  const std::string all = AllOf(result.assessment.reasons) + AllOf(result.warnings);
  EXPECT_EQ(all.find("off alike"), std::string::npos) << all;
}

TEST_P(MismatchesTest, AGoodBlockHasNone) {
  const AdjustResult result = AdjustThisWay(StripsWithErrors(0.0, false));
  EXPECT_TRUE(result.usable()) << AllOf(result.assessment.reasons);
  EXPECT_EQ(AllOf(result.warnings).find("off alike"), std::string::npos);
}

constexpr Way kWays[] = {{"iterative", Snooping::kIterative, RobustLoss::kNone},
                         {"robust", Snooping::kRobust, RobustLoss::kNone},
                         {"tukey", Snooping::kNone, RobustLoss::kTukey}};
INSTANTIATE_TEST_SUITE_P(Ways, MismatchesTest, testing::ValuesIn(kWays), [](const auto& at) {
  return std::string(at.param.name);
});

// Every point is seen by four passes: without the wrong looks each is checked, and the size of the
// error is that which was planted.
TEST(MismatchesOfManyLooksTest, AreLeftOutAsAWholeAndToldWithTheirSize) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 60;
  plan.looks_per_point = 0;
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddNoise(11, 1.0, &known);
  for (const std::size_t point : {0U, 12U, 24U, 36U, 48U}) {
    test::AddKnownPoint(point, {0.4, 0.4, 0.4}, &known);
  }
  Block& block = known.block;
  const std::vector<std::size_t> looks = TieLooks(block, 1);
  const double error_m = 30.0 * block.SigmaOf(looks[0]).range_m;
  // A raster of pixels of which the error has 50, and of lines of a fiftieth of a second.
  ImageGrid& image = block.passes[1].image.emplace();
  image.line_interval_s = 0.02;
  image.range_spacing_m = error_m / 50.0;
  std::size_t planted = 0;
  for (std::size_t k = 0; k < looks.size(); k += 4, ++planted) {
    block.looks.range_m[looks[k]] += error_m;
  }
  PositionCorrection position;
  position.prior_sigma_m.fill({3.0});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  options.quality.snooping = Snooping::kIterative;
  const AdjustResult result = Adjust(block, options);
  EXPECT_TRUE(result.usable()) << AllOf(result.assessment.reasons);
  const auto told = std::find_if(result.warnings.begin(), result.warnings.end(), [](auto& text) {
    return text.find("off alike by ") != std::string::npos;
  });
  ASSERT_NE(told, result.warnings.end()) << AllOf(result.warnings);
  EXPECT_NE(told->find(std::to_string(planted) + " of 60 looks"), std::string::npos) << *told;
  const std::string lead = "off alike by ";
  const double shift_m = std::stod(told->substr(told->find(lead) + lead.size()));
  // The mean of fourteen residuals, each with its own noise.
  EXPECT_NEAR(std::abs(shift_m), error_m, error_m / 30.0) << *told;
  const std::size_t pixels = told->find(" m in range (");
  ASSERT_NE(pixels, std::string::npos) << *told;
  EXPECT_NEAR(std::abs(std::stod(told->substr(pixels + 13))), 50.0, 50.0 / 30.0) << *told;
}

/// moon-alse, three looks per point on nearly parallel paths; a third of the tie looks of R3 are
/// `error_m` too long. Of every three looks each alone explains a contradiction of ranges.
test::SceneBlock ThreeLooksWithErrors(double error_m, std::vector<std::size_t>* shifted) {
  test::SceneBlock scene = test::SimulatedSceneBlock("scenes", "moon-alse", {"points.count=150"});
  const std::vector<std::size_t> looks = TieLooks(scene.block, PassOf(scene.block, "R3"));
  for (std::size_t k = 0; k < looks.size(); k += 3) {
    scene.block.looks.range_m[looks[k]] += error_m;
    shifted->push_back(looks[k]);
  }
  return scene;
}

class GroupOfLooksTest : public MismatchesTest {};

// The mistake is known. Common shifts of R1 and R2 explain each point as well, but not all of them
// by one size: the looks of R3 are left out, with few others, and their size is that planted.
TEST_P(GroupOfLooksTest, IsFoundInThePassThatItIsOf) {
  constexpr double kError_m = 79.3;
  std::vector<std::size_t> shifted;
  test::SceneBlock scene = ThreeLooksWithErrors(kError_m, &shifted);
  const Block& block = scene.block;
  const std::size_t pass = PassOf(block, "R3");
  const AdjustResult result = AdjustThisWay(scene);
  std::size_t found = 0, others = 0;
  ASSERT_EQ(result.looks.reason.size(), block.looks.size());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const RejectReason reason = result.looks.reason[i];
    if (reason != RejectReason::kBlunder && reason != RejectReason::kSuspect) continue;
    const bool planted = std::find(shifted.begin(), shifted.end(), i) != shifted.end();
    EXPECT_EQ(block.looks.pass[i], pass);
    ++(planted ? found : others);
  }
  // Of the error of a range 0.04 shows, four standard deviations: a look in ten is judged wrongly.
  EXPECT_GT(found, (3 * shifted.size()) / 4);
  EXPECT_LT(others, shifted.size() / 4);
  EXPECT_FALSE(result.usable());  // for the same reason
  ASSERT_FALSE(result.assessment.reasons.empty());
  const std::string reason = result.assessment.reasons.front();
  EXPECT_EQ(reason.find("pass R3: "), 0U) << reason;
  EXPECT_NE(reason.find("which no shift of another pass explains as well"), std::string::npos);
  const std::string lead = "off alike by ";
  ASSERT_NE(reason.find(lead), std::string::npos) << reason;
  // Thirty residuals, each with five times the noise of its look of 4 m.
  EXPECT_NEAR(
      -std::stod(reason.substr(reason.find(lead) + lead.size())), kError_m, 5.0 * 5.0 * 4.0 / 5.5);
}

// Looks of both signs are no group of any pass.
TEST_P(GroupOfLooksTest, IsNoneWhereErrorsAreScattered) {
  std::vector<std::size_t> shifted;
  test::SceneBlock scene = ThreeLooksWithErrors(79.3, &shifted);
  for (std::size_t k = 0; k < shifted.size(); k += 2) {
    scene.block.looks.range_m[shifted[k]] -= 2.0 * 79.3;
  }
  const AdjustResult result = AdjustThisWay(scene);
  const std::string all = AllOf(result.assessment.reasons) + AllOf(result.warnings);
  EXPECT_EQ(all.find("no shift of another pass"), std::string::npos) << all;
}

INSTANTIATE_TEST_SUITE_P(Ways, GroupOfLooksTest, testing::ValuesIn(kWays), [](const auto& at) {
  return std::string(at.param.name);
});

}  // namespace
}  // namespace sarblock
