// SPDX-License-Identifier: Apache-2.0
// Flights as they are recorded: their states carry noise, so that the acceleration of the path
// jumps at every state.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <limits>
#include <string>
#include <vector>

#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

test::SceneBlock MakeStrips() {
  return test::SimulatedSceneBlock("benchmarks", "strips", {"points.count=600"});
}

/// The path of a pass as a recorder of `rate_hz` with noise of sigma_m in its positions gives it,
/// between two times (everywhere: the defaults).
FlightPath Recorded(const FlightPath& path,
                    double rate_hz,
                    double sigma_m,
                    std::uint64_t seed,
                    double begin_s = -std::numeric_limits<double>::infinity(),
                    double end_s = std::numeric_limits<double>::infinity()) {
  RandomStream random(4711, seed);
  std::vector<StateVector> states;
  const auto count = static_cast<std::size_t>((path.end_s() - path.start_s()) * rate_hz);
  for (std::size_t k = 0; k <= count; ++k) {
    const double time_s =
        k == count ? path.end_s() : path.start_s() + static_cast<double>(k) / rate_hz;
    const Motion motion = *path.At(time_s);
    const Eigen::Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    const bool noisy = time_s >= begin_s && time_s <= end_s;
    states.push_back(
        {time_s, motion.position_m + (noisy ? sigma_m : 0.0) * noise, motion.velocity_mps});
  }
  return FlightPath(std::move(states));
}

struct Recorder {
  const char* name;
  double rate_hz, sigma_m;
};

class NoisyStatesTest : public testing::TestWithParam<Recorder> {};

TEST_P(NoisyStatesTest, BothEnginesConvergeInADozenIterationsToOneSolution) {
  test::SceneBlock strips = MakeStrips();
  std::uint64_t seed = 0;
  for (Pass& pass : strips.block.passes) {
    pass.path = Recorded(pass.path, GetParam().rate_hz, GetParam().sigma_m, ++seed);
  }
  strips.options.engine = Engine::kReduced;
  const AdjustResult reduced = Adjust(strips.block, strips.options);
  strips.options.engine = Engine::kCeres;
  const AdjustResult ceres = Adjust(strips.block, strips.options);
  ASSERT_TRUE(reduced.usable() && ceres.usable());
  EXPECT_LE(reduced.iterations, 12);
  EXPECT_LE(ceres.iterations, 12);
  EXPECT_NEAR(reduced.final_cost, ceres.final_cost, 1e-9 * ceres.final_cost);
  for (std::size_t j = 0; j < strips.block.points.size(); ++j) {
    if (!IsSolved(reduced.points.status[j])) continue;
    EXPECT_LT(test::DistanceInSigmas(strips.block.frame,
                                     reduced.points.position_m[j],
                                     ceres.points.position_m[j],
                                     reduced.points.covariance_m2[j]),
              1e-6)
        << j;
  }
}

INSTANTIATE_TEST_SUITE_P(Recorders,
                         NoisyStatesTest,
                         testing::Values(Recorder{"TenthOfAMillimetre", 1.0, 1e-4},
                                         Recorder{"Millimetre", 1.0, 1e-3},
                                         Recorder{"MillimetreTenTimesASecond", 10.0, 1e-3}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(RoughPathTest, IsRefusedByItsNameWithARemedy) {
  test::SceneBlock strips = MakeStrips();
  Pass& pass = strips.block.passes[3];
  pass.path = Recorded(pass.path, 10.0, 0.01, 1);
  try {
    static_cast<void>(Adjust(strips.block, strips.options));
    FAIL() << "a path that turns its cone back between states was read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("pass " + pass.id));
    EXPECT_THAT(error.what(), testing::HasSubstr("smooth the states"));
  }
}

// Only what is read of a path counts: rough before its first look, it is as good as another.
TEST(RoughPathTest, CountsBetweenItsLooksOnly) {
  test::SceneBlock strips = MakeStrips();
  Pass& pass = strips.block.passes[3];
  const std::vector<StateVector>& states = pass.path.states();
  double first_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < strips.block.looks.size(); ++i) {
    if (strips.block.looks.pass[i] == 3) {
      first_s = std::min(first_s, strips.block.looks.time_s[i]);
    }
  }
  const AdjustResult smooth = Adjust(strips.block, strips.options);
  // The same flight from a hundred seconds earlier on.
  StateVector earlier = states.front();
  earlier.time_s -= 100.0;
  earlier.position_m -= 100.0 * earlier.velocity_mps;
  const FlightPath longer(std::vector<StateVector>{earlier, states.back()});
  pass.path = Recorded(longer, 10.0, 0.01, 1, earlier.time_s, first_s - 5.0);
  const AdjustResult rough = Adjust(strips.block, strips.options);
  ASSERT_TRUE(rough.usable());
  EXPECT_NEAR(rough.final_cost, smooth.final_cost, 1e-6 * smooth.final_cost);
}

}  // namespace
}  // namespace sarblock
