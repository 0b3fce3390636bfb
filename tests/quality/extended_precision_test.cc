// SPDX-License-Identifier: Apache-2.0
// Digits of the covariance: the double route beside the same equations in 50 digits, over ever
// shorter bases and ever weaker datums.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "normals/reduced_system.h"
#include "quality/point_sweep.h"
#include "solve/rank.h"
#include "support/dense_normals.h"
#include "support/extended_covariance.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

struct ThinBlock {
  test::KnownBlock known;
  std::vector<CorrectionGroup> groups;
};

std::vector<CorrectionGroup> Drifts(double sigma_m) {
  PositionCorrection position;
  position.degree = 1;
  // In track axes, which swing with the path, a shift of the whole block would cost something.
  position.axes = PositionCorrection::Axes::kFrame;
  position.prior_sigma_m.fill({sigma_m});
  return {{"position", position, {}, false}};
}

/// Four passes of one side, neighbours a third of `base_over_height` apart, 24 points of which
/// every third is control to 5 cm: the intersection is thin, the datum firm.
ThinBlock ShortBase(bool orbit, double base_over_height) {
  test::BlockPlan plan = orbit ? test::OrbitPlan() : test::AircraftPlan();
  const test::PassPlan first = plan.passes[0];
  plan.passes.assign(4, first);
  for (std::size_t i = 0; i < 4; ++i) {
    plan.passes[i].ground_range_m +=
        first.height_m * base_over_height * static_cast<double>(i) / 3.0;
  }
  plan.points = 24;
  ThinBlock s{test::MakeBlock(plan), Drifts(3.7)};
  for (std::size_t point = 0; point < 24; point += 3) {
    test::AddKnownPoint(point, {0.05, 0.05, 0.05}, &s.known);
  }
  return s;
}

/// A free net held by the priors of its corrections alone.
ThinBlock WeakDatum(double sigma_m) {
  test::BlockPlan plan = test::AircraftPlan();
  plan.points = 24;
  return {test::MakeBlock(plan), Drifts(sigma_m)};
}

/// The double route at the truth of a scenario, every point solved.
struct Computed {
  double largest_error = 0.0;  ///< of a 3 x 3 against 50 digits, Frobenius
  double system_condition = 0.0;
  double jacobian_condition = 0.0;
};
Computed Compute(const ThinBlock& s) {
  AdjustmentProblem problem(s.known.block, s.groups);
  BlockState state;
  // Off the truth, as a start position and its displacement are in an adjustment.
  for (const Eigen::Vector3d& p_m : s.known.truth_m) {
    state.start_m.push_back(p_m + Eigen::Vector3d(311.7, -203.3, 97.1));
    state.displacement_m.emplace_back(-311.2, 203.9, -97.6);
  }
  state.corrections.setConstant(problem.layout.size(), 0.13);
  UpdateWeights(state, &problem);
  ReducedSystem system(problem);
  system.Form(state, {}, nullptr);
  EXPECT_TRUE(system.weak_points().empty());
  const double condition = FactorRegular(&system).condition;
  const CorrectionCovariance inverse = system.SelectedInverse();
  const auto points = SweepPoints(problem, state, &inverse, false, nullptr).covariance_m2;
  const test::ExtendedCovariance exact = test::CovarianceInFiftyDigits(problem, s.groups, state);
  Computed out;
  out.system_condition = condition;
  out.jacobian_condition = exact.condition;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const Eigen::Matrix3d computed =
        test::FrameFromEnu(s.known.block.frame, state.Position(j), points[j]);
    out.largest_error =
        std::max(out.largest_error, (computed - exact.points[j]).norm() / exact.points[j].norm());
  }
  return out;
}

void Record(const std::string& name, const Computed& c) {
  testing::Test::RecordProperty(name + ".error", std::to_string(std::log10(c.largest_error)));
  testing::Test::RecordProperty(name + ".kappa", std::to_string(std::log10(c.jacobian_condition)));
}

class ShortBaseTest : public testing::TestWithParam<bool> {};

// The same adjustment in extended precision. Aircraft: local coordinates of 1e4 m; orbit:
// geocentric ones of 7e6 m, whose rounding (1e-9 m) turns a sight line by 1e-15 rad, 1e-11 of the
// thinnest base here.
TEST_P(ShortBaseTest, CovariancesKeepNineDigits) {
  for (const double base_over_height : {1e-1, 1e-2, 1e-3, 1e-4}) {
    SCOPED_TRACE(base_over_height);
    const Computed c = Compute(ShortBase(GetParam(), base_over_height));
    Record("base" + std::to_string(base_over_height), c);
    EXPECT_LT(c.largest_error, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, ShortBaseTest, testing::Bool(), [](const auto& orbit) {
  return orbit.param ? "geocentric" : "local";
});

// Never a silent wrong number: as the datum weakens, either the covariance keeps the digits that
// its condition leaves, or the adjustment warns with the figure, or it refuses.
TEST(WeakDatumTest, IsAccurateOrSaysItsCondition) {
  bool warned = false, refused = false;
  for (const double sigma_m : {1e1, 1e3, 1e5, 3e5, 6e5, 1e6, 1.5e6, 2e6, 3e6, 5e6, 1e7}) {
    SCOPED_TRACE(sigma_m);
    const ThinBlock s = WeakDatum(sigma_m);
    AdjustOptions options;
    options.corrections = CorrectionChoice::kGiven;
    options.groups = s.groups;
    try {
      const AdjustResult result = Adjust(s.known.block, options);
      const Computed c = Compute(s);
      Record("sigma" + std::to_string(sigma_m), c);
      const std::string all = testing::PrintToString(result.warnings);
      if (c.system_condition > 1e12) {
        EXPECT_THAT(all, HasSubstr("nearly undetermined: "));
        warned = true;
      }
      // The square root of the matrix's condition is the Jacobian's.
      EXPECT_LT(c.largest_error, 1e-15 * c.system_condition + 1e-11);
      if (c.largest_error > 1e-6) {
        EXPECT_THAT(all, HasSubstr("eigenvalue"));  // the figure
      }
    } catch (const UndeterminedError& error) {
      EXPECT_THAT(error.what(), HasSubstr("move together"));
      refused = true;
    }
  }
  EXPECT_TRUE(warned);
  EXPECT_TRUE(refused);
}

}  // namespace
}  // namespace sarblock
