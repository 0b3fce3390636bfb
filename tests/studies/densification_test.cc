// SPDX-License-Identifier: Apache-2.0
#include "studies/densification.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <fstream>
#include <iterator>

#include "core/threads.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using ::testing::HasSubstr;

constexpr char kHead[] =
    "format = \"sarblock-study 1\"\nstudy = \"densification\"\nseed = 11\n"
    "scene = \"earth-asc-desc\"\nset = [\"points.count=40\", \"check.count=0\"]\n";

DensificationFile Read(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const std::string scenes = std::string(SARBLOCK_DATASETS) + "/scenes";
  return ParseDensification(kHead + text, "s.toml", overrides, [&](const std::string& name) {
    std::ifstream stream(scenes + "/" + name + ".toml");
    return std::string(std::istreambuf_iterator<char>(stream), {});
  });
}

constexpr char kLayouts[] =
    "[[axis]]\nkey = \"control.layout\"\nvalues = [\"corners\", \"grid\"]\n"
    "[[axis]]\nkey = \"control.count\"\nvalues = [0, 4, 9]\n";

TEST(DensificationTest, CasesAreTheProductOfTheAxesWithoutRepeatedOrImpossibleLayouts) {
  const DensificationStudy study =
      Read(std::string(kLayouts) +
           "[[axis]]\nname = \"noise\"\nkey = \"looks.range_sigma_m\"\nvalues = [0.5, 2.0]\n"
           "[[case]]\nname = \"mine\"\nset = [\"control.layout=places\", \"control.count=2\", "
           "\"control.places_m=[[0, 0], [9000.5, -7000]]\"]\n")
          .study;
  std::vector<std::string> names;
  for (const StudyCase& of : study.cases) {
    names.push_back(of.layout + " " + std::to_string(of.scene.control.count) + " " + of.variant);
  }
  EXPECT_THAT(names,
              ::testing::ElementsAre("none 0 noise 0.5",
                                     "none 0 noise 2.0",
                                     "corners 4 noise 0.5",
                                     "corners 4 noise 2.0",
                                     "grid 4 noise 0.5",
                                     "grid 4 noise 2.0",
                                     "grid 9 noise 0.5",
                                     "grid 9 noise 2.0",
                                     "places 2 mine"));
  EXPECT_EQ(study.cases[3].scene.looks.range_sigma_m, 2.0);
  EXPECT_EQ(study.cases[8].scene.control.places_m[1], Eigen::Vector2d(9000.5, -7000));
  EXPECT_EQ(study.cases[8].scene.points.count, 40u);
}

TEST(DensificationTest, FlightsAreThoseNamed) {
  const DensificationStudy study = Read(
                                       "[[case]]\nname = \"same side\"\nscene = "
                                       "\"earth-same-side\"\nflights = [\"A3\", \"A1\"]\n")
                                       .study;
  ASSERT_EQ(study.cases.size(), 1u);
  ASSERT_EQ(study.cases[0].scene.flights.size(), 2u);
  EXPECT_EQ(study.cases[0].scene.flights[0].id, "A3");
}

// Seeded statistics: the bound holds for all rows together with 99 percent.
TEST(DensificationTest, DrawnBlocksAgreeWithThePredictionInEveryRow) {
  const DensificationFile file = Read(std::string(kLayouts) + "[verify]\nruns = 12\n");
  const StudyTable table = RunStudy(PlanDensification(file.study));
  ASSERT_EQ(table.size(), 4u);
  for (std::size_t row = 0; row < table.size(); ++row) {
    EXPECT_EQ(table.Number(row, "determined"), 1.0);
    EXPECT_EQ(table.Number(row, "runs"), 12.0);
    EXPECT_EQ(table.Number(row, "agrees"), 1.0)
        << table.Number(row, "nees") << " in " << table.Number(row, "nees_lower") << " to "
        << table.Number(row, "nees_upper");
    EXPECT_NEAR(
        table.Number(row, "montecarlo_rms_u_m") / table.Number(row, "rms_sigma_u_m"), 1.0, 0.6);
  }
  // More control never hurts: rows are none, corners 4, grid 4, grid 9.
  EXPECT_LT(table.Number(1, "max_sigma_u_m"), table.Number(0, "max_sigma_u_m"));
  EXPECT_THAT(DescribeDensification(file.study, table).back(), HasSubstr("in 4 of 4"));
}

// The verification can fail: paths ten times worse than their priors say.
TEST(DensificationTest, DrawnBlocksDoNotAgreeWhereThePriorsAreWrong) {
  const DensificationFile file = Read(
      "[[case]]\nname = \"a\"\nset = [\"navigation.constant_sigma_m=[30, 20, 20]\", "
      "\"control.layout=none\"]\n[verify]\nruns = 12\nnavigation = \"scene\"\n");
  const StudyTable table = RunStudy(PlanDensification(file.study));
  EXPECT_EQ(table.Number(0, "agrees"), 0.0);
  EXPECT_GT(table.Number(0, "nees"), 5.0);
}

TEST(DensificationTest, AnUndeterminedLayoutIsARowThatSaysWhy) {
  const std::string free =
      "\"adjust.correction.position={basis=\\\"polynomial\\\", degree=1, axes=\\\"track\\\"}\"";
  const StudyTable table = RunStudy(PlanDensification(
      Read("[[axis]]\nkey = \"control.count\"\nvalues = [0, 4]\n", {"set=[" + free + "]"}).study));
  ASSERT_EQ(table.size(), 2u);
  EXPECT_EQ(table.Number(0, "determined"), 0.0);
  EXPECT_NE(table.Text(0, "message"), "");
  EXPECT_TRUE(std::isnan(table.Number(0, "max_sigma_u_m")));
  EXPECT_EQ(table.Number(1, "determined"), 1.0);
}

