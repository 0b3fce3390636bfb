// SPDX-License-Identifier: Apache-2.0
// What an adjustment is predicted to need against what is allocated, by count.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "adjust/adjust_given.h"
#include "core/threads.h"
#include "solve/rank.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Points seen by so many passes that follow one another, one held.
test::KnownBlock NeedyBlock(std::size_t passes, std::size_t points, std::size_t looks_per_point) {
  test::BlockPlan plan;
  plan.points = points;
  plan.looks_per_point = looks_per_point;
  plan.extent_m = 870.0;
  plan.relief_m = 130.0;
  plan.sigma.range_m = 0.7;
  plan.sigma.azimuth = 0.9;
  for (std::size_t i = 0; i < passes; ++i) {
    const auto at = static_cast<double>(i);
    plan.passes.push_back({i % 2 == 0 ? LookSide::kLeft : LookSide::kRight,
                           std::fmod(47.3 * at, 360.0),
                           7000.0 + 31.0 * at,
                           6100.0 + 17.0 * at});
  }
  test::KnownBlock known = test::MakeBlock(plan);
  for (const std::size_t point : {1U, 7U, 11U})
    test::AddKnownPoint(point, {0.31, 0.47, 0.59}, &known);
  test::AddNoise(7, 1.0, &known);
  return known;
}

