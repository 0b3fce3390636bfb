// SPDX-License-Identifier: Apache-2.0
// Recorded flights in blocks: what is warned of, what "auto" takes, and how the keys are read and
// written.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "block/read_recorded.h"
#include "support/folder_test.h"
#include "support/scene_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using RecordedBlockTest = test::FolderTest;

/// The flight of a pass as a recorder gives it: states `spacing_s` apart with white noise.
std::vector<StateVector> Recorded(const FlightPath& path,
                                  double spacing_s,
                                  double sigma_m,
                                  double sigma_mps,
                                  std::uint64_t seed) {
  RandomStream random(815, seed);
  const auto count = static_cast<std::size_t>((path.end_s() - path.start_s()) / spacing_s);
  std::vector<StateVector> states;
  for (std::size_t k = 0; k <= count; ++k) {
    const double time_s = k == count ? path.end_s() : path.start_s() + spacing_s * double(k);
    const Motion motion = *path.At(time_s);
    const Eigen::Vector3d p(random.Normal(), random.Normal(), random.Normal());
    const Eigen::Vector3d v(random.Normal(), random.Normal(), random.Normal());
    states.push_back(
        {time_s, motion.position_m + sigma_m * p, motion.velocity_mps + sigma_mps * v});
  }
  return states;
}

Block RecordedStrips(double spacing_s, double sigma_m, double sigma_mps, PathThrough through) {
  Block block = test::SmallSceneBlock("block-12-strips").block;
  std::uint64_t seed = 0;
  for (Pass& pass : block.passes) {
    pass.path = FlightPath(Recorded(pass.path, spacing_s, sigma_m, sigma_mps, ++seed));
    pass.recorded.asked.through = through;
  }
  return block;
}

// Second route: the same block through its files.
TEST_F(RecordedBlockTest, PathsOfABlockInMemoryAreThoseOfItsFiles) {
  for (const PathThrough through : {PathThrough::kSmooth, PathThrough::kAuto}) {
    Block block = RecordedStrips(1.0, 0.02, 0.005, through);
    for (Pass& pass : block.passes) pass.recorded.asked.sigma = {0.02, 0.005};
    files::WriteBlock(folder_ / NameOf(through), block, AdjustOptions{});
    const files::BlockFile read = files::ReadBlock(folder_ / NameOf(through));
    const auto numbers = [](const std::vector<StateVector>& states) {
      std::vector<double> out;
      for (const StateVector& s : states) {
        out.push_back(s.time_s);
        out.insert(out.end(), s.position_m.begin(), s.position_m.end());
        out.insert(out.end(), s.velocity_mps.begin(), s.velocity_mps.end());
      }
      return out;
    };
    const std::vector<double> recorded = numbers(block.passes[0].path.states());
    static_cast<void>(MakePaths(&block));
    EXPECT_NE(numbers(block.passes[0].path.states()), recorded);
    EXPECT_EQ(numbers(block.passes[0].RecordedStates()), recorded);
    for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
      EXPECT_EQ(numbers(block.passes[pass].path.states()),
                numbers(read.block.passes[pass].path.states()))
          << pass;
    }
  }
}

/// A circular orbit 700 km high over a point that its one look sees.
Block OrbitBlock(double spacing_s, const Eigen::Vector3d& bias_mps = Eigen::Vector3d::Zero()) {
  constexpr double kRadius = 7078137.0, kRate = 1.0595e-3;
  Block block;
  block.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  std::vector<StateVector> states;
  for (int k = -12; k <= 12; ++k) {
    const double t_s = spacing_s * (k + 0.37), angle = kRate * t_s;
    states.push_back(
        {t_s,
         kRadius * Eigen::Vector3d(std::cos(angle), 0.0, std::sin(angle)),
         kRadius * kRate * Eigen::Vector3d(-std::sin(angle), 0.0, std::cos(angle)) + bias_mps});
  }
  Pass pass;
  pass.id = "A1";
  pass.path = FlightPath(std::move(states));
  pass.sigma = {1.0, 1.0, AzimuthUnit::kMetres};
  block.passes.push_back(std::move(pass));
  block.points.ids.FindOrAppend("P1");
  block.points.role = {PointRole::kTie};
  block.points.given_m = {Eigen::Vector3d(6.37e6, 4e5, 0.0)};
  block.looks.offsets = {0, 1};
  block.looks.pass = {0};
  block.looks.flags = {0};
  block.looks.time_s = {0.0};
  block.looks.range_m = {850e3};
  block.passes[0].start_s = -15.0;
  block.passes[0].end_s = 15.0;
  return block;
}

