// SPDX-License-Identifier: Apache-2.0
#include "studies/design.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "leberl/pairs.h"
#include "studies/design_law.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kDesignHead[] =
    "format = \"sarblock-study 1\"\nstudy = \"design\"\n"
    "scene = \"leberl-aircraft\"\nset = [\"points.count=40\", \"check.count=0\"]\n";

DesignFile ReadDesignText(const std::string& text, const std::string& head = kDesignHead) {
  const std::string scenes = std::string(SARBLOCK_DATASETS) + "/scenes";
  return ParseDesign(head + text, "d.toml", {}, [&](const std::string& name) {
    std::ifstream stream(scenes + "/" + name + ".toml");
    return std::string(std::istreambuf_iterator<char>(stream), {});
  });
}

constexpr char kTwoAxes[] =
    "[[axis]]\nname = \"range noise\"\nkey = \"looks.range_sigma_m\"\nvalues = [0.5, 2.0]\n"
    "[[axis]]\nkey = \"control.count\"\nvalues = [2, 4]\n";
constexpr char kPrices[] =
    "[cost]\ncurrency = \"EUR\"\npass = 1000.5\nkilometre = 2\ncontrol_point = 300.25\n";

TEST(DesignTest, CasesAreTheProductOfOneOrTwoAxes) {
  const DesignStudy study = ReadDesignText(kTwoAxes).study;
  ASSERT_EQ(study.cases.size(), 4U);
  EXPECT_EQ(study.cases[1].scene.looks.range_sigma_m, 0.5);
  EXPECT_EQ(study.cases[1].scene.control.count, 4U);
  EXPECT_EQ(study.cases[2].scene.looks.range_sigma_m, 2.0);
  EXPECT_THAT(study.axes[0].values, ElementsAre("0.5", "2.0"));
  EXPECT_EQ(study.axes[1].name, "control.count");
  // several keys that take one value
  const DesignStudy keys =
      ReadDesignText(
          "[[axis]]\nkeys = [\"looks.range_sigma_m\", \"looks.azimuth_sigma_m\"]\nvalues = [0.7]\n")
          .study;
  EXPECT_EQ(keys.cases.at(0).scene.looks.range_sigma_m, 0.7);
  EXPECT_EQ(keys.cases.at(0).scene.looks.azimuth.azimuth, 0.7);
  EXPECT_EQ(keys.choices.at(0).at(0).number, 0.7);
}

// Two routes: the same block predicted directly. Tracks are along x, which is east.
TEST(DesignTest, ARowIsThePredictionOfItsBlock) {
  const DesignFile file = ReadDesignText(std::string(kTwoAxes) + kPrices);
  const StudyTable table = RunStudy(PlanDesign(file.study));
  ASSERT_EQ(table.size(), 4U);
  for (std::size_t row = 0; row < table.size(); ++row) {
    const StudyCase& of = file.study.cases[row];
    const SimulatedBlock planned = PlannedBlock(of.scene);
    AdjustOptions options = of.adjust;
    options.covariance = CovarianceLevel::kBlock;
    const AdjustResult result = Predict(planned.block, options, planned.truth.points_m);
    std::array<double, 3> largest_m{};
    std::size_t points = 0;
    for (std::size_t j = 0; j < planned.block.points.size(); ++j) {
      if (planned.block.points.role[j] == PointRole::kControl) continue;
      ++points;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        largest_m[axis] =
            std::max(largest_m[axis], std::sqrt(result.points.covariance_m2[j][axis]));
      }
    }
    EXPECT_NEAR(table.Number(row, "max_sigma_along_m"), largest_m[0], 1e-12);
    EXPECT_NEAR(table.Number(row, "max_sigma_across_m"), largest_m[1], 1e-12);
    EXPECT_NEAR(table.Number(row, "max_sigma_up_m"), largest_m[2], 1e-12);
    EXPECT_LT(table.Number(row, "median_sigma_up_m"), largest_m[2]);
    // What the paths add: the variance that goes with the corrections.
    options.corrections = CorrectionChoice::kNone;
    options.groups.clear();
    const AdjustResult known = Predict(planned.block, options, planned.truth.points_m);
    double added_m = 0.0;
    for (std::size_t j = 0; j < planned.block.points.size(); ++j) {
      if (planned.block.points.role[j] == PointRole::kControl) continue;
      added_m = std::max(
          added_m, std::sqrt(result.points.covariance_m2[j][2] - known.points.covariance_m2[j][2]));
    }
    EXPECT_NEAR(table.Number(row, "max_path_sigma_up_m"), added_m, 1e-6 * added_m);
    EXPECT_EQ(table.Number(row, "points"), static_cast<double>(points));
    EXPECT_EQ(table.Number(row, "redundancy"), result.redundancy());
    EXPECT_EQ(table.Number(row, "number_1"), of.scene.looks.range_sigma_m);
    // hand arithmetic: two passes, each as long as the scene says
    const double flight_km = 2e-3 * of.scene.flights[0].length_m;
    EXPECT_NEAR(table.Number(row, "flight_km"), flight_km, 1e-9);
    EXPECT_NEAR(table.Number(row, "cost"),
                2 * 1000.5 + 2 * flight_km + 300.25 * static_cast<double>(of.scene.control.count),
                1e-6);
  }
}

