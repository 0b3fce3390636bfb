// SPDX-License-Identifier: Apache-2.0
// An independent code: the covariance of the whole adjustment by ceres::Covariance (sparse QR of
// all equations, no elimination of points) beside the reduced route, on every shipped scene.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "quality/covariance.h"
#include "support/scene_blocks.h"
#include <Eigen/Core>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::SceneBlock;

/// Both routes from one state: the solution does not depend on the covariance asked for.
AdjustResult Solved(const SceneBlock& made, CovarianceMethod method, const PointPairs& pairs) {
  AdjustOptions options = made.options;
  options.engine = Engine::kReduced;
  options.covariance_method = method;
  options.pairs = PairChoice::kList;
  return Adjust(made.block, options, pairs);
}

double Difference(const SymmetricEnu& a, const SymmetricEnu& b) {
  return (MatrixOf(a) - MatrixOf(b)).norm() / MatrixOf(b).norm();
}

class CeresCovarianceTest : public testing::TestWithParam<std::string> {};

// The equations of these scenes keep 1e-10 of a 3 x 3 in double precision, by either route.
TEST_P(CeresCovarianceTest, EqualsTheReducedRoute) {
  const SceneBlock made = test::SmallSceneBlock(GetParam());
  const PointPairs pairs = {{5, 17}, {40, 6}};
  if (GetParam() == "single-flight-squint") {
    EXPECT_THROW(static_cast<void>(Solved(made, CovarianceMethod::kCeres, pairs)),
                 UndeterminedError);
    return;
  }
  const AdjustResult reduced = Solved(made, CovarianceMethod::kReduced, pairs);
  const AdjustResult ceres = Solved(made, CovarianceMethod::kCeres, pairs);
  ASSERT_EQ(reduced.points.position_m.size(), ceres.points.covariance_m2.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < reduced.points.status.size(); ++i) {
    ASSERT_TRUE(IsSolved(reduced.points.status[i]));
    ASSERT_EQ(reduced.points.position_m[i], ceres.points.position_m[i]);
    largest = std::max(largest,
                       Difference(reduced.points.covariance_m2[i], ceres.points.covariance_m2[i]));
  }
  EXPECT_LT(largest, 1e-10);
  ASSERT_EQ(ceres.pairs.size(), pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_LT(Difference(reduced.pairs[k].covariance_m2, ceres.pairs[k].covariance_m2), 1e-10);
  }
  // Parameters: element by element, by their own sigmas.
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> expected;
  for (const ParameterCovariance& c : reduced.parameter_covariance) {
    expected[{c.a, c.b}] = c.covariance;
  }
  ASSERT_EQ(expected.size(), ceres.parameter_covariance.size());
  for (const ParameterCovariance& c : ceres.parameter_covariance) {
    const double scale = reduced.parameters[c.a].sigma * reduced.parameters[c.b].sigma;
    EXPECT_NEAR(c.covariance, expected.at({c.a, c.b}), 1e-9 * scale);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         CeresCovarianceTest,
                         testing::ValuesIn(test::SceneFiles()),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

TEST(CeresCovarianceLimitsTest, IsForTheBlockLevelOnly) {
  SceneBlock made = test::SmallSceneBlock("leberl-aircraft");
  made.options.covariance_method = CovarianceMethod::kCeres;
  made.options.covariance = CovarianceLevel::kIntersection;
  EXPECT_THROW(static_cast<void>(Adjust(made.block, made.options)), InputError);
}

TEST(CeresCovarianceLimitsTest, RefusesALargeBlockWithItsSize) {
  Block block = test::SmallSceneBlock("block-12-strips").block;
  // The same looks again and again under other names: 130 points become 3900.
  const Block once = block;
  for (int copy = 0; copy < 29; ++copy) {
    for (std::size_t j = 0; j < once.points.size(); ++j) {
      block.points.ids.Append(std::string(once.points.ids[j]) + "/" + std::to_string(copy));
      block.points.role.push_back(PointRole::kTie);
      block.points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
      for (auto i = once.looks.offsets[j]; i < once.looks.offsets[j + 1]; ++i) {
        block.looks.pass.push_back(once.looks.pass[i]);
        block.looks.flags.push_back(once.looks.flags[i]);
        block.looks.time_s.push_back(once.looks.time_s[i]);
        block.looks.range_m.push_back(once.looks.range_m[i]);
      }
      block.looks.offsets.push_back(block.looks.pass.size());
    }
  }
  AdjustOptions options;
  options.covariance_method = CovarianceMethod::kCeres;
  try {
    static_cast<void>(Adjust(block, options));
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("at most 10000 unknowns"));
  }
}

}  // namespace
}  // namespace sarblock