// ---- warnings

class IdealSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(IdealSceneTest, ShippedScenesDrawNoWarningAndAutoTakesTheirStates) {
  Block block = test::SmallSceneBlock(GetParam()).block;
  EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty());
  for (Pass& pass : block.passes) pass.recorded.asked.through = PathThrough::kAuto;
  EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty());
  for (const Pass& pass : block.passes) {
    EXPECT_EQ(pass.recorded.effect.through, PathThrough::kStates) << pass.recorded.effect.why;
    EXPECT_TRUE(pass.recorded.states.empty());
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes,
                         IdealSceneTest,
                         testing::ValuesIn(test::SceneFiles()),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

TEST(RecordedFlightTest, ACentimetreOfNoiseAtOneHertzIsWarnedOfWithItsRemedy) {
  Block block = RecordedStrips(1.0, 0.01, 0.0, PathThrough::kStates);
  const std::vector<std::string> warnings = ReadRecordedFlights(&block);
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_THAT(warnings[0],
              AllOf(HasSubstr("noise of states"),
                    HasSubstr("\"smooth\" in its"),
                    HasSubstr("in the same way: S1, S2, S3, S4, S5 and 8 more")));
  // R/v sqrt(12/5) sigma_p/h, R the largest range; noise estimated to a sixth.
  const Pass& pass = block.passes.front();
  double range_m = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.looks.pass[i] == 0) range_m = std::max(range_m, block.looks.range_m[i]);
  }
  const double expected_m =
      range_m / pass.path.states()[0].velocity_mps.norm() * std::sqrt(2.4) * 0.01;
  EXPECT_NEAR(pass.recorded.effect.noise_m, expected_m, 0.25 * expected_m);
}

TEST(RecordedFlightTest, StatesTooFarApartAreWarnedOf) {
  for (const double spacing_s : {60.0, 120.0, 300.0}) {
    Block block = OrbitBlock(spacing_s);
    EXPECT_THAT(ReadRecordedFlights(&block),
                testing::ElementsAre(AllOf(HasSubstr("pass A1: its recorded flight"),
                                           HasSubstr("\"orbit\" in its trajectory"))))
        << spacing_s;
  }
  Block dense = OrbitBlock(10.0);
  EXPECT_THAT(ReadRecordedFlights(&dense), IsEmpty());
}

TEST(RecordedFlightTest, VelocitiesThatContradictPositionsLeadToPositions) {
  Block block = OrbitBlock(10.0, {0.0, 0.02, 0.0});
  EXPECT_THAT(ReadRecordedFlights(&block),
              testing::ElementsAre(HasSubstr("\"positions\" in its trajectory")));
  block.passes[0].recorded.asked.through = PathThrough::kAuto;
  EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty());
  EXPECT_EQ(block.passes[0].recorded.effect.through, PathThrough::kPositions);
  EXPECT_THAT(block.passes[0].recorded.effect.why, HasSubstr("velocities that contradict"));
}

TEST(RecordedFlightTest, AutoReadsASparseOrbitByPolynomials) {
  for (const double spacing_s : {60.0, 120.0, 300.0}) {
    Block block = OrbitBlock(spacing_s);
    block.passes[0].recorded.asked.through = PathThrough::kAuto;
    EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty()) << spacing_s;
    EXPECT_EQ(block.passes[0].recorded.effect.through, PathThrough::kOrbit);
    EXPECT_LT(block.passes[0].recorded.effect.Total_m(), 0.1);
  }
}