// Hand arithmetic on a table of one's own.
TEST(DesignTest, ParetoAndGoalsFollowTheNumbers) {
  const DesignFile file =
      ReadDesignText(std::string(kTwoAxes) + kPrices + "[goal]\nmax_sigma_up_m = 20\n");
  std::vector<StudyRow> rows;
  const struct {
    double cost, up_m;
  } cases[] = {{100.0, 20.1}, {200.0, 18.5}, {200.0, 18.5}, {250.0, 19.0}};
  for (const auto& [cost, up_m] : cases) {
    StudyRowMaker row(DesignColumns());
    row.Set("cost", cost).Set("max_sigma_up_m", up_m).Count("determined", 1);
    row.Count("reached", up_m <= 20.0 ? 1 : 0);
    rows.push_back(row.row());
  }
  const StudyTable table(DesignColumns(), rows);
  const StudyTable marked = MarkPareto(file.study, table);
  EXPECT_EQ(marked.Number(0, "pareto"), 1.0);
  EXPECT_EQ(marked.Number(1, "pareto"), 1.0);  // two equal ones do not beat each other
  EXPECT_EQ(marked.Number(2, "pareto"), 1.0);
  EXPECT_EQ(marked.Number(3, "pareto"), 0.0);
  EXPECT_THAT(DescribeDesign(file.study, table),
              ElementsAre("3 of 4 cases reach all goals; the cheapest is range noise 0.5, "
                          "control.count 4: worst point up 18.5 m, goal 20 m: reached",
                          "the best, worst point up 18.5 m, is range noise 0.5, control.count 4"));
  const std::vector<std::string> lines = DesignTables(file.study, marked);
  EXPECT_THAT(lines, Contains("0.5   20.1    18.5*"));
  EXPECT_THAT(lines, Contains("           100 EUR     20.1 m   range noise 0.5, control.count 2"));
  for (const std::string& line : lines) EXPECT_LE(line.size(), 80U) << line;

  const std::vector<StudyRow> missed(4, rows.front());
  EXPECT_THAT(
      DescribeDesign(file.study, StudyTable(DesignColumns(), missed)),
      Contains("no case reaches all goals; the nearest is range noise 0.5, control.count 2: "
               "worst point up 20.1 m, goal 20 m: missed"));
}

TEST(DesignTest, AMissNeverReadsAsTheGoal) {
  const DesignFile file = ReadDesignText(std::string(kTwoAxes) + "[goal]\nmax_sigma_up_m = 20\n");
  StudyRowMaker row(DesignColumns());
  row.Set("max_sigma_up_m", 20.0001).Count("determined", 1).Count("reached", 0);
  const StudyTable table(DesignColumns(), std::vector<StudyRow>(4, row.row()));
  EXPECT_THAT(DescribeDesign(file.study, table),
              Contains(HasSubstr("worst point up 20.0001 m, goal 20 m: missed")));
}

