// SPDX-License-Identifier: Apache-2.0
// Invariance: an adjustment by ranks, here threads, is that of one process to the last byte of
// every table. They take every decision themselves: one that differed would leave them waiting for
// each other.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/result.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "model/problem.h"
#include "normals/reduced_system.h"
#include "support/scene_blocks.h"
#include "support/thread_ranks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

struct DividedBlock : test::SceneBlock {
  DividedBlock(const std::string& name,
               const std::vector<std::string>& sets,
               const std::string& folder = "scenes")
      : DividedBlock(test::SimulatedSceneBlock(folder, name, sets)) {}
  explicit DividedBlock(test::SceneBlock made) : test::SceneBlock(std::move(made)) {
    options.threads = 2;
  }
};

/// Every table of a result by its name, written to a folder of its own.
std::map<std::string, std::string> TablesOf(const DividedBlock& made,
                                            const AdjustResult& result,
                                            const std::string& name) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / name;
  files::WriteResult(folder, made.block, made.options, result, {});
  std::map<std::string, std::string> tables;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") continue;  // times and memory
    std::ifstream stream(entry.path(), std::ios::binary);
    tables[entry.path().filename()] = {std::istreambuf_iterator<char>(stream), {}};
  }
  std::filesystem::remove_all(folder);
  return tables;
}

void ExpectTheSame(const DividedBlock& made,
                   const std::string& name,
                   const std::vector<int>& sizes = {2, 3}) {
  const AdjustResult alone = Adjust(made.block, made.options);
  const auto expected = TablesOf(made, alone, name + "_alone");
  EXPECT_GE(expected.size(), 5U);
  for (const int size : sizes) {
    test::RunRanks(size, [&](Ranks* ranks) {
      const AdjustResult result = Adjust(made.block, made.options);
      const std::string own = name + std::to_string(size) + "_" + std::to_string(ranks->rank());
      EXPECT_TRUE(TablesOf(made, result, own) == expected) << own;
      EXPECT_EQ(result.iterations, alone.iterations);
      EXPECT_EQ(result.final_cost, alone.final_cost);
      EXPECT_EQ(result.sigma0_squared, alone.sigma0_squared);
      EXPECT_EQ(result.warnings, alone.warnings);
      EXPECT_EQ(result.assessment.reasons, alone.assessment.reasons);
    });
  }
}

TEST(RanksAdjustTest, GiveTheSameTables) {
  ExpectTheSame(DividedBlock("block-12-strips", {"points.count=900"}), "strips");
}

/// A net of passes whose factor is divided as well; pairs, check points and variance components
/// solve on it.
DividedBlock Net() {
  return {
      "network",
      {"points.count=1500",
       "points.east_m=[500, 50500]",
       "points.north_m=[13500, 96500]",
       "flight.0.count=11",
       "flight.1.count=11",
       "flight.0.segments=10",
       "flight.1.segments=10",
       "check.count=5",
       "check.sigma_m=[1, 1, 1]",
       "adjust.diagnose=false",
       "adjust.pairs=\"neighbours\"",
       "adjust.variance_components=\"range-azimuth\"",
       "adjust.correction.position.degree=7",
       "adjust.correction.position.sigma_m=[[10, 5, 1, 1, 1, 1, 1, 1], [10, 5, 1, 1, 1, 1, 1, 1], "
       "[10, 5, 1, 1, 1, 1, 1, 1]]"},
      "benchmarks"};
}

TEST(RanksAdjustTest, GiveTheSameTablesWhereTheFactorIsDivided) {
  const DividedBlock net = Net();
  test::RunRanks(2, [&](Ranks*) {
    const AdjustmentProblem problem(net.block, net.options.groups);
    ReducedSystem system(problem);
    static_cast<void>(system.Needs(1));
    EXPECT_TRUE(system.factor().divided());
  });
  ExpectTheSame(net, "net", {3});
}

TEST(RanksAdjustTest, GiveTheSameTablesOfPointsInNoOrder) {
  ExpectTheSame(DividedBlock(test::NetInNoOrder({"adjust.pairs=\"neighbours\""})), "no_order");
}

TEST(RanksAdjustTest, ChooseTheSameCorrections) {
  ExpectTheSame(DividedBlock("earth-asc-desc", {"points.count=300", "adjust.corrections=\"auto\""}),
                "auto");
}

TEST(RanksAdjustTest, DropTheSameLooksUnderALoss) {
  DividedBlock made("block-12-strips",
                    {"points.count=400",
                     "adjust.robust=\"tukey\"",
                     "adjust.variance_components=\"range-azimuth\""});
  for (std::size_t i = 40; i < made.block.looks.size(); i += 97)
    made.block.looks.range_m[i] += 31.0;
  ExpectTheSame(made, "robust");
}

TEST(RanksAdjustTest, FindTheSameBlunders) {
  DividedBlock made("block-12-strips",
                    {"points.count=300", "adjust.quality.snooping=\"iterative\""});
  for (std::size_t i = 40; i < made.block.looks.size(); i += 211)
    made.block.looks.range_m[i] += 9.0;
  ExpectTheSame(made, "blunders");
}

/// A block without control floats: every rank says so in the same words.
TEST(RanksAdjustTest, RefuseWhatIsNotDeterminedInTheSameWords) {
  DividedBlock made("block-12-strips", {"points.count=300", "control.count=0"});
  for (CorrectionGroup& group : made.options.groups) {
    if (auto* position = std::get_if<PositionCorrection>(&group.model))
      position->prior_sigma_m = {};
  }
  std::string words;
  try {
    static_cast<void>(Adjust(made.block, made.options));
  } catch (const UndeterminedError& error) {
    words = error.what();
  }
  EXPECT_FALSE(words.empty());
  test::RunRanks(2, [&](Ranks* ranks) {
    Ending own;
    try {
      static_cast<void>(Adjust(made.block, made.options));
      ADD_FAILURE() << "it is determined";
    } catch (const UndeterminedError& error) {
      own = {4, error.what()};
    }
    EXPECT_EQ(own.words, words);
    EXPECT_EQ(ranks->Conclude(own).words, words);
  });
}

}  // namespace
}  // namespace sarblock