TEST(RecordedFlightTest, AutoSmoothsNoisyStatesAndReadingAgainChangesNothing) {
  Block block = RecordedStrips(0.1, 0.02, 0.01, PathThrough::kAuto);
  EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty());
  for (const Pass& pass : block.passes) {
    EXPECT_EQ(pass.recorded.effect.through, PathThrough::kSmooth) << pass.recorded.effect.why;
    EXPECT_LT(pass.path.states().size(), pass.recorded.states.size());
  }
  const FlightPath first = block.passes[0].path;
  EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty());
  ASSERT_EQ(first.states().size(), block.passes[0].path.states().size());
  for (std::size_t k = 0; k < first.states().size(); ++k) {
    EXPECT_EQ(first.states()[k].position_m, block.passes[0].path.states()[k].position_m);
  }
  // And back to the states.
  block.passes[0].recorded.asked.through = PathThrough::kStates;
  static_cast<void>(ReadRecordedFlights(&block));
  EXPECT_TRUE(block.passes[0].recorded.states.empty());
}

TEST(RecordedFlightTest, StatesThatDoNotFitTheirSigmasAreNamedWithTheFactor) {
  Block block = RecordedStrips(0.1, 0.02, 0.01, PathThrough::kSmooth);
  block.passes[0].recorded.asked.sigma = {0.02, 0.01};
  block.passes[1].recorded.asked.sigma = {0.005, 0.01};
  block.passes[2].recorded.asked.sigma = {0.02, 0.04};
  const std::vector<std::string> warnings = ReadRecordedFlights(&block);
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_THAT(warnings[0],
              AllOf(HasSubstr("pass " + block.passes[1].id), HasSubstr("positions are off by 4")));
  EXPECT_THAT(warnings[1],
              AllOf(HasSubstr("pass " + block.passes[2].id),
                    HasSubstr("velocities are off by 0.25"),
                    HasSubstr("times what sigma_mps = 0.04 says")));
}

struct RecordedScene {
  const char* name;
  const char* cause;  ///< the part of the effect that its warning says most of
  PathThrough chosen;
};
void PrintTo(const RecordedScene& scene, std::ostream* out) { *out << scene.name; }

class RecordedSceneTest : public testing::TestWithParam<RecordedScene> {};

TEST_P(RecordedSceneTest, IsWarnedOfThroughItsStatesAndReadByAutoAsItsDataAsk) {
  Block block = test::SmallSceneBlock(std::string("recorded/") + GetParam().name).block;
  for (Pass& pass : block.passes) pass.recorded.asked.through = PathThrough::kStates;
  const std::vector<std::string> warnings = ReadRecordedFlights(&block);
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_THAT(warnings[0],
              AllOf(HasSubstr("read through = \"states\""),
                    HasSubstr(std::string("\"") + NameOf(GetParam().chosen) + "\" in its")));
  const RecordingEffect& states = block.passes[0].recorded.effect;
  const double largest_m =
      std::max({states.noise_m, states.contradiction_m, states.interpolation_m});
  EXPECT_EQ(GetParam().cause == std::string("noise"), states.noise_m == largest_m);
  EXPECT_EQ(GetParam().cause == std::string("contradiction"), states.contradiction_m == largest_m);
  for (Pass& pass : block.passes) pass.recorded.asked.through = PathThrough::kAuto;
  EXPECT_THAT(ReadRecordedFlights(&block), IsEmpty());
  for (const Pass& pass : block.passes) {
    const RecordingEffect& effect = pass.recorded.effect;
    EXPECT_EQ(effect.through, GetParam().chosen) << effect.why;
    EXPECT_FALSE(effect.Matters()) << effect.Total_m();
  }
}
INSTANTIATE_TEST_SUITE_P(
    Recorded,
    RecordedSceneTest,
    testing::Values(RecordedScene{"airborne-turbulent", "noise", PathThrough::kSmooth},
                    RecordedScene{"uav", "noise", PathThrough::kSmooth},
                    RecordedScene{"sparse-orbit", "interpolation", PathThrough::kOrbit},
                    RecordedScene{"downlink-orbit", "contradiction", PathThrough::kPositions}),
    [](const auto& scene) { return test::TestNameOf(scene.param.name); });

