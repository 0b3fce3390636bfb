// SPDX-License-Identifier: Apache-2.0
// A point that hundreds of passes see stands in the border of the reduced matrix; eliminated like
// any other it would couple all of them. Both ways are the same adjustment.
#include "sarblock/adjust/adjust.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "normals/reduced_system.h"
#include "quality/covariance.h"
#include "quality/point_sweep.h"
#include "quality/variance_components.h"
#include "solve/rank.h"
#include "support/small_blocks.h"
#include "support/thread_ranks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr std::size_t kPasses = 540, kPoints = 24, kSeenByAll = 2;

enum class Flights { kAircraft, kOrbits };

/// Points 0 and 1 seen by all passes; the others, where they see three each, hold them together.
test::KnownBlock ManyPasses(Flights flights) {
  const bool orbit = flights == Flights::kOrbits;
  test::BlockPlan plan;
  plan.orbit = orbit;
  plan.points = kPoints;
  plan.extent_m = orbit ? 9000.0 : 900.0;
  plan.relief_m = orbit ? 1400.0 : 140.0;
  plan.sigma.range_m = 0.7;
  plan.sigma.azimuth = 0.9;
  for (std::size_t i = 0; i < kPasses; ++i) {
    const auto at = static_cast<double>(i);
    const double range_m = std::fmod(613.0 * at, 5000.0), height_m = std::fmod(197.0 * at, 2900.0);
    plan.passes.push_back({i % 2 == 0 ? LookSide::kLeft : LookSide::kRight,
                           std::fmod(47.3 * at, 360.0),
                           orbit ? 250e3 + 70.0 * range_m : 7000.0 + range_m,
                           orbit ? 600e3 + 60.0 * height_m : 6100.0 + height_m});
  }
  test::KnownBlock known = test::MakeBlock(plan);
  test::AddKnownPoint(3, {0.31, 0.47, 0.59}, &known);
  test::AddNoise(7, 1.0, &known);
  return known;
}

std::vector<CorrectionGroup> Positions() {
  PositionCorrection position;
  position.components = {true, false, false};
  position.prior_sigma_m = {{{2.1}, {}, {}}};
  return {{"position", position, {}, false}};
}

class BorderedPointsTest : public testing::TestWithParam<Flights> {
 protected:
  BorderedPointsTest() : known_(ManyPasses(GetParam())), problem_(known_.block, Positions()) {
    const Looks& looks = problem_.block.looks;
    for (std::size_t point = kSeenByAll; point < kPoints; ++point) {
      for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
        const std::size_t from = 23 * point;
        problem_.look_used[i] = looks.pass[i] >= from && looks.pass[i] < from + 3 ? 1 : 0;
      }
    }
    state_.start_m = known_.truth_m;
    state_.displacement_m.assign(known_.truth_m.size(), {0.7, -1.3, 0.9});
    state_.corrections.setConstant(problem_.layout.size(), 0.13);
    UpdateWeights(state_, &problem_);
    for (const ManyLooks many : {ManyLooks::kBorder, ManyLooks::kEliminate}) {
      auto& system = many == ManyLooks::kBorder ? border_ : eliminated_;
      system.emplace(problem_, KeptFactors::kMaxBytes, many);
      system->Form(state_, {}, nullptr);
      FactorRegular(&*system);
    }
  }
  test::KnownBlock known_;
  AdjustmentProblem problem_;
  BlockState state_;
  std::optional<ReducedSystem> border_, eliminated_;
};

TEST_P(BorderedPointsTest, OnlyPointsOfHundredsOfPassesAreBordered) {
  EXPECT_THAT(border_->bordered().points, testing::ElementsAre(0U, 1U));
  EXPECT_TRUE(eliminated_->bordered().points.empty());
  EXPECT_LT(border_->matrix().sparse.values().size(),
            eliminated_->matrix().sparse.values().size() / 100);
}

// Invariance: rows of the border are shared among ranks like all that points make.
TEST_P(BorderedPointsTest, StandInTheBorderOfEveryRank) {
  test::RunRanks(2, [&](Ranks*) {
    ReducedSystem system(problem_);
    system.Form(state_, {}, nullptr);
    EXPECT_TRUE(system.matrix().border == border_->matrix().border);
    EXPECT_GT(system.matrix().border.ToDense().norm(), 1.0);
  });
}

