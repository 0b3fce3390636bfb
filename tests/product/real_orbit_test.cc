// SPDX-License-Identifier: Apache-2.0
// A real restituted orbit file; skipped where it is not beside the project.
#include "sarblock/flight/resample.h"
#include "sarblock/product/sentinel1.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "io/io_fixture.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

class RealOrbitTest : public test::FolderTest {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = std::filesystem::path(SARBLOCK_SHARED_DATA) / "sentinel1";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename();
      if (!name.ends_with(".EOF")) continue;
      orbit_ = ParseOrbitFile(Content(entry.path()), name);
    }
    for (const OrbitState& state : orbit_.states) {
      const double time_s = SecondsBetween(orbit_.states.front().time, state.time);
      states_.push_back({time_s, state.position_m, state.velocity_mps});
    }
  }
  OrbitFile orbit_;
  std::vector<StateVector> states_;
};

// The counts and the span are those of the file's own header.
TEST_F(RealOrbitTest, IsReadWhole) {
  EXPECT_EQ(orbit_.mission, "Sentinel-1A");
  EXPECT_EQ(states_.size(), 1186u);
  EXPECT_EQ(UtcText(orbit_.states.front().time), "2023-08-23T12:31:39Z");
  EXPECT_EQ(states_.back().time_s, 11850.0);  // 10 s a state
  EXPECT_LT(VelocityContradiction_mps(states_), 1e-3);
}

// Real data against themselves: every second state left out and interpolated. With 20 s between
// states degree 7 is good to 1e-11 m, so what remains is the rounding of the file (1e-6 m) and
// what no polynomial follows: the small jumps of a dynamic orbit, below a millimetre.
TEST_F(RealOrbitTest, InterpolationGivesBackStatesLeftOut) {
  std::vector<StateVector> half;
  for (std::size_t k = 0; k < states_.size(); k += 2) half.push_back(states_[k]);
  const auto dense = ResampleOrbit(half, 10.0, OrbitThrough::kStates);
  ASSERT_EQ(dense.size(), states_.size() - 1);
  double position_m = 0.0, velocity_mps = 0.0;
  for (std::size_t k = 0; k < dense.size(); ++k) {
    ASSERT_DOUBLE_EQ(dense[k].time_s, states_[k].time_s);
    position_m = std::max(position_m, (dense[k].position_m - states_[k].position_m).norm());
    velocity_mps = std::max(velocity_mps, (dense[k].velocity_mps - states_[k].velocity_mps).norm());
  }
  RecordProperty("position_m", std::to_string(position_m));
  EXPECT_LT(position_m, 1e-3);
  EXPECT_LT(velocity_mps, 1e-4);
  EXPECT_GT(position_m, 1e-9);
}

}  // namespace
}  // namespace sarblock