// 1 cm of noise at 1 Hz makes s0^2 nine where one is expected; smoothed, the block is as it was.
TEST(RecordedFlightTest, ABlockOfNoisyStatesIsSolvedAsWellAsTheIdealOneBySmoothing) {
  const test::SceneBlock ideal = test::SmallSceneBlock("block-12-strips");
  const double expected = Adjust(ideal.block, ideal.options).sigma0_squared;
  Block noisy = RecordedStrips(1.0, 0.01, 0.0, PathThrough::kStates);
  EXPECT_GT(Adjust(noisy, ideal.options).sigma0_squared, 4.0);
  for (Pass& pass : noisy.passes) pass.recorded.asked.through = PathThrough::kAuto;
  EXPECT_THAT(ReadRecordedFlights(&noisy), IsEmpty());
  const AdjustResult smooth = Adjust(noisy, ideal.options);
  EXPECT_NEAR(smooth.sigma0_squared, expected, 1e-3);
  // The corrected path stands at the times recorded.
  ASSERT_EQ(smooth.corrected_paths[0].states().size(), noisy.passes[0].recorded.states.size());
}

// ---- files

constexpr const char* kRecordedToml = R"(format = "sarblock-block 1"
[frame]
kind = "local"
[sigma]
range_m = 1.0
azimuth_m = 1.0
[trajectory]
through = "smooth"
sigma_m = 0.02
[[pass]]
id = "A1"
look = "left"
trajectory = { sigma_mps = 0.01 }
[[pass]]
id = "A2"
look = "left"
trajectory = { through = "positions" }
)";
constexpr const char* kRecordedStates = R"(pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps
A1,0,0,0,5000,100,0.1,0
A1,1,100,0.1,5000,100,0.2,0
A1,2,200,0.3,5000,100,0.1,0
A2,0,0,4000,5000,100,0,0
A2,1,100,4000.1,5000,100,0,0
A2,2,200,4000.1,5000,100,0,0
)";
constexpr const char* kTwoLooks =
    "pass,point,time_s,range_m\nA1,P1,0.5,9001.25\nA2,P1,0.75,7011.5\n";

TEST_F(RecordedBlockTest, KeysOfAPassOverrideThoseOfTheBlockAndAreWrittenBack) {
  const files::BlockFile read =
      files::ReadBlockTexts({kRecordedToml, kRecordedStates, kTwoLooks, std::nullopt});
  const auto expect_keys = [](const Block& block) {
    const RecordedFlight& a = block.passes[0].recorded;
    EXPECT_EQ(a.asked.through, PathThrough::kSmooth);
    EXPECT_EQ(a.asked.sigma.position_m, 0.02);
    EXPECT_EQ(a.asked.sigma.velocity_mps, 0.01);
    EXPECT_EQ(a.effect.through, PathThrough::kSmooth);
    const RecordedFlight& b = block.passes[1].recorded;
    EXPECT_EQ(b.asked.through, PathThrough::kPositions);
    EXPECT_EQ(b.asked.sigma.position_m, 0.02);
    EXPECT_TRUE(std::isnan(b.asked.sigma.velocity_mps));
    ASSERT_EQ(a.states.size(), 3U);
    EXPECT_EQ(a.states[1].position_m, Eigen::Vector3d(100.0, 0.1, 5000.0));
    EXPECT_EQ(a.states[1].velocity_mps, Eigen::Vector3d(100.0, 0.2, 0.0));
  };
  expect_keys(read.block);
  files::WriteBlock(folder_ / "again", read.block, read.adjust);
  const files::BlockFile again = files::ReadBlock(folder_ / "again");
  expect_keys(again.block);
  for (std::size_t i = 0; i < 2; ++i) {
    const FlightPath &a = read.block.passes[i].path, &b = again.block.passes[i].path;
    ASSERT_EQ(a.states().size(), b.states().size());
    for (std::size_t k = 0; k < a.states().size(); ++k) {
      EXPECT_EQ(a.states()[k].position_m, b.states()[k].position_m);
    }
  }
}

TEST_F(RecordedBlockTest, AnOverrideChangesTheWayOfPassesThatHaveNoneOfTheirOwn) {
  files::ReadOptions options;
  options.set_overrides = {"trajectory.through=auto"};
  const files::BlockFile read =
      files::ReadBlockTexts({kRecordedToml, kRecordedStates, kTwoLooks, std::nullopt}, options);
  EXPECT_EQ(read.block.passes[0].recorded.asked.through, PathThrough::kAuto);
  EXPECT_EQ(read.block.passes[1].recorded.asked.through, PathThrough::kPositions);
  EXPECT_THAT(read.block.passes[0].recorded.effect.why, HasSubstr("points along track"));
}

}  // namespace
}  // namespace sarblock
