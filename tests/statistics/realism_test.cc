// SPDX-License-Identifier: Apache-2.0
// Seeded statistics (docs/validation.md) of variance components, whose true values are planted, and
// of the Monte Carlo covariance on shipped scenes.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <string>
#include <vector>

#include "statistics/scene_statistics.h"
#include "support/scene_blocks.h"
#include <boost/math/distributions/binomial.hpp>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr double kRealismLevel = 0.999;

/// Estimates of one component over the draws, as parts of the true variance.
struct Estimates {
  std::string name;
  std::vector<double> ratio;      // estimated over true variance
  std::vector<double> deviation;  // its stated standard deviation

  [[nodiscard]] double Mean() const {
    double sum = 0.0;
    for (const double value : ratio) sum += value;
    return sum / static_cast<double>(ratio.size());
  }
  [[nodiscard]] double MeanStatedVariance() const {
    double sum = 0.0;
    for (const double value : deviation) sum += value * value;
    return sum / static_cast<double>(deviation.size());
  }
  [[nodiscard]] double EmpiricalVariance() const {
    const double mean = Mean();
    double sum = 0.0;
    for (const double value : ratio) sum += (value - mean) * (value - mean);
    return sum / (static_cast<double>(ratio.size()) - 1.0);
  }
};

struct PlantedCase {
  std::string scene;
  std::string points;
  bool grouped = false;  // every third pass has variances of its own
};

void PrintTo(const PlantedCase& given, std::ostream* out) {
  *out << given.scene << (given.grouped ? ", two groups" : "");
}

class PlantedVariancesTest : public testing::TestWithParam<PlantedCase> {};

/// True standard deviations of range and azimuth over those stated.
std::array<double, 2> Planted(bool grouped, std::size_t pass) {
  if (grouped && pass % 3 == 0) return {1.0, 3.0};
  return {2.0, 0.6};
}

// Mean of the estimates against the truth, and their scatter against the stated standard deviation:
// a variance estimate of f degrees of freedom is f s^2 / sigma^2 ~ chi-square(f).
TEST_P(PlantedVariancesTest, AreRecoveredWithinTheirStandardDeviations) {
  const PlantedCase& given = GetParam();
  const Scene scene =
      test::ShippedScene(given.scene, {"points.count=" + given.points, "check.count=3"});
  SimulatedBlock simulated = Simulate(scene);
  AdjustOptions options = test::OptionsOf(scene, simulated.block);
  options.variance_components = VarianceComponents::kRangeAzimuth;
  if (given.grouped) {
    std::vector<std::string>& group = options.variance_groups.emplace_back();
    for (std::size_t i = 0; i < simulated.block.passes.size(); i += 3) {
      group.push_back(simulated.block.passes[i].id);
    }
  }
  options.covariance = CovarianceLevel::kNone;
  const std::size_t draws = test::DrawsAsked();
  std::vector<Estimates> estimates;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    Redraw(scene, 7000 + draw, RedrawChoice{}, &simulated);
    Block reported = simulated.block;
    for (std::size_t i = 0; i < reported.passes.size(); ++i) {
      reported.passes[i].sigma.range_m /= Planted(given.grouped, i)[0];
      reported.passes[i].sigma.azimuth /= Planted(given.grouped, i)[1];
    }
    const AdjustResult result = Adjust(reported, options);
    ASSERT_TRUE(result.usable() && result.variance_components->converged)
        << draw << ' ' << testing::PrintToString(result.warnings);
    const std::vector<VarianceComponent>& found = result.variance_components->components;
    estimates.resize(found.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      const VarianceComponent& c = found[k];
      ASSERT_TRUE(c.estimated) << c.group << " " << c.note;
      const double root =
          Planted(given.grouped, c.passes[0])[static_cast<std::size_t>(c.component)];
      estimates[k].name = std::string(!given.grouped     ? "all"
                                      : c.passes[0] == 0 ? "every third"
                                                         : "others") +
                          (c.component == 0 ? " range" : " azimuth");
      estimates[k].ratio.push_back(c.factor / (root * root));
      estimates[k].deviation.push_back(c.factor_deviation / (root * root));
    }
  }
  const auto n = static_cast<double>(draws);
  const double level = 1.0 - (1.0 - kRealismLevel) / (2.0 * static_cast<double>(estimates.size()));
  for (const Estimates& e : estimates) {
    const double stated = e.MeanStatedVariance(), ratio = e.EmpiricalVariance() / stated;
    // Scatter of a sample variance whose parent is chi-square of f = 2 / stated degrees: its excess
    // kurtosis 12 / f widens that of a normal one by 1 + 6 / f.
    const double degrees = (n - 1.0) / (1.0 + 3.0 * stated);
    const Interval normal = ChiSquareInterval(level, degrees);
    const double bound = NormalQuantile(0.5 + 0.5 * level) * std::sqrt(stated / n);
    std::printf("| %s | %zu | %s | %.4f (%.4f-%.4f) | %.4f | %.3f (%.3f-%.3f) |\n",
                given.scene.c_str(),
                draws,
                e.name.c_str(),
                e.Mean(),
                1.0 - bound,
                1.0 + bound,
                std::sqrt(stated),
                std::sqrt(ratio),
                std::sqrt(normal.lower / degrees),
                std::sqrt(normal.upper / degrees));
    EXPECT_NEAR(e.Mean(), 1.0, bound) << e.name;
    EXPECT_TRUE(normal.Contains(degrees * ratio)) << e.name << " " << ratio;
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped,
                         PlantedVariancesTest,
                         testing::Values(PlantedCase{"block-12-strips", "60"},
                                         PlantedCase{"venus-magellan", "60"},
                                         PlantedCase{"block-12-strips", "150", true}),
                         [](const auto& c) {
                           return test::TestNameOf(c.param.scene) +
                                  (c.param.grouped ? "_grouped" : "");
                         });

