// SPDX-License-Identifier: Apache-2.0
#include "sarblock/diagnose/diagnose.h"

#include "block/plausibility.h"
#include "diagnose/plants_edit.h"
#include "diagnose/trial_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using ::testing::HasSubstr;

Block SceneBlock() { return test::MakeTrialBlock("moon-alse", 1).block; }

TEST(FindCopiesTest, FindsNoneInAScene) { EXPECT_FALSE(FindCopies(SceneBlock()).any()); }

TEST(FindCopiesTest, NamesAPassThatIsACopyAndCountsItOnce) {
  Block block = SceneBlock();
  test::AppendPassCopy(1, &block);
  const auto copy = static_cast<std::uint32_t>(block.passes.size() - 1);
  const Copies copies = FindCopies(block);
  EXPECT_EQ(copies.passes, std::vector<std::uint32_t>{copy});
  ASSERT_EQ(copies.remarks.size(), 1U);
  EXPECT_THAT(copies.remarks[0], HasSubstr("pass COPY: "));
  CountOnce(copies, &block);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    EXPECT_EQ(block.looks.rejected(i), block.looks.pass[i] == copy);
  }
}

// The copy has no look of its own then, and nothing holds its corrections.
TEST(FindCopiesTest, DiagnosisSaysNothingElseOfAGoodBlockWithACopy) {
  Block block = test::MakeTrialBlock("leberl-aircraft", 1).block;
  test::AppendPassCopy(1, &block);
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", PositionCorrection{}, {}, false}};
  const Diagnosis diagnosis = Diagnose(block, options);
  EXPECT_FALSE(diagnosis.contradicts);
  EXPECT_THAT(diagnosis.remarks, testing::ElementsAre(HasSubstr("pass COPY: ")));
}

TEST(FindCopiesTest, FindsLooksThatAreEqualButForRounding) {
  Block block = SceneBlock();
  test::AppendPassCopy(1, &block);
  const LookSigma sigma = block.SigmaOf(0);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.passes[block.looks.pass[i]].id == "COPY") {
      block.looks.range_m[i] += 5e-4 * sigma.range_m;
    }
  }
  EXPECT_TRUE(FindCopies(block).any());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.passes[block.looks.pass[i]].id == "COPY") {
      block.looks.range_m[i] += 2e-3 * sigma.range_m;
    }
  }
  EXPECT_FALSE(FindCopies(block).any());
}

TEST(FindCopiesTest, DistinguishesMeasuredDopplersOfOneTime) {
  Block block = SceneBlock();
  for (Pass& pass : block.passes) {
    pass.wavelength_m = 0.24;
    pass.sigma = {pass.sigma.range_m, 1.7, AzimuthUnit::kHertz};
  }
  Looks& looks = block.looks;
  looks.cone.resize(looks.size());
  looks.azimuth_sigma.clear();
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    for (std::size_t i = looks.offsets[j]; i < looks.offsets[j + 1]; ++i) {
      looks.flags[i] |= Looks::kDoppler;
      looks.time_s[i] = 31.7;
      looks.range_m[i] = 147000.0 + static_cast<double>(j % 3);
      looks.cone[i] = 10.0 * static_cast<double>(j) + 3.0 * looks.pass[i];
    }
  }
  EXPECT_FALSE(FindCopies(block).any());
  test::AppendPointCopy(block.points.ids.Find("T17"), &block);
  const Copies copies = FindCopies(block);
  ASSERT_EQ(copies.remarks.size(), 1U);
  EXPECT_THAT(copies.remarks[0], HasSubstr("T17 and copy"));
}

TEST(FindCopiesTest, NamesAPointUnderTwoIds) {
  Block block = SceneBlock();
  const std::uint32_t point = block.points.ids.Find("T17");
  ASSERT_NE(point, IdTable::kNone);
  test::AppendPointCopy(point, &block);
  const Copies copies = FindCopies(block);
  ASSERT_EQ(copies.remarks.size(), 1U);
  EXPECT_THAT(copies.remarks[0], HasSubstr("T17 and copy"));
}

}  // namespace
}  // namespace sarblock
