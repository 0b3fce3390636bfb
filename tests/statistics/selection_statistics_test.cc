// SPDX-License-Identifier: Apache-2.0
// Seeded statistics of the choice of corrections (docs/validation.md): over many draws of blocks
// with flight errors of a known kind the points of the chosen model are as good as those of the
// best fixed model, and their normalised errors follow chi-square.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "statistics/scene_statistics.h"
#include "support/scene_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kSelectionLevel = 0.999;
/// What the chosen model may lose against the best fixed one, part of its error.
constexpr double kMaxLoss = 0.10;

struct FlightError {
  std::string name;
  std::vector<std::string> overrides;
  std::uint64_t first_seed = 0;
};

void PrintTo(const FlightError& error, std::ostream* out) { *out << error.name; }

/// Four strips and two across them, 300 tie and 20 check points.
Scene StripsScene(const FlightError& error) {
  std::vector<std::string> all{"flight.0.count=4",
                               "flight.0.length_m=40000",
                               "flight.1.length_m=27000",
                               "flight.2.length_m=27000",
                               "flight.2.start_m=[51000, 13000]",
                               "points.count=300",
                               "points.east_m=[1000, 39000]",
                               "points.north_m=[16000, 37000]",
                               "control.count=12",
                               "check.count=20",
                               "navigation.drift_sigma_m=[0, 0, 0]"};
  all.insert(all.end(), error.overrides.begin(), error.overrides.end());
  return test::ShippedScene("block-12-strips", all);
}

/// The fixed models: none, degrees 0 to 3 and the two splines that the selection may choose, all
/// components alike.
std::map<std::string, std::vector<CorrectionGroup>> FixedModels(const Block& block) {
  std::map<std::string, std::vector<CorrectionGroup>> models{{"none", {}}};
  double longest_s = 0.0;
  for (const Pass& pass : block.passes) longest_s = std::max(longest_s, pass.end_s - pass.start_s);
  const auto add = [&](const std::string& name, const PositionCorrection& position) {
    CorrectionGroup group;
    group.name = "position";
    group.model = position;
    models[name] = {group};
  };
  for (int degree = 0; degree <= 3; ++degree) {
    PositionCorrection position;
    position.degree = degree;
    add("degree " + std::to_string(degree), position);
  }
  for (const double pieces : {4.0, 8.0}) {
    PositionCorrection position;
    position.basis = PositionCorrection::Basis::kSpline;
    position.knot_spacing_s = longest_s / pieces;
    add("spline " + std::to_string(static_cast<int>(pieces)), position);
  }
  return models;
}

/// Square sum of the check points' true errors; infinite where the model cannot be solved.
double CheckSquare(const SimulatedBlock& simulated, const AdjustResult& result) {
  double sum_m2 = 0.0;
  for (const CheckResult& check : result.checks) {
    sum_m2 += (result.points.position_m[check.point] - simulated.truth.points_m[check.point])
                  .squaredNorm();
  }
  return sum_m2;
}

class SelectionStatisticsTest : public testing::TestWithParam<FlightError> {};

TEST_P(SelectionStatisticsTest, IsAsGoodAsTheBestFixedModelAndHonest) {
  const FlightError& error = GetParam();
  const Scene scene = StripsScene(error);
  SimulatedBlock simulated = Simulate(scene);
  const Block& block = simulated.block;
  const std::map<std::string, std::vector<CorrectionGroup>> fixed = FixedModels(block);
  AdjustOptions chosen;
  chosen.corrections = CorrectionChoice::kAuto;
  AdjustOptions given;
  given.covariance = CovarianceLevel::kNone;

  // Free knots on few looks a knot: some blocks end where no step lowers the cost, and say so.
  const bool may_not_converge = error.name == "random walk";
  std::size_t not_converged = 0;
  std::map<std::string, double> square_m2;
  double chosen_m2 = 0.0, parameters = 0.0;
  test::SquareSum check, residuals;
  // In the short form a third of the draws of paths that take splines, the longest by far.
  const std::size_t asked = test::DrawsAsked();
  const std::size_t draws = asked < 50 && error.name == "random walk" ? (asked + 2) / 3 : asked;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    Redraw(scene, error.first_seed + draw, RedrawChoice{}, &simulated);
    const AdjustResult result = Adjust(block, chosen);
    if (may_not_converge && result.status == AdjustStatus::kNotConverged) {
      ASSERT_FALSE(result.usable()) << draw;
      ++not_converged;
      continue;
    }
    ASSERT_TRUE(result.usable()) << draw;
    chosen_m2 += CheckSquare(simulated, result);
    parameters += static_cast<double>(result.parameters.size());
    const CheckResult& one = result.checks[draw % result.checks.size()];
    check.Add(one.chi_square, one.components);
    // v'Pv of looks and control alone: estimated priors come from the same residuals, so that they
    // are no observations.
    residuals.Add(result.sigma0_squared * result.test_redundancy, result.test_redundancy);
    for (const auto& [name, groups] : fixed) {
      given.corrections = groups.empty() ? CorrectionChoice::kNone : CorrectionChoice::kGiven;
      given.groups = groups;
      double& sum_m2 = square_m2[name];
      try {
        sum_m2 += CheckSquare(simulated, Adjust(block, given));
      } catch (const UndeterminedError&) {
        sum_m2 = std::numeric_limits<double>::infinity();
      }
    }
  }
  const auto best = std::min_element(
      square_m2.begin(), square_m2.end(), [](auto& a, auto& b) { return a.second < b.second; });
  EXPECT_LE(not_converged, draws / 30);
  const double count = static_cast<double>((draws - not_converged) * 20);
  const double ratio = std::sqrt(chosen_m2 / best->second);
  const Interval region = ChiSquareInterval(kSelectionLevel, check.degrees);
  std::printf("| %s | %zu | %s, %.3f | %.3f | %.3f | %.0f | %.3f, %.3f to %.3f | %.3f |\n",
              error.name.c_str(),
              draws,
              best->first.c_str(),
              std::sqrt(best->second / count),
              std::sqrt(chosen_m2 / count),
              ratio,
              parameters / static_cast<double>(draws - not_converged),
              check.mean(),
              region.lower / check.degrees,
              region.upper / check.degrees,
              residuals.mean());
  EXPECT_LT(ratio, 1.0 + kMaxLoss) << best->first;
  EXPECT_TRUE(region.Contains(check.value)) << check.mean();
  const Interval left = ChiSquareInterval(kSelectionLevel, residuals.degrees);
  // Where there is nothing to be held, estimated priors are wider than what they hold, and the
  // looks of the truth leave a little less than their redundancy.
  EXPECT_LT(residuals.value, left.upper) << residuals.mean();
  EXPECT_GT(residuals.value, 0.95 * left.lower) << residuals.mean();
}

