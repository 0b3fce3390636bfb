// SPDX-License-Identifier: Apache-2.0
// [adjust.prior.NAME] and [navigation.prior.NAME]: what is read is what is written.
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"

#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kIds{"A1", "B7"};

const std::string kGroups =
    "[adjust.correction.position]\ndegree = 0\n[adjust.correction.range]\nbias = true\n";
const std::string kPrior =
    "[adjust.prior.orbit]\npasses = [\"B7\"]\n"
    "parameters = [\"position.up.0\", \"range.bias\"]\n"
    "covariance = [[4.75, -1.25], [-1.25, 0.5]]\n";

AdjustOptions Read(const std::string& text, const std::vector<std::string>& set = {}) {
  return files::ReadAdjustTable(text, "block.toml", kIds, set);
}

TEST(AdjustPriorsTest, ReadsAMatrixAndWritesItBack) {
  const AdjustOptions options = Read(kGroups + kPrior);
  ASSERT_EQ(options.priors.size(), 1U);
  const JointPrior& prior = options.priors[0];
  EXPECT_EQ(prior.name, "orbit");
  EXPECT_EQ(prior.passes, std::vector<std::string>{"B7"});
  EXPECT_EQ(prior.parameters, (std::vector<std::string>{"position.up.0", "range.bias"}));
  EXPECT_EQ(prior.Covariance()(0, 1), -1.25);
  EXPECT_EQ(prior.Covariance()(1, 1), 0.5);
  const std::string dump = files::DumpAdjustTable(options);
  EXPECT_THAT(dump, HasSubstr(kPrior));
  EXPECT_EQ(files::DumpAdjustTable(Read(dump)), dump);
}

TEST(AdjustPriorsTest, ReadsStandardDeviationsWithCorrelations) {
  const AdjustOptions options =
      Read(kGroups +
           "[adjust.prior.\"a b\"]\nparameters = [\"position.up.0\", \"range.bias\"]\n"
           "sigma = [2.5, 0.5]\ncorrelation = [[1, 0.25], [0.25, 1]]\n");
  EXPECT_EQ(options.priors.at(0).Covariance()(0, 0), 6.25);
  EXPECT_EQ(options.priors.at(0).Covariance()(0, 1), 0.3125);
  const std::string dump = files::DumpAdjustTable(options);
  EXPECT_THAT(dump, HasSubstr("[adjust.prior.\"a b\"]\n"));
  EXPECT_EQ(files::DumpAdjustTable(Read(dump)), dump);
}

const std::string kSpline =
    "[adjust.correction.position]\nbasis = \"spline\"\nknot_spacing_s = 20\n";

TEST(AdjustPriorsTest, ReadsAProcessAndWritesItBack) {
  for (const std::string process :
       {"process = \"random-walk\"\nsigma_m = [20, \"none\", 15]\nstart_sigma_m = [5, 4, 3]\n",
        "process = \"random-walk\"\ncomponents = [\"up\"]\nsigma_m = 20\nstart_sigma_m = 5\n",
        "process = \"gauss-markov\"\nsigma_m = 20\ncorrelation_time_s = 90\n"}) {
    const AdjustOptions options = Read(kSpline + process);
    const auto& position = std::get<PositionCorrection>(options.groups.at(0).model);
    const bool walk = position.process == PositionCorrection::Process::kRandomWalk;
    EXPECT_EQ(walk, process.find("walk") != std::string::npos);
    if (walk) {
      EXPECT_EQ(position.start_sigma_m[2], position.components[0] ? 3.0 : 5.0);
    } else {
      EXPECT_EQ(position.correlation_time_s, 90.0);
    }
    const std::string dump = files::DumpAdjustTable(options);
    EXPECT_THAT(dump, HasSubstr(walk ? "random-walk" : "gauss-markov"));
    EXPECT_EQ(files::DumpAdjustTable(Read(dump)), dump);
  }
}

TEST(AdjustPriorsTest, AKeyCanBeSet) {
  const AdjustOptions options = Read(
      kGroups + kPrior, {"prior.orbit.covariance=[[9, 1], [1, 2]]", "prior.orbit.passes=[\"A1\"]"});
  EXPECT_EQ(options.priors.at(0).Covariance()(0, 0), 9.0);
  EXPECT_EQ(options.priors.at(0).passes, std::vector<std::string>{"A1"});
}

const std::string kScene = R"(format = "sarblock-scene 1"
name = "joint"
[[flight]]
id = "A"
swath_ground_m = [1000, 9000]
height_m = 5000
length_m = 6000
speed_mps = 90
heading_deg = 90
[looks]
range_sigma_m = 0.5
azimuth_sigma_m = 0.5
[points]
east_m = [0, 6000]
north_m = [1000, 9000]
)";

TEST(NavigationPriorsTest, AreRead) {
  const std::string head = kScene + "[navigation.prior.orbit]\n";
  const Scene scene = files::ParseScene(
      head + "parameters = [\"position.x.1\", \"time.bias\"]\nsigma = [1, 0.5]\n", "s.toml");
  ASSERT_EQ(scene.navigation.joint.size(), 1U);
  const JointPrior& prior = scene.navigation.joint[0];
  EXPECT_EQ(prior.name, "orbit");
  EXPECT_EQ(prior.parameters, (std::vector<std::string>{"position.x.1", "time.bias"}));
  EXPECT_EQ(prior.Covariance(), Eigen::Matrix2d(Eigen::Vector2d(1.0, 0.25).asDiagonal()));
}

}  // namespace
}  // namespace sarblock