// Second route: all pairs about as far apart, in place of a sample of them.
TEST(DesignTest, DifferencesAreThoseOfPairsAsFarApartAsAsked) {
  const std::string scene =
      "format = \"sarblock-study 1\"\nstudy = \"design\"\n"
      "scene = \"leberl-aircraft\"\n"
      "set = [\"points.count=90\", \"check.count=0\"]\n";
  const DesignFile file = ReadDesignText(
      "[[axis]]\nkey = \"looks.range_sigma_m\"\nvalues = [1, 2]\n"
      "[goal]\ndifference_m = 4000\ndifference_sigma_up_m = 1\n",
      scene);
  const StudyTable table = RunStudy(PlanDesign(file.study));
  const double distance_m = table.Number(0, "difference_m");
  EXPECT_GT(distance_m, 2000.0);
  EXPECT_LT(distance_m, 8000.0);
  EXPECT_EQ(table.Number(0, "reached"), 0.0);
  EXPECT_THAT(DescribeDesign(file.study, table).front(), HasSubstr("difference up"));
  const StudyCase& of = file.study.cases.front();
  const SimulatedBlock planned = PlannedBlock(of.scene);
  AdjustOptions options = of.adjust;
  options.pairs = PairChoice::kAll;
  const AdjustResult all = Predict(planned.block, options, planned.truth.points_m);
  std::array<std::vector<double>, 2> up_m;
  for (const PairResult& pair : all.pairs) {
    const Eigen::Vector2d level = pair.difference_enu_m.head<2>();
    if (std::abs(std::log2(level.norm() / distance_m)) > 0.5) continue;
    const double part = std::abs(level.x()) / level.norm();  // tracks are along x
    if (part > std::cos(0.349)) up_m[0].push_back(std::sqrt(pair.covariance_m2[2]));
    if (part < std::sin(0.349)) up_m[1].push_back(std::sqrt(pair.covariance_m2[2]));
  }
  const double expected_m = std::max(Median(up_m[0]), Median(up_m[1]));
  EXPECT_NEAR(table.Number(0, "difference_sigma_up_m"), expected_m, 0.25 * expected_m);
}

TEST(DesignTest, ACaseThatGivesNoBlockIsARowWithItsReason) {
  const DesignFile file = ReadDesignText(
      "[[axis]]\nkey = \"points.east_m\"\nvalues = [[-20000, 20000], [900000, 910000]]\n",
      "format = \"sarblock-study 1\"\nstudy = \"design\"\nscene = \"leberl-aircraft\"\n"
      "set = [\"points.count=30\", \"check.count=0\", \"control.count=0\"]\n");
  const StudyTable table = RunStudy(PlanDesign(file.study));
  EXPECT_EQ(table.Number(1, "determined"), 0.0);
  EXPECT_THAT(table.Text(1, "message"), HasSubstr("no point lies in any swath"));
  EXPECT_THAT(DescribeDesign(file.study, table).back(), HasSubstr("1 of 2 cases give no block"));
}

// Hand arithmetic: logarithms -1, 0, 1 against 1, 0.3, 2 have the slope 1/2 and the squares of
// residuals 0.96, so the slope's error is sqrt(0.96 / 2).
TEST(PowerLawTest, IsTheLineThroughTheLogarithms) {
  const double e = std::exp(1.0);
  const PowerLaw law =
      FitPowerLaw({{1.0 / e, e}, {1.0, std::exp(0.3)}, {kNotGiven, 2.0}, {2.0, 0.0}, {e, e * e}});
  EXPECT_EQ(law.values, 3U);
  EXPECT_NEAR(law.exponent, 0.5, 1e-14);
  EXPECT_NEAR(law.factor, std::exp(1.1), 1e-13);
  EXPECT_NEAR(law.exponent_sigma, std::sqrt(0.48), 1e-14);
  EXPECT_NEAR(law.last_exponent, 1.7, 1e-14);
  EXPECT_TRUE(std::isnan(FitPowerLaw({{1.0, 2.0}, {2.0, 3.0}}).exponent_sigma));
  EXPECT_TRUE(std::isnan(FitPowerLaw({{3.0, 2.0}, {3.0, 4.0}}).exponent));
  EXPECT_TRUE(std::isnan(FitPowerLaw({}).exponent));
}