TEST(DensificationTest, PlacementRowsGoOnFromTheStartAndThreadsChangeNothing) {
  const DensificationFile file = Read(
      "[[case]]\nname = \"p\"\nset = [\"control.layout=none\"]\n[[placement]]\nname = \"p\"\n"
      "set = [\"control.layout=none\"]\ncount = 3\nsigma_m = [0.3, 0.3, 0.3]\n"
      "[verify]\nruns = 3\n[goal]\nsigma_u_m = 1e-3\n");
  const StudyPlan plan = PlanDensification(file.study);
  const StudyTable table = RunStudy(plan);
  ASSERT_EQ(table.size(), 6u);
  EXPECT_NEAR(table.Number(1, "max_sigma_u_m"), table.Number(0, "max_sigma_u_m"), 1e-9);
  EXPECT_NEAR(table.Number(1, "median_difference_sigma_e_m"),
              table.Number(0, "median_difference_sigma_e_m"),
              1e-9);
  for (std::size_t row = 2; row < 5; ++row) {
    EXPECT_EQ(table.Number(row, "control_points"), static_cast<double>(row - 1));
    EXPECT_NE(table.Text(row, "added_point"), "");
    EXPECT_LT(std::abs(table.Number(row, "added_east_m")), 31000.0);
    EXPECT_LT(table.Number(row, "rms_sigma_u_m"), table.Number(row - 1, "rms_sigma_u_m"));
  }
  const std::vector<std::string> words = DescribeDensification(file.study, table);
  ASSERT_EQ(words.size(), 3u);
  EXPECT_THAT(words[0],
              HasSubstr("p: sigma_u 0.001 m everywhere is missed by all layouts; the nearest is "
                        "without control: sigma_h "));
  EXPECT_THAT(words[1], HasSubstr("greedy mean-variance placement from no control: T"));
  EXPECT_EQ(table.Text(5, "layout"), "exchange mean-variance");
  EXPECT_EQ(table.Number(5, "control_points"), 3.0);
  EXPECT_LE(table.Number(5, "criterion_m2"), table.Number(4, "criterion_m2") * (1.0 + 1e-9));
  EXPECT_THAT(words[1],
              table.Text(5, "message").empty()
                  ? HasSubstr("; no exchange of one of them lowers the criterion")
                  : HasSubstr("; exchanging " + table.Text(5, "message") + " lowers"));
  const ThreadLimit one(1);
  EXPECT_EQ(RunStudy(plan).rows(), table.rows());
}

// Hand-made tables: what reads as success is one.
TEST(DensificationTest, WordsSayWhatWasReachedAndWithoutAGoalWhatWasFound) {
  const auto row = [](std::int64_t count, double h_m, double u_m) {
    StudyRowMaker made(DensificationColumns());
    return made.Set("layout", std::string(count == 0 ? "none" : "grid"))
        .Set("control_points", count)
        .Set("max_sigma_h_m", h_m)
        .Set("max_sigma_u_m", u_m)
        .Count("determined", 1)
        .row();
  };
  const StudyTable table(DensificationColumns(), {row(0, 9.0, 80.0), row(4, 2.0, 7.0)});
  DensificationStudy study;
  EXPECT_THAT(DescribeDensification(study, table),
              ::testing::ElementsAre("the worst point has without control: sigma_h 9 m, sigma_u 80 "
                                     "m; best with 4 control points (grid): sigma_h 2 m, sigma_u 7 "
                                     "m"));
  study.goal.sigma_u_m = 100.0;
  EXPECT_THAT(DescribeDensification(study, table),
              ::testing::ElementsAre("sigma_u 100 m everywhere is reached without control: sigma_h "
                                     "9 m, sigma_u 80 m"));
  study.goal.sigma_u_m = 8.0;
  EXPECT_THAT(DescribeDensification(study, table),
              ::testing::ElementsAre("sigma_u 8 m everywhere is reached with 4 control points "
                                     "(grid): sigma_h 2 m, sigma_u 7 m; no smaller layout of the "
                                     "study does"));
}

TEST(DensificationTest, NavigationFollowsThePriorsAndTheSceneWhereThereAreNone) {
  SceneNavigation scene;
  scene.constant_sigma_m = {7.0, 8.0, 9.0};
  scene.drift_sigma_m = {0.7, 0.8, 0.9};
  scene.curvature_sigma_m = {5.0, 5.0, 5.0};
  scene.range_bias_sigma_m = 3.0;
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  CorrectionGroup position{"position", PositionCorrection{}, {}, false};
  auto& of = std::get<PositionCorrection>(position.model);
  of.degree = 1;
  of.components = {true, true, false};
  of.prior_sigma_m[0] = {1.5, 0.25};
  options.groups = {position, {"range", RangeCorrection{true, 2.5, false, kNotGiven}, {}, false}};
  const SceneNavigation drawn = NavigationFromPriors(options, scene);
  EXPECT_EQ(drawn.constant_sigma_m, (std::array<double, 3>{1.5, 8.0, 0.0}));
  EXPECT_EQ(drawn.drift_sigma_m, (std::array<double, 3>{0.25, 0.8, 0.0}));
  EXPECT_EQ(drawn.curvature_sigma_m, (std::array<double, 3>{}));
  EXPECT_EQ(drawn.range_bias_sigma_m, 2.5);
  of.basis = PositionCorrection::Basis::kSpline;
  options.groups = {position};
  EXPECT_THROW(static_cast<void>(NavigationFromPriors(options, scene)), InputError);
}

}  // namespace
}  // namespace sarblock
