// SPDX-License-Identifier: Apache-2.0
// Blocks that cannot be determined, as scenes: the refusal or warning names what is concerned.
// Known by construction of each scene. And no warning on any good scene.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <string>
#include <vector>

#include "solve/start.h"
#include "solve/structure.h"
#include "support/scene_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using test::SceneBlock;

SceneBlock Defective(const std::string& name, const std::vector<std::string>& sets = {}) {
  return test::SimulatedSceneBlock("scenes/defective", name, sets);
}

/// What `check` says.
std::vector<std::string> Structure(const SceneBlock& made) {
  AdjustmentProblem problem(made.block, made.options.groups);
  const StartReport start = ComputeStartValues(&problem, nullptr);
  std::vector<std::string> texts;
  for (const Finding& finding : ExamineStructure(problem, start.state)) {
    texts.push_back(finding.text);
  }
  return texts;
}

struct Refusal {
  std::string text;
  std::vector<std::string> names;
};

Refusal RefusalOf(const SceneBlock& made) {
  try {
    const AdjustResult result = Adjust(made.block, made.options);
    ADD_FAILURE() << "adjusted, accepted " << result.usable();
  } catch (const UndeterminedError& error) {
    return {error.what(), error.names()};
  }
  return {};
}

/// Refused, and the refusal repeats what `check` says.
Refusal Refused(const std::string& scene, std::size_t findings) {
  const SceneBlock made = Defective(scene);
  Refusal refusal = RefusalOf(made);
  const std::vector<std::string> structure = Structure(made);
  EXPECT_EQ(structure.size(), findings) << testing::PrintToString(structure);
  for (const std::string& finding : structure) EXPECT_THAT(refusal.text, HasSubstr(finding));
  return refusal;
}

TEST(DefectiveSceneTest, NoControlFloatsInThreeTranslationsAndThreeRotations) {
  const Refusal refusal = Refused("no-control", 1);
  EXPECT_THAT(refusal.text, HasSubstr("nothing fixes the position of the block"));
  for (const char* axis : {"x", "y", "z"}) {
    EXPECT_THAT(refusal.text, HasSubstr(std::string("translation of the whole block in ") + axis));
    EXPECT_THAT(refusal.text, HasSubstr(std::string(" of the whole block about ") + axis));
  }
  EXPECT_THAT(refusal.text, Not(HasSubstr("scale of")));  // the ranges hold the size
  for (const char* parameter : {"along.0", "across.0", "up.0", "across.1", "up.1"}) {
    for (const char* pass : {"A1", "A2"}) {
      EXPECT_THAT(refusal.names, Contains(std::string(pass) + " position." + parameter));
    }
  }
}

TEST(DefectiveSceneTest, OnePointIsNamed) {
  const Refusal refusal = Refused("one-point", 4);
  EXPECT_THAT(refusal.text, HasSubstr("a single point (T1) connects A1, A2"));
  EXPECT_THAT(refusal.text,
              HasSubstr("too few points see pass A2: they give at most 1 equations for its 6"));
  EXPECT_EQ(refusal.names.size(), 12u);  // nothing of the two passes is known
}

TEST(DefectiveSceneTest, ControlOnOneLineLeavesTheTiltAboutIt) {
  const Refusal refusal = Refused("collinear-control", 1);
  EXPECT_THAT(refusal.text, HasSubstr("control on one line (C1, C2, C3, C4 and 1 more)"));
  EXPECT_THAT(refusal.text, HasSubstr("tilt of the whole block about x"));
  EXPECT_THAT(refusal.text, Not(HasSubstr("translation of")));
  EXPECT_THAT(refusal.names, Contains("A1 position.across.0"));
  EXPECT_THAT(refusal.names, Contains("A2 position.up.0"));
  EXPECT_THAT(refusal.names, Each(Not(HasSubstr("along"))));
}

TEST(DefectiveSceneTest, ControlBesideTheLineDeterminesTheTilt) {
  const SceneBlock made = Defective("collinear-control", {"control.layout=perimeter"});
  EXPECT_TRUE(Structure(made).empty());
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_TRUE(result.usable());
  EXPECT_TRUE(result.warnings.empty()) << testing::PrintToString(result.warnings);
}

TEST(DefectiveSceneTest, CoincidingCirclesNameEveryTiePoint) {
  for (const char* scene : {"single-flight-free", "zero-base"}) {
    const Refusal refusal = RefusalOf(Defective(scene));
    EXPECT_THAT(refusal.text, HasSubstr("zero base, or squinted stereo from a single flight line"));
    EXPECT_EQ(refusal.names.size(), 120u);
    EXPECT_THAT(refusal.names, Contains("T1"));
    EXPECT_THAT(refusal.names, Contains("T120"));
  }
}

TEST(DefectiveSceneTest, TimeAndAlongAreNamedByPass) {
  const Refusal refusal = Refused("time-and-along", 1);
  EXPECT_THAT(refusal.text, HasSubstr("time bias and along-track position of all passes"));
  EXPECT_THAT(refusal.names,
              testing::UnorderedElementsAre(
                  "A1 position.along.0", "A1 time.bias", "A2 position.along.0", "A2 time.bias"));
  // The two compensate each other: they move no point, so none is moved most.
  EXPECT_THAT(refusal.text, Not(HasSubstr("most at")));
}

TEST(DefectiveSceneTest, RangeAcrossAndUpAreOneThingOnANarrowSwath) {
  const Refusal refusal = RefusalOf(Defective("narrow-swath"));
  EXPECT_THAT(refusal.text, HasSubstr("on a swath of less than 5 degrees of look angle"));
  EXPECT_THAT(refusal.text, HasSubstr("not separable at one look angle"));
  EXPECT_THAT(refusal.names,
              testing::UnorderedElementsAre("A1 range.bias",
                                            "A1 position.across.0",
                                            "A1 position.up.0",
                                            "A2 range.bias",
                                            "A2 position.across.0",
                                            "A2 position.up.0"));
}