constexpr char kLawAxes[] =
    "[[axis]]\nname = \"range noise\"\nkey = \"looks.range_sigma_m\"\nvalues = [0.5, 1.0, 2.0]\n"
    "[[axis]]\nname = \"paths\"\n[[axis.case]]\nname = \"a\"\nnumber = 3\n"
    "[[axis.case]]\nname = \"b\"\n";

TEST(DesignLawTest, LawsOfATableAreThoseItWasMadeWith) {
  const DesignFile file =
      ReadDesignText(std::string(kLawAxes) +
                     "[law]\naxis = \"range noise\"\n[[law.derived]]\ncase = \"b\"\nup = 1.5\n");
  EXPECT_EQ(file.study.choices[1][0].number, 3.0);
  std::vector<StudyRow> rows;
  for (const double noise : {0.5, 1.0, 2.0}) {
    for (const double power : {0.25, 1.5}) {
      StudyRowMaker row(DesignColumns());
      row.Set("max_path_sigma_up_m", 7.0 * std::pow(noise, power)).Count("determined", 1);
      rows.push_back(row.row());
    }
  }
  const std::vector<FittedLaw> laws = FitLaws(file.study, StudyTable(DesignColumns(), rows));
  ASSERT_EQ(laws.size(), 12U);  // worst and median of three directions of two cases
  EXPECT_EQ(laws[2].value, "a");
  EXPECT_NEAR(laws[2].law.exponent, 0.25, 1e-12);
  EXPECT_TRUE(std::isnan(laws[2].derived));
  EXPECT_EQ(laws[5].value, "b");
  EXPECT_NEAR(laws[5].law.exponent, 1.5, 1e-12);
  EXPECT_NEAR(laws[5].law.factor, 7.0, 1e-12);
  EXPECT_EQ(laws[5].derived, 1.5);
  EXPECT_TRUE(std::isnan(laws[0].law.exponent));  // nothing along
  const std::vector<std::string> lines = LawLines(file.study, laws);
  ASSERT_EQ(lines.size(), 8U);
  EXPECT_EQ(lines.back(), "       up       1.50 +- 0.00        1.50     1.50");
  EXPECT_THAT(DescribeLaws(file.study, laws),
              ElementsAre("a: the worst point goes as range noise^- along, ^- across, ^0.25 up",
                          "b: the worst point goes as range noise^- along, ^- across, ^1.50 up "
                          "(derived -, -, 1.50)"));
  EXPECT_EQ(LawTable(file.study, laws).Number(5, "exponent"), laws[5].law.exponent);
}

// Theory: docs/theory/growth.md, eq. (5). Control at one end, flat ground, ties alone.
TEST(DesignLawTest, ErrorsOfAnOpenChainGrowAsDerived) {
  std::string text = "[[axis]]\nname = \"strips\"\n";
  for (const int strips : {12, 17, 24}) {
    const std::string n = std::to_string(strips);
    text += "[[axis.case]]\nname = \"" + n + "\"\nnumber = " + n +
            "\nset = [\"flight.0.count=" + n + "\", \"points.count=" + std::to_string(60 * strips) +
            "\", \"points.north_m=[16000, " + std::to_string(4800 * strips + 17000) + "]\"]\n";
  }
  const DesignFile file = ReadDesignText(
      text + "[law]\n",
      "format = \"sarblock-study 1\"\nstudy = \"design\"\nscene = \"block-12-strips\"\n"
      "flights = [\"S\"]\nset = [\"check.count=0\", \"terrain.relief_m=0\", "
      "\"looks.range_sigma_m=1e-4\", \"looks.azimuth_sigma_m=1e-4\", "
      "\"control.sigma_m=[1e-4, 1e-4, 1e-4]\", \"control.layout=places\", \"control.count=8\", "
      "\"control.places_m=[[2000, 14500], [58000, 14500], [2000, 18500], [58000, 18500], "
      "[2000, 21500], [58000, 21500], [2000, 24000], [58000, 24000]]\", "
      "\"adjust.correction.position={ degree = 0, sigma_m = [100, 100, 100] }\"]\n");
  const std::vector<FittedLaw> laws = FitLaws(file.study, RunStudy(PlanDesign(file.study)));
  // Along the variance of the last strip begins with that of its control: it grows by steps.
  const auto square_m2 = [&](std::size_t i) { return laws[0].values[i][1] * laws[0].values[i][1]; };
  EXPECT_NEAR((square_m2(2) - square_m2(1)) / (square_m2(1) - square_m2(0)), 7.0 / 5.0, 0.3);
  EXPECT_NEAR(laws[1].law.exponent, 1.5, 0.25);
  EXPECT_NEAR(laws[2].law.exponent, 2.5, 0.25);
}