// Second route: the same points eliminated.
TEST_P(BorderedPointsTest, TakeTheSameStep) {
  const Eigen::VectorXd step = eliminated_->Step();
  EXPECT_GT(step.norm(), 0.1);
  EXPECT_LT((border_->Step() - step).norm(), 1e-11 * step.norm());
  EXPECT_NEAR(border_->NewtonDecrement(), eliminated_->NewtonDecrement(), 1e-10);
  EXPECT_NEAR(border_->cost(), eliminated_->cost(), 1e-12 * eliminated_->cost());
  const Eigen::MatrixXd s = eliminated_->matrix().ToDense();
  EXPECT_LT((border_->matrix().ToDense() - s).norm(), 1e-13 * s.norm());
  border_->Form(state_, {}, nullptr, 1e-3);
  eliminated_->Form(state_, {}, nullptr, 1e-3);
  ASSERT_TRUE(border_->FactorDamped());
  ASSERT_TRUE(eliminated_->FactorDamped());
  EXPECT_LT((border_->Step() - eliminated_->Step()).norm(), 1e-11 * step.norm());
}

TEST_P(BorderedPointsTest, HaveTheSameCovariancesAndQualityFigures) {
  const CorrectionCovariance bordered = border_->SelectedInverse();
  const CorrectionCovariance full = eliminated_->SelectedInverse();
  const PointSweep a = SweepPoints(problem_, state_, &bordered, true, nullptr, border_->kept());
  const PointSweep b = SweepPoints(problem_, state_, &full, true, nullptr);
  for (std::size_t point = 0; point < kPoints; ++point) {
    for (std::size_t k = 0; k < 6; ++k) {
      const double size = std::abs(b.covariance_m2[point][0]);
      EXPECT_NEAR(a.covariance_m2[point][k], b.covariance_m2[point][k], 1e-10 * size) << point;
    }
    EXPECT_NEAR(a.redundancy[point], b.redundancy[point], 1e-8) << point;
  }
  for (std::size_t component = 0; component < 2; ++component) {
    for (std::size_t i = 0; i < problem_.look_used.size(); ++i) {
      if (problem_.look_used[i] == 0) continue;
      // Floats.
      EXPECT_NEAR(a.quality.redundancy[component][i], b.quality.redundancy[component][i], 2e-7);
      EXPECT_NEAR(a.quality.w[component][i], b.quality.w[component][i], 1e-5);
      EXPECT_NEAR(a.quality.shift_m[component][i], b.quality.shift_m[component][i], 1e-6);
    }
  }
  // Every pair of parameters that the border's pattern has is given, unchanged.
  const Eigen::MatrixXd c = full.blocks.ToDense();
  for (const ParameterCovariance& pair : ParameterCovariances(*border_, bordered)) {
    EXPECT_NEAR(pair.covariance, c(pair.a, pair.b), 1e-11);
  }
}

// Of aircraft alone: eliminated they take some twenty seconds.
class BorderedVariancesTest : public BorderedPointsTest {};

TEST_P(BorderedVariancesTest, AreThoseOfThePointsEliminated) {
  std::vector<std::array<int, 2>> component_of(kPasses, {0, 1});
  for (std::size_t pass = 0; pass < 100; ++pass) component_of[pass] = {2, 1};
  const VarianceSums a = SumVariances(problem_, state_, *border_, component_of, 3);
  const VarianceSums b = SumVariances(problem_, state_, *eliminated_, component_of, 3);
  EXPECT_LT((a.redundancy - b.redundancy).norm(), 1e-9 * b.redundancy.norm());
  EXPECT_LT((a.helmert - b.helmert).norm(), 1e-9 * b.helmert.norm());
}

// Second route: the residuals of the whole point.
TEST_P(BorderedPointsTest, GiveOneLookTheResidualsOfTheWholePoint) {
  const CorrectionCovariance bordered = border_->SelectedInverse();
  const CorrectionCovariance full = eliminated_->SelectedInverse();
  const PointResiduals all = PointLinearization(problem_, state_, &full).At(1).Residuals();
  const PointResiduals information =
      PointLinearization(problem_, state_, nullptr).At(1).Information();
  ASSERT_EQ(information.looks, all.looks);
  for (const std::size_t k : {std::size_t{0}, std::size_t{271}, kPasses - 1}) {
    const auto row = static_cast<Eigen::Index>(2 * k);
    const PointResiduals one =
        PointLinearization(problem_, state_, &bordered).At(1).ResidualsOf(all.looks[k]);
    EXPECT_EQ(one.looks_of_point, kPasses);
    EXPECT_LT((one.v - all.v.segment<2>(row)).norm(), 1e-12 * all.v.norm());
    EXPECT_LT((one.q_vv - all.q_vv.block<2, 2>(row, row)).norm(), 1e-10);
    EXPECT_LT((one.corrections_share - all.corrections_share.block<2, 2>(row, row)).norm(), 1e-10);
    EXPECT_LT((one.shift_m - all.shift_m.middleCols<2>(row)).norm(), 1e-10);
    // Q of two factorisations differs by a rotation; what the rows say of the point does not.
    const auto rows = information.information.middleRows<2>(row);
    const auto of_all = all.information.middleRows<2>(row);
    EXPECT_LT((rows * rows.transpose() - of_all * of_all.transpose()).norm(), 1e-11);
  }
}

