// SPDX-License-Identifier: Apache-2.0
// [adjust.prior.NAME] and [navigation.prior.NAME]: what is read is what is written, and messages
// lead to the line.
#include "sarblock/core/error.h"
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

std::string PriorErrorOf(const std::string& text, const std::vector<std::string>& set = {}) {
  try {
    (void)Read(text, set);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
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

TEST(AdjustPriorsTest, RefusesWhatIsNoProcess) {
  const std::string walk = "process = \"random-walk\"\nsigma_m = 20\n";
  const std::string markov = "process = \"gauss-markov\"\nsigma_m = 20\n";
  EXPECT_THAT(PriorErrorOf(kSpline + walk), HasSubstr("start_sigma_m"));
  EXPECT_THAT(PriorErrorOf(kSpline + markov), HasSubstr("correlation_time_s"));
  EXPECT_THAT(PriorErrorOf(kSpline + "process = \"gauss-markov\"\n"),
              HasSubstr("block.toml:4: adjust.correction.position.process: needs sigma_m"));
  EXPECT_THAT(PriorErrorOf(kSpline + "start_sigma_m = 3\n"),
              HasSubstr("belongs to process = \"random-walk\""));
  EXPECT_THAT(PriorErrorOf(kSpline + "correlation_time_s = 3\n"),
              HasSubstr("belongs to process = \"gauss-markov\""));
  EXPECT_THAT(PriorErrorOf("[adjust.correction.position]\ndegree = 1\n" + walk),
              HasSubstr("basis = \"spline\" is needed"));
  // Several tables of a kind have numbers, not keys.
  const std::string shared =
      "[[adjust.correction.position]]\nshared = true\n[[adjust.correction.position]]\nbasis = "
      "\"spline\"\nknot_spacing_s = 20\ncorrelation_time_s = 9\n" +
      markov;
  EXPECT_EQ(PriorErrorOf(shared), "");
  EXPECT_THAT(PriorErrorOf("[adjust]\ncorrections = \"auto\"\n" + shared),
              HasSubstr("the process of 'position.2' stands beside corrections = \"auto\""));
}

TEST(AdjustPriorsTest, AKeyCanBeSet) {
  const AdjustOptions options = Read(
      kGroups + kPrior, {"prior.orbit.covariance=[[9, 1], [1, 2]]", "prior.orbit.passes=[\"A1\"]"});
  EXPECT_EQ(options.priors.at(0).Covariance()(0, 0), 9.0);
  EXPECT_EQ(options.priors.at(0).passes, std::vector<std::string>{"A1"});
}

TEST(AdjustPriorsTest, RefusesWithLineAndKey) {
  struct Bad {
    std::string text, message;
  };
  const std::string head = "[adjust.prior.p]\nparameters = [\"position.up.0\", \"range.bias\"]\n";
  const std::vector<Bad> cases = {
      {head + "covariance = [[1, 2], [2, 1]]\n",
       "block.toml:7: adjust.prior.p.covariance: is not positive definite"},
      {head + "covariance = [[1, 0.5], [0.25, 1]]\n",
       "block.toml:7: adjust.prior.p.covariance: is not symmetric"},
      {head + "covariance = [[1, 0.5], [0.5]]\n",
       "block.toml:7: adjust.prior.p.covariance[1]: the row has 1 entries"},
      {head + "covariance = [[1]]\n", "block.toml:7: adjust.prior.p.covariance: is 1 by 1"},
      {head, "adjust.prior.p.covariance: is not given"},
      {head + "sigma = [1, 0]\n",
       "block.toml:7: adjust.prior.p.sigma[1]: must be a number above 0, got 0"},
      {head + "sigma = [1]\n", "block.toml:7: adjust.prior.p.sigma: has 1 entries"},
      {head + "sigma = [1, 2]\ncorrelation = [[1, 1.5], [1.5, 1]]\n",
       "block.toml:8: adjust.prior.p.correlation: is not positive definite"},
      {head + "sigma = [1, 2]\ncovariance = [[1, 0], [0, 1]]\n", "excludes sigma and correlation"},
      {head + "axes = \"tracks\"\n", "block.toml:7: adjust.prior.p.axes: "},
      {head + "passes = [\"B8\"]\nsigma = [1, 2]\n",
       "block.toml:7: adjust.prior.p.passes[0]: no pass 'B8' in the block; did you mean"},
      {head + "sigmas = [1, 2]\n", "sigmas"},
      {"[adjust.prior.p]\nsigma = [1]\n", "adjust.prior.p.parameters: is missing"},
      {"[adjust.prior.p]\nparameters = [\"range.bais\"]\nsigma = [1]\n",
       "block.toml:6: adjust.prior.p.parameters[0]: pass 'A1' has no parameter 'range.bais'"},
      {"[adjust]\nprior = 3\n", "a table is needed"},
      {"[adjust.prior]\np = 3\n", "a table is needed"},
  };
  for (const Bad& bad : cases) {
    EXPECT_THAT(PriorErrorOf(kGroups + bad.text), HasSubstr(bad.message)) << bad.text;
  }
  EXPECT_THAT(PriorErrorOf("[adjust]\ncorrections = \"auto\"\n" + kGroups + kPrior),
              HasSubstr("chooses among corrections with priors that are independent"));
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

TEST(NavigationPriorsTest, AreReadAndRefusedWithTheirLine) {
  const std::string head = kScene + "[navigation.prior.orbit]\n";
  const Scene scene = files::ParseScene(
      head + "parameters = [\"position.x.1\", \"time.bias\"]\nsigma = [1, 0.5]\n", "s.toml");
  ASSERT_EQ(scene.navigation.joint.size(), 1U);
  EXPECT_EQ(scene.navigation.joint[0].name, "orbit");
  const auto error_of = [&](const std::string& rest) -> std::string {
    try {
      (void)files::ParseScene(head + rest, "s.toml");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(
      error_of("parameters = [\"velocity.up\"]\nsigma = [1]\n"),
      HasSubstr("s.toml:17: navigation.prior.orbit.parameters: 'velocity.up' cannot be drawn"));
  EXPECT_THAT(error_of("parameters = [\"position.up.3\"]\nsigma = [1]\n"),
              HasSubstr("cannot be drawn"));
  EXPECT_THAT(error_of("parameters = [\"time.bias\"]\nsigma = [1, 2]\n"),
              HasSubstr("s.toml:18: navigation.prior.orbit.sigma: has 2 entries"));
  EXPECT_THAT(error_of("passes = [\"B\"]\nparameters = [\"time.bias\"]\nsigma = [1]\n"),
              HasSubstr("navigation.prior.orbit.passes: no pass 'B' in the scene"));
}

}  // namespace
}  // namespace sarblock
