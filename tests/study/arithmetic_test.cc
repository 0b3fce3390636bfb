// SPDX-License-Identifier: Apache-2.0
// The adjustment in other arithmetics. Evidence: two routes (the library's own solver and
// covariance) and higher precision (19 digits).
#include "studies/arithmetic.h"

#include "sarblock/adjust/adjust.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "solve/start.h"
#include "support/scene_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

struct Route {
  std::vector<Eigen::Vector3d> position_m;
  std::vector<SymmetricEnu> covariance_m2;
};

Route Solved(const test::SceneBlock& made, Arithmetic arithmetic, Elimination elimination) {
  AdjustmentProblem problem(made.block, made.options.groups);
  const BlockState start = ComputeStartValues(&problem, nullptr).state;
  ArithmeticSolution solution =
      SolveInArithmetic(arithmetic, elimination, start, &problem, nullptr);
  EXPECT_TRUE(solution.solved) << solution.problem;
  Route out;
  for (std::size_t i = 0; i < made.block.points.size(); ++i) {
    out.position_m.push_back(solution.state.Position(i));
  }
  out.covariance_m2 = std::move(solution.covariance_m2);
  return out;
}

/// Largest differences: of a coordinate in units of the standard deviation of the point, of an
/// element of a covariance in units of its trace.
struct Differences {
  double position_error = 0.0, covariance_error = 0.0;
};

Differences Compare(const Route& a, const Route& b) {
  Differences out;
  for (std::size_t i = 0; i < a.position_m.size(); ++i) {
    const SymmetricEnu& p = a.covariance_m2[i];
    const double trace_m2 = p[0] + p[1] + p[2];
    out.position_error = std::max(out.position_error,
                                  (a.position_m[i] - b.position_m[i]).norm() / std::sqrt(trace_m2));
    for (std::size_t k = 0; k < p.size(); ++k) {
      out.covariance_error =
          std::max(out.covariance_error, std::abs(p[k] - b.covariance_m2[i][k]) / trace_m2);
    }
  }
  return out;
}

class ArithmeticTest : public testing::TestWithParam<const char*> {
 protected:
  const test::SceneBlock made_ = test::SmallSceneBlock(GetParam());
};

TEST_P(ArithmeticTest, DoubleByQrIsWhatTheLibraryAnswers) {
  const AdjustResult library = Adjust(made_.block, made_.options);
  const Differences apart = Compare({library.points.position_m, library.points.covariance_m2},
                                    Solved(made_, Arithmetic::kDouble, Elimination::kQr));
  EXPECT_LT(apart.position_error, 1e-6);  // either may stop a step of 1e-6 sigmas early
  EXPECT_LT(apart.covariance_error, 1e-7);
}

TEST_P(ArithmeticTest, FewerDigitsAreFartherFromTheExtendedAnswer) {
  const Route extended = Solved(made_, Arithmetic::kExtended, Elimination::kQr);
  const auto apart = [&](Arithmetic arithmetic, Elimination elimination) {
    return Compare(extended, Solved(made_, arithmetic, elimination));
  };
  const Differences double_qr = apart(Arithmetic::kDouble, Elimination::kQr);
  const Differences double_normals = apart(Arithmetic::kDouble, Elimination::kNormals);
  const Differences single_qr = apart(Arithmetic::kSingle, Elimination::kQr);
  EXPECT_LT(double_qr.covariance_error, 1e-10);
  EXPECT_LT(double_normals.covariance_error, 1e-7);
  // 2^-24 is 6e-8; sums and the condition of the reduced matrix cost some digits of it.
  EXPECT_GT(single_qr.covariance_error, 1e-8);
  EXPECT_LT(single_qr.covariance_error, 1e-2);
  EXPECT_LT(single_qr.position_error, 0.1);
  EXPECT_GT(single_qr.position_error, double_qr.position_error);
  EXPECT_LT(double_normals.position_error, 1e-5);
  const Differences extended_normals = apart(Arithmetic::kExtended, Elimination::kNormals);
  EXPECT_LT(extended_normals.covariance_error, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         ArithmeticTest,
                         testing::Values("block-12-strips", "earth-asc-desc"),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

}  // namespace
}  // namespace sarblock