class RepeatedNoiseTest : public testing::TestWithParam<std::string> {};

// By point the runs are independent: chi-square and binomial, 99.9 percent for all points together
// (Bonferroni). Of all points, means over the runs.
TEST_P(RepeatedNoiseTest, FillsTheRigorousEllipsoids) {
  const Scene scene = test::ShippedScene(GetParam(), {"points.count=40", "check.count=3"});
  const SimulatedBlock simulated = Simulate(scene);
  AdjustOptions options = test::OptionsOf(scene, simulated.block);
  options.covariance = CovarianceLevel::kMonteCarlo;
  options.montecarlo_runs = static_cast<int>(std::max<std::size_t>(test::DrawsAsked(), 30));
  const AdjustResult result = Adjust(simulated.block, options);
  ASSERT_TRUE(result.usable());
  const MonteCarloReport& report = *result.montecarlo;
  ASSERT_EQ(report.runs, options.montecarlo_runs);
  ASSERT_EQ(report.points, simulated.block.points.size());
  std::printf("| %s | %zu | %d | %.3f (%.3f-%.3f) |",
              GetParam().c_str(),
              report.points,
              report.runs,
              report.square_ratio.mean,
              report.square_ratio.lower(),
              report.square_ratio.upper());
  for (const RunMean& c : report.coverage) {
    std::printf(" %.2f (%.2f-%.2f) |", 100 * c.mean, 100 * c.lower(), 100 * c.upper());
  }
  std::printf(" %zu |\n", report.points_outside);
  const double level = 1.0 - (1.0 - kRealismLevel) / (4.0 * static_cast<double>(report.points));
  const double runs = report.runs, tail = 0.5 * (1.0 - level);
  for (std::size_t j = 0; j < report.points; ++j) {
    EXPECT_TRUE(ChiSquareInterval(level, 3.0 * runs).Contains(3.0 * runs * report.square[j]));
    for (std::size_t i = 0; i < MonteCarloReport::kLevels.size(); ++i) {
      // Exact tails: of 40 runs at 90 percent the normal approximation is far too narrow.
      const boost::math::binomial_distribution<double> inside(runs, MonteCarloReport::kLevels[i]);
      const double count = report.inside[i][j];
      EXPECT_GE(cdf(inside, count), tail) << count;
      if (count == 0.0) continue;
      EXPECT_GE(cdf(complement(inside, count - 1.0)), tail) << count;
    }
  }
  const double most = NormalQuantile(0.5 + 0.5 * kRealismLevel);
  for (const RunMean& mean : {report.square_ratio,
                              report.coverage[0],
                              report.coverage[1],
                              report.coverage[2],
                              report.variance_ratio[0],
                              report.variance_ratio[1],
                              report.variance_ratio[2]}) {
    EXPECT_NEAR(mean.mean, mean.expected, most * mean.standard_error);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shipped,
    RepeatedNoiseTest,
    testing::Values("block-12-strips", "earth-asc-desc", "convergent-squint", "leberl-aircraft"),
    [](const auto& scene) { return test::TestNameOf(scene.param); });

}  // namespace
}  // namespace sarblock