// Flights at 30 degrees: errors are counted along the track, not east.
TEST(DesignTest, DrawnErrorsAreThosePredictedAlongAcrossAndUp) {
  const DesignFile file = ReadDesignText(
      "[[axis]]\nkey = \"looks.azimuth_sigma_m\"\nvalues = [0.05, 40.0]\n[verify]\nruns = 24\n",
      "format = \"sarblock-study 1\"\nstudy = \"design\"\nscene = \"block-12-strips\"\n"
      "flights = [\"S\"]\nset = [\"flight.0.count=3\", \"flight.0.heading_deg=60\", "
      "\"points.count=40\", \"points.east_m=[10000, 22000]\", \"points.north_m=[30000, 40000]\", "
      "\"check.count=0\"]\n");
  const StudyTable table = RunStudy(PlanDesign(file.study));
  for (std::size_t row = 0; row < table.size(); ++row) {
    EXPECT_EQ(table.Number(row, "agrees"), 1.0) << table.Text(row, "message");
    for (const std::string axis : {"along", "across", "up"}) {
      // 24 runs of errors that points largely share: 15 percent each.
      EXPECT_NEAR(table.Number(row, "montecarlo_rms_" + axis + "_m") /
                      table.Number(row, "rms_sigma_" + axis + "_m"),
                  1.0,
                  0.4)
          << axis;
    }
  }
  EXPECT_GT(table.Number(1, "rms_sigma_along_m"), 2.5 * table.Number(1, "rms_sigma_across_m"));
  EXPECT_THAT(DescribeDesign(file.study, table).back(), HasSubstr("in 2 of 2 verified rows"));
}

// The second route to a pair from orbit: a block with that geometry, paths known, no control. Its
// tracks converge by 3 degrees, by which an azimuth as good as the range would add to across.
TEST(PlannedPairTest, OfAnOrbitIsThatOfASmallBlock) {
  const DesignFile file = ReadDesignText(
      "[[axis]]\nkey = \"flight.1.aim_look_deg\"\nvalues = [31.5, 38.2]\n",
      "format = \"sarblock-study 1\"\nstudy = \"design\"\nscene = \"earth-same-side\"\n"
      "flights = [\"A1\", \"A2\"]\nset = [\"looks.range_sigma_m=3.3\", "
      "\"looks.azimuth_sigma_m=5\", \"points.count=25\", "
      "\"points.east_m=[-400, 400]\", \"points.north_m=[-400, 400]\", \"control.count=0\", "
      "\"check.count=0\", \"flight.1.swath_look_deg=[20, 50]\", \"adjust.corrections=none\"]\n");
  const StudyTable table = RunStudy(PlanDesign(file.study));
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double second_rad = (row == 0 ? 31.5 : 38.2) * kRadPerDeg;
    const auto pair = AccuracyOf({.look_rad = {23.0 * kRadPerDeg, second_rad},
                                  .height_m = 693e3,
                                  .body_radius_m = 6378137.0},
                                 {.range_m = {3.3, 3.3}, .azimuth_m = {5.0, 5.0}});
    ASSERT_TRUE(pair);
    // The ellipsoid at 45 degrees of latitude is 11 km below the sphere: 0.3 % of the angles.
    EXPECT_NEAR(table.Number(row, "median_sigma_up_m"), pair->all.up_m, 0.01 * pair->all.up_m);
    EXPECT_NEAR(
        table.Number(row, "median_sigma_across_m"), pair->all.across_m, 0.01 * pair->all.across_m);
    EXPECT_NEAR(table.Number(row, "median_sigma_along_m"), pair->all.along_m, 0.05);
  }
}

}  // namespace
}  // namespace sarblock