TEST(DefectiveSceneTest, AnIslandWithoutControlIsNamed) {
  const Refusal refusal = Refused("two-islands", 2);
  EXPECT_THAT(refusal.text, HasSubstr("2 components that no point connects: A1, A2 | B1, B2"));
  EXPECT_THAT(refusal.text, HasSubstr("nothing fixes the position of the component of B1, B2"));
  EXPECT_THAT(refusal.text, HasSubstr("translation of the component of B1, B2 in x"));
  EXPECT_THAT(refusal.names, Each(StartsWith("B")));
}

TEST(DefectiveSceneTest, APassOfOnePointIsNamed) {
  const Refusal refusal = Refused("pass-of-one-point", 1);
  EXPECT_THAT(refusal.text,
              HasSubstr("too few points see pass A3: they give at most 2 equations for its 6"));
  EXPECT_EQ(refusal.names.size(), 6u);
  EXPECT_THAT(refusal.names, Each(StartsWith("A3 position.")));
}

TEST(DefectiveSceneTest, AMirrorPointThatFitsAsWellIsNamed) {
  const Refusal refusal = RefusalOf(Defective("mirror-ambiguity"));
  EXPECT_THAT(refusal.text, HasSubstr("Two points satisfy the looks and their sides equally well"));
  EXPECT_EQ(refusal.names.size(), 60u);
}

TEST(DefectiveSceneTest, AMirrorPointWithStartCoordinatesIsWarnedOfByName) {
  SceneBlock made = Defective("mirror-ambiguity");
  const std::vector<Eigen::Vector3d>& truth_m = made.truth.points_m;
  for (std::size_t j = 0; j < truth_m.size(); ++j) {
    if (made.block.points.role[j] == PointRole::kTie) made.block.points.given_m[j] = truth_m[j];
  }
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_THAT(
      result.warnings,
      Contains(HasSubstr("T1, T2, T3, T4 and 56 more: a mirror point satisfies the looks")));
}

TEST(DefectiveSceneTest, OppositeSidesNearThePlaneOfBothAntennasTouch) {
  const SceneBlock made = Defective("opposite-side-mirror");
  const AdjustResult result = Adjust(made.block, made.options);
  const IdTable& ids = made.block.points.ids;
  std::vector<std::string> left_out;
  for (std::size_t j = 0; j < ids.size(); ++j) {
    if (result.points.status[j] != PointStatus::kUndetermined) continue;
    EXPECT_THAT(result.points.reason[j], HasSubstr("meet tangentially"));
    left_out.emplace_back(ids[j]);
  }
  ASSERT_GT(left_out.size(), 20u);
  EXPECT_THAT(result.warnings,
              Contains(HasSubstr("points are not determined and left out; " + left_out[0] + ", " +
                                 left_out[1])));
}

// A point with given coordinates fares as one without: left out by name, the rest adjusted.
TEST(OpenPointTest, GivenCoordinatesDoNotHideCirclesThatCoincide) {
  SceneBlock made = Defective("zero-base");
  const SceneBlock third =
      Defective("zero-base", {"flight.1.start_m=[0,8000]", "flight.1.swath_ground_m=[5000,17000]"});
  // Tie points of the first thirty keep their zero base, the others get a base of 8 km.
  Looks& looks = made.block.looks;
  made.block.passes.push_back(third.block.passes[1]);
  made.block.passes.back().id = "A3";
  ASSERT_EQ(made.block.points.size(), third.block.points.size());
  std::vector<std::string> wanted;
  for (std::size_t j = 0; j < made.block.points.size(); ++j) {
    made.block.points.given_m[j] = made.block.points.role[j] == PointRole::kTie
                                       ? Eigen::Vector3d(10e3, 19e3, 0.0)
                                       : made.block.points.given_m[j];
    if (made.block.points.role[j] != PointRole::kTie) continue;
    if (j < 34) {
      wanted.emplace_back(made.block.points.ids[j]);
      continue;
    }
    const std::uint64_t mine = looks.offsets[j] + 1, other = third.block.looks.offsets[j] + 1;
    looks.pass[mine] = 2;
    looks.time_s[mine] = third.block.looks.time_s[other];
    looks.range_m[mine] = third.block.looks.range_m[other];
  }
  const AdjustResult result = Adjust(made.block, made.options);
  std::vector<std::string> left_out;
  for (std::size_t j = 0; j < made.block.points.size(); ++j) {
    if (result.points.status[j] == PointStatus::kAdjusted) continue;
    EXPECT_EQ(result.points.status[j], PointStatus::kUndetermined);
    EXPECT_THAT(result.points.reason[j], HasSubstr("zero base"));
    left_out.emplace_back(made.block.points.ids[j]);
  }
  EXPECT_EQ(left_out, wanted);
  EXPECT_TRUE(result.usable());
}

std::vector<std::string> GoodScenes() {
  std::vector<std::string> names = test::SceneFiles();
  std::erase(names, "single-flight-squint");  // Leberl (1979), Fig. 5: no such stereo exists
  return names;
}

class GoodSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(GoodSceneTest, RaisesNoAlarm) {
  const SceneBlock made = test::SimulatedSceneBlock("scenes", GetParam(), {"points.count=200"});
  EXPECT_THAT(Structure(made), testing::IsEmpty());
  const AdjustResult result = Adjust(made.block, made.options);
  EXPECT_THAT(result.warnings, testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         GoodSceneTest,
                         testing::ValuesIn(GoodScenes()),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

}  // namespace
}  // namespace sarblock