AdjustOptions PositionsOfDegree(int degree) {
  PositionCorrection position;
  position.degree = degree;
  position.prior_sigma_m.fill(std::vector<double>(static_cast<std::size_t>(degree) + 1, 2.3));
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

template <typename... Vectors>
double FilledBytes(const Vectors&... vectors) {
  return (0.0 + ... + static_cast<double>(vectors.size() * sizeof(vectors[0])));
}

void ExpectWithinATenth(std::uint64_t predicted, double counted) {
  EXPECT_NEAR(static_cast<double>(predicted), counted, 0.1 * counted);
}

double BytesOfDoubles(std::size_t count) { return static_cast<double>(8 * count); }

struct BlockSize {
  std::size_t passes, points, looks;
  int degree;
};

class ResourceNeedsTest : public testing::TestWithParam<BlockSize> {};

// By count, within a tenth: S, its factor and fronts as they were taken, looks and points as the
// block, the problem and the result hold them.
TEST_P(ResourceNeedsTest, AreWithinATenthOfWhatIsAllocated) {
  const ThreadLimit one(1);
  const BlockSize size = GetParam();
  const test::KnownBlock known = NeedyBlock(size.passes, size.points, size.looks);
  const AdjustOptions options = PositionsOfDegree(size.degree);
  AdjustmentProblem problem(known.block, options.groups);
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(known.truth_m.size(), Eigen::Vector3d::Zero());
  state.corrections.setZero(problem.layout.size());
  UpdateWeights(state, &problem);
  ReducedSystem system(problem);
  const ResourceNeeds needs = PredictNeeds(problem, options, &system);

  system.Form(state, {}, nullptr);
  FactorRegular(&system);
  const CorrectionCovariance inverse = system.SelectedInverse();
  const FactorNeeds used = system.factor().Used();
  const double s = FilledBytes(system.matrix().sparse.values());
  ExpectWithinATenth(needs.matrix_bytes, 2.0 * s);
  ExpectWithinATenth(needs.factor_bytes, BytesOfDoubles(used.factor));
  ExpectWithinATenth(needs.fronts_bytes, BytesOfDoubles(used.waiting));
  const double inverse_bytes =
      FilledBytes(inverse.blocks.values()) + BytesOfDoubles(used.inverse_fronts);
  ExpectWithinATenth(needs.inverse_bytes, inverse_bytes);

  const AdjustResult result = Adjust(known.block, options);
  const Looks& looks = known.block.looks;
  const LookQuality& quality = result.quality;
  const double looks_bytes = FilledBytes(looks.offsets,
                                         looks.pass,
                                         looks.flags,
                                         looks.time_s,
                                         looks.range_m,
                                         looks.cone,
                                         looks.range_sigma_m,
                                         looks.azimuth_sigma,
                                         problem.look_used,
                                         problem.weights,
                                         result.looks.range_residual_m,
                                         result.looks.azimuth_residual_m,
                                         result.looks.weight,
                                         result.looks.rejected,
                                         result.looks.reason,
                                         quality.redundancy[0],
                                         quality.redundancy[1],
                                         quality.w[0],
                                         quality.w[1],
                                         quality.shift_m[0],
                                         quality.shift_m[1]);
  ExpectWithinATenth(needs.looks_bytes, looks_bytes);
  const PointResults& points = result.points;
  const double points_bytes = FilledBytes(known.block.points.role,
                                          known.block.points.given_m,
                                          problem.point_status,
                                          problem.point_reason,
                                          problem.mirrored,
                                          problem.control_of,
                                          state.start_m,
                                          state.displacement_m,
                                          points.status,
                                          points.reason,
                                          points.looks,
                                          points.position_m,
                                          points.covariance_m2,
                                          points.fixed_path_covariance_m2,
                                          points.intersection_rad,
                                          points.redundancy,
                                          points.sigma_leberl_across_m,
                                          points.sigma_leberl_up_m,
                                          points.sigma_leberl_path_across_m,
                                          points.sigma_leberl_path_up_m,
                                          points.leberl_across_azimuth_rad);
  ExpectWithinATenth(needs.points_bytes, points_bytes);
  EXPECT_EQ(static_cast<double>(needs.block_bytes),
            FilledBytes(looks.offsets,
                        looks.pass,
                        looks.flags,
                        looks.time_s,
                        looks.range_m,
                        looks.cone,
                        looks.range_sigma_m,
                        looks.azimuth_sigma,
                        known.block.points.role,
                        known.block.points.given_m));
}

INSTANTIATE_TEST_SUITE_P(Blocks,
                         ResourceNeedsTest,
                         testing::Values(BlockSize{6, 90, 4, 1},
                                         BlockSize{40, 700, 3, 1},
                                         BlockSize{30, 400, 5, 7}));

TEST(MemoryRefusalTest, AdjustRefusesWhatNeedsMoreThanIsAllowedAndSaysWhatHelps) {
  const test::KnownBlock known = NeedyBlock(30, 400, 5);
  AdjustOptions options = PositionsOfDegree(7);
  const ResourceNeeds needs = CheckBlock(known.block, options).needs;
  options.memory_mib = 0.9 * static_cast<double>(needs.peak_bytes) / (1 << 20);
  try {
    static_cast<void>(Adjust(known.block, options));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(DescribeNeeds(needs)));
    EXPECT_THAT(error.what(), HasSubstr(" MiB are allowed: memory "));
    EXPECT_THAT(error.what(),
                HasSubstr("; less is needed with fewer parameters per pass, with covariance = "
                          "\"none\" or for a part of the block; --memory sets another limit"));
  }
  const std::vector<std::string> findings = CheckBlock(known.block, options).findings;
  ASSERT_FALSE(findings.empty());
  EXPECT_THAT(findings.back(), HasSubstr("the adjustment needs "));
  options.memory_mib = 1.1 * static_cast<double>(needs.peak_bytes) / (1 << 20);
  EXPECT_TRUE(Adjust(known.block, options).usable());
}

TEST(MemoryRefusalTest, WithoutALimitThisComputersMemoryCounts) {
  ResourceNeeds needs;
  const AdjustOptions options;
  needs.peak_bytes = 1000000;
  EXPECT_THAT(ProblemOfMemory(needs, options), IsEmpty());
  needs.peak_bytes = std::uint64_t{1} << 60;  // more than any computer has
  EXPECT_THAT(ProblemOfMemory(needs, options),
              HasSubstr(" MiB more than the block as it was read, "));
  EXPECT_THAT(ProblemOfMemory(needs, options), HasSubstr(" MiB are free: memory "));
}

}  // namespace
}  // namespace sarblock
