// SPDX-License-Identifier: Apache-2.0
// A real restituted orbit file; skipped where it is not beside the project.
#include "sarblock/geometry/path.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/recorded_states.h"
#include "geometry/smooth_path.h"
#include "products/image_table.h"
#include "support/folder_test.h"
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
  EXPECT_LT(LargestContradiction_mps(states_), 1e-3);
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

// Real data against themselves: states 60 and 120 s apart, read in three ways, beside those left
// out in the middle 400 s. The reported error of the cubic is its true error, and polynomials
// follow.
TEST_F(RealOrbitTest, StatesThinnedOutAreReadAsWellAsReported) {
  for (const std::size_t step : {6U, 12U}) {
    std::vector<StateVector> thin;
    for (std::size_t k = 0; k < states_.size(); k += step) thin.push_back(states_[k]);
    const double middle_s = 0.5 * states_.back().time_s;
    const TimeSpan strip_s{middle_s - 200.0, middle_s + 200.0};
    const Recording recording(thin, {}, strip_s);
    // The gravity field has waves that states 120 s apart show as noise of centimetres.
    EXPECT_LT(recording.noise().position_m, 0.05);
    EXPECT_LT(recording.contradiction_mps(), 1e-3);
    for (const PathThrough through :
         {PathThrough::kStates, PathThrough::kOrbit, PathThrough::kPositions}) {
      const RecordedPath read = recording.Read(through, 1e-9);
      double square = 0.0, count = 0.0;
      for (const StateVector& state : states_) {
        if (state.time_s < strip_s.first_s || state.time_s > strip_s.last_s) continue;
        const Eigen::Vector3d u = state.velocity_mps.normalized();
        const Eigen::Vector3d e = read.path.At(state.time_s)->velocity_mps - state.velocity_mps;
        square += (e - u * u.dot(e)).squaredNorm();
        count += 1.0;
      }
      const double error_mps = std::sqrt(square / count);
      const double reported_mps = read.errors.interpolation_mps;
      RecordProperty(std::string(NameOf(through)) + std::to_string(10 * step) + "_mps",
                     std::to_string(error_mps) + " reported " + std::to_string(reported_mps));
      if (through == PathThrough::kStates) {
        // States left out stand at sixths and twelfths of a piece: nearly the mean over it.
        EXPECT_NEAR(error_mps, reported_mps, 0.1 * reported_mps);
        EXPECT_GT(error_mps, 1e-2);
      } else {
        // To 1 mm at 850 km, but for positions 120 s apart.
        EXPECT_LT(error_mps, step == 6 ? 2e-5 : 2e-4) << NameOf(through);
        const double noise_mps = std::sqrt(2.0) * read.errors.noise.velocity_mps;
        EXPECT_LT(error_mps, 2.0 * std::hypot(reported_mps, noise_mps) + 2e-5) << NameOf(through);
      }
    }
  }
}

}  // namespace
}  // namespace sarblock