INSTANTIATE_TEST_SUITE_P(
    FlightErrors,
    SelectionStatisticsTest,
    testing::Values(FlightError{"constant", {}, 510000},
                    FlightError{"linear", {"navigation.drift_sigma_m=[6, 6, 6]"}, 520000},
                    FlightError{"quadratic",
                                {"navigation.drift_sigma_m=[6, 6, 6]",
                                 "navigation.curvature_sigma_m=[6, 6, 6]"},
                                530000},
                    FlightError{"random walk",
                                {"navigation.process=random-walk",
                                 "navigation.process_sigma_m=[30, 30, 30]",
                                 "navigation.knot_spacing_s=27.777777777777779"},
                                540000}),
    [](const testing::TestParamInfo<FlightError>& at) {
      std::string name = at.param.name;
      name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
      return name;
    });

/// Draws of a shipped scene, adjusted with corrections = "auto".
struct AutoCase {
  std::string scene;
  std::string mode;
  std::uint64_t first_seed = 0;
  /// The scene's own table with standard deviations ten times those of its flights.
  std::string wide_sigma_m;
};

void PrintTo(const AutoCase& at, std::ostream* out) {
  *out << at.scene << " " << at.mode << at.wide_sigma_m;
}

class SelectionWithPriorsTest : public testing::TestWithParam<AutoCase> {};

// What is left out by the choice is not zero: with the scene's own tables beside "auto" the errors
// of corrections and points follow their covariance, whatever was chosen. Where those tables are
// wider than the flights' errors, they are smaller than the covariance where priors count.
TEST_P(SelectionWithPriorsTest, StatesTheErrorsOfItsCorrections) {
  const AutoCase& at = GetParam();
  std::vector<std::string> overrides{
      "adjust.corrections=auto", "adjust.selection.mode=" + at.mode, "adjust.diagnose=false"};
  const bool wide = !at.wide_sigma_m.empty();
  if (wide) overrides.push_back("adjust.correction.position.sigma_m=" + at.wide_sigma_m);
  const Scene scene = test::ShippedScene(at.scene, overrides);
  const test::SceneStatistics sums = test::RunDraws(scene, test::DrawsAsked(), at.first_seed);
  const Interval corrections = ChiSquareInterval(kSelectionLevel, sums.corrections.degrees);
  const Interval point = ChiSquareInterval(kSelectionLevel, sums.point.degrees);
  std::printf("| %s, %s%s | %zu | %.3f, %.3f to %.3f | %.3f, %.3f to %.3f |\n",
              at.scene.c_str(),
              at.mode.c_str(),
              wide ? ", wide" : "",
              sums.draws,
              sums.corrections.mean(),
              corrections.lower / sums.corrections.degrees,
              corrections.upper / sums.corrections.degrees,
              sums.point.mean(),
              point.lower / sums.point.degrees,
              point.upper / sums.point.degrees);
  EXPECT_LE(sums.corrections.value, corrections.upper) << sums.corrections.mean();
  EXPECT_LE(sums.point.value, point.upper) << sums.point.mean();
  if (wide) return;
  EXPECT_GE(sums.corrections.value, corrections.lower) << sums.corrections.mean();
  EXPECT_GE(sums.point.value, point.lower) << sums.point.mean();
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    SelectionWithPriorsTest,
    testing::Values(
        AutoCase{"earth-same-side", "common", 550000, ""},
        AutoCase{"earth-same-side", "per-pass", 560000, ""},
        AutoCase{"venus-magellan", "common", 570000, ""},
        AutoCase{"moon-alse", "common", 580000, ""},
        AutoCase{"earth-same-side", "common", 610000, "[[30, 5], [20, 4], [20, 3]]"},
        AutoCase{"venus-magellan", "common", 620000, "[[2500, 400], [1800, 300], [600, 120]]"},
        AutoCase{"moon-alse", "common", 630000, "[[3000, 300], [2000, 200], [1000, 100]]"}),
    [](const testing::TestParamInfo<AutoCase>& at) {
      const bool is_wide = !at.param.wide_sigma_m.empty();
      return test::TestNameOf(at.param.scene + "_" + at.param.mode) + (is_wide ? "_wide" : "");
    });

}  // namespace
}  // namespace sarblock