INSTANTIATE_TEST_SUITE_P(AircraftAndOrbits,
                         BorderedPointsTest,
                         testing::Values(Flights::kAircraft, Flights::kOrbits),
                         [](const testing::TestParamInfo<Flights>& flights) {
                           return flights.param == Flights::kOrbits ? "Orbits" : "Aircraft";
                         });

INSTANTIATE_TEST_SUITE_P(Aircraft,
                         BorderedVariancesTest,
                         testing::Values(Flights::kAircraft),
                         [](const auto&) { return "Aircraft"; });

// Second route: the same points eliminated. Passes of two looks each on a dozen points: what the
// points leave of the corrections is dense, so that all of them are in the border.
TEST(FewPointsOfManyPassesTest, AreAllInTheBorderAndGiveTheSameResult) {
  const test::KnownBlock known = ManyPasses(Flights::kAircraft);
  AdjustmentProblem problem(known.block, Positions());
  constexpr std::size_t kFew = 12;
  const Looks& looks = problem.block.looks;
  std::vector<std::uint32_t> all;
  for (std::size_t point = 0; point < kPoints; ++point) {
    if (point >= kFew) {
      problem.LeaveOut(point, PointStatus::kNotSeen, "");
    } else {
      all.push_back(static_cast<std::uint32_t>(point));
    }
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const std::size_t pass = looks.pass[i], first = pass % kFew;
      const std::size_t second = (first + 1 + pass / kFew % (kFew - 1)) % kFew;
      problem.look_used[i] = point == first || point == second ? 1 : 0;
    }
  }
  BlockState state;
  state.start_m = known.truth_m;
  state.displacement_m.assign(known.truth_m.size(), {0.7, -1.3, 0.9});
  state.corrections.setConstant(problem.layout.size(), 0.13);
  UpdateWeights(state, &problem);
  ReducedSystem border(problem), eliminated(problem, 0, ManyLooks::kEliminate);
  for (ReducedSystem* system : {&border, &eliminated}) {
    system->Form(state, {}, nullptr);
    FactorRegular(system);
  }
  EXPECT_EQ(border.bordered().points, all);
  EXPECT_TRUE(eliminated.bordered().points.empty());
  const Eigen::VectorXd step = eliminated.Step();
  EXPECT_LT((border.Step() - step).norm(), 1e-11 * step.norm());
  EXPECT_NEAR(border.NewtonDecrement(), eliminated.NewtonDecrement(), 1e-10);
  const CorrectionCovariance bordered = border.SelectedInverse();
  const CorrectionCovariance full = eliminated.SelectedInverse();
  const PointSweep a = SweepPoints(problem, state, &bordered, true, nullptr);
  const PointSweep b = SweepPoints(problem, state, &full, true, nullptr);
  for (std::size_t point = 0; point < kFew; ++point) {
    const double size = std::abs(b.covariance_m2[point][0]);
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(a.covariance_m2[point][k], b.covariance_m2[point][k], 1e-10 * size) << point;
    }
    EXPECT_NEAR(a.redundancy[point], b.redundancy[point], 1e-8) << point;
  }
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] == 0) continue;
    EXPECT_NEAR(a.quality.w[0][i], b.quality.w[0][i], 1e-5) << i;
    EXPECT_NEAR(a.quality.w[1][i], b.quality.w[1][i], 1e-5) << i;
  }
}

// Known error: one look of five hundred is 40 sigmas wrong.
TEST(BorderedPointSearchTest, FindsTheWrongLookOfAPointThatHundredsOfPassesSee) {
  test::KnownBlock known = ManyPasses(Flights::kAircraft);
  Looks& looks = known.block.looks;
  const std::size_t wrong = looks.offsets[0] + 331;
  looks.range_m[wrong] += 28.0;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = Positions();
  options.covariance = CovarianceLevel::kNone;
  options.quality.snooping = Snooping::kIterative;
  options.quality.family_wise = FamilyWise::kSidak;
  const AdjustResult result = Adjust(known.block, options);
  ASSERT_TRUE(result.usable());
  std::vector<std::size_t> rejected;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (result.looks.rejected[i] != 0) rejected.push_back(i);
  }
  EXPECT_THAT(rejected, testing::ElementsAre(wrong));
}

}  // namespace
}  // namespace sarblock
