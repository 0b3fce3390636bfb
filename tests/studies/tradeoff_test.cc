// SPDX-License-Identifier: Apache-2.0
// What the study of speed against accuracy computes of its runs. Evidence: hand values.
#include "studies/tradeoff.h"

#include <cmath>

#include "support/scene_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Two tie points and one control point in a local frame.
Block ThreePoints() {
  Block block;
  for (const char* id : {"T1", "T2", "C1"}) static_cast<void>(block.points.ids.Append(id));
  block.points.role = {PointRole::kTie, PointRole::kTie, PointRole::kControl};
  return block;
}

constexpr SymmetricEnu kQ{4.0, 1.0, 9.0, 0.0, 0.0, 0.0};

TradeoffAnswer Answer(double x0_m, double z1_m) {
  TradeoffAnswer answer;
  answer.position_m = {{x0_m, 0.0, 0.0}, {0.0, 0.0, z1_m}, {100.0, 0.0, 0.0}};
  answer.covariance_m2 = {kQ, kQ, kQ};
  return answer;
}

TEST(CompareAnswersTest, MeasuresShiftsInSigmasOfTheBestAnswer) {
  const std::vector<Eigen::Vector3d> truth_m(3, Eigen::Vector3d::Zero());
  TradeoffAnswer answer = Answer(3.0, 1.5);
  // |C - Q| / |Q| = sqrt(3) 0.5 / sqrt(16 + 1 + 81)
  answer.covariance_m2[1] = {4.5, 1.5, 9.5, 0.0, 0.0, 0.0};
  const AnswerErrors errors = CompareAnswers(ThreePoints(), answer, Answer(0.0, 0.0), truth_m);
  EXPECT_DOUBLE_EQ(errors.position_error, 1.5);  // 3 m of 2 m; 1.5 m of 3 m is 0.5
  EXPECT_DOUBLE_EQ(errors.covariance_error, std::sqrt(0.75 / 98.0));
  EXPECT_DOUBLE_EQ(errors.rms_error_m, std::sqrt((9.0 + 2.25) / 2.0));
  EXPECT_DOUBLE_EQ(errors.nees, (9.0 / 4.0 + 2.25 / 9.5) / 6.0);
  EXPECT_EQ(errors.points_missing, 0U);
}

TEST(CompareAnswersTest, HoldsTheClosedFormAgainstItsOwnDirections) {
  TradeoffAnswer closed = Answer(0.0, 6.0);
  closed.covariance_m2.clear();
  closed.sigma_across_m = {1.0, 1.0, 1.0};
  closed.sigma_up_m = {3.0, std::nan(""), 3.0};
  closed.across_azimuth_rad = {0.0, 0.0, 0.0};  // across is north: Q has diag(1, 9) there
  const AnswerErrors errors = CompareAnswers(
      ThreePoints(), closed, Answer(0.0, 0.0), std::vector<Eigen::Vector3d>(3, {0.0, 2.0, 3.0}));
  EXPECT_DOUBLE_EQ(errors.covariance_error, 0.0);
  EXPECT_EQ(errors.points_unjudged, 1U);
  EXPECT_DOUBLE_EQ(errors.nees, (4.0 / 1.0 + 9.0 / 9.0) / 2.0);
}

TEST(CompareAnswersTest, CountsPointsWithoutAPosition) {
  TradeoffAnswer answer = Answer(0.0, 0.0);
  answer.position_m[0].setConstant(std::nan(""));
  const AnswerErrors errors = CompareAnswers(
      ThreePoints(), answer, Answer(0.0, 0.0), std::vector<Eigen::Vector3d>(3, {0.0, 0.0, 0.0}));
  EXPECT_EQ(errors.points_missing, 1U);
}

TradeoffRow ChosenRow(const char* name,
                      double ratio,
                      double position_error,
                      double covariance_error) {
  TradeoffRow row;
  row.stage = TradeoffStage::kSolver;
  row.choice = name;
  row.points = 1000;
  row.wall_s = 0.5 / ratio;
  row.peak_mib = 7.0;
  row.speed_ratio = ratio;
  row.accepted = true;
  row.errors.position_error = position_error;
  row.errors.covariance_error = covariance_error;
  return row;
}

std::vector<std::string> Marked(std::vector<TradeoffRow> rows) {
  MarkPareto(&rows);
  std::vector<std::string> names;
  for (const TradeoffRow& row : rows) {
    if (row.pareto) names.push_back(row.choice);
  }
  return names;
}

TEST(MarkParetoTest, KeepsWhatIsFasterOrMoreAccurateThanAllOthers) {
  EXPECT_THAT(Marked({ChosenRow("reference", 1.0, 0.0, 0.0),
                      ChosenRow("fast", 3.0, 0.2, 0.1),
                      ChosenRow("slow", 0.5, 0.0, 0.0),
                      ChosenRow("beaten", 2.0, 0.3, 0.1),
                      ChosenRow("between", 2.0, 0.2, 0.05)}),
              ElementsAre("reference", "fast", "between"));
}

TEST(MarkParetoTest, TakesDifferencesThatNobodyNoticesForNone) {
  EXPECT_THAT(Marked({ChosenRow("reference", 1.0, 0.0, 0.0),
                      ChosenRow("as fast", 1.09, 9e-7, 9e-7),
                      ChosenRow("faster", 1.5, 9e-7, 9e-7)}),
              ElementsAre("faster"));
}

TEST(MarkParetoTest, LeavesOutWhatIsNotAcceptedOrMissesPoints) {
  TradeoffRow refused = ChosenRow("refused", 9.0, 0.0, 0.0), missing = refused, unjudged = refused;
  refused.accepted = false;
  missing.choice = "missing";
  missing.errors.points_missing = 1;
  unjudged.choice = "unjudged";  // fast, but the covariance of a point is not there
  unjudged.errors.points_unjudged = 1;
  EXPECT_THAT(Marked({ChosenRow("reference", 1.0, 0.0, 0.0), refused, missing, unjudged}),
              ElementsAre("reference", "unjudged"));
}

TEST(MarkParetoTest, KeepsStagesAndSizesApart) {
  TradeoffRow other = ChosenRow("other size", 1.0, 0.0, 0.0),
              stage = ChosenRow("stage", 1.0, 0.0, 0.0);
  other.points = 2000;
  stage.stage = TradeoffStage::kModel;
  EXPECT_THAT(Marked({ChosenRow("fast", 2.0, 0.0, 0.0), other, stage}),
              ElementsAre("fast", "other size", "stage"));
}

TEST(TradeoffTableTest, GivesEveryFigureBackToTheBit) {
  TradeoffRow row = ChosenRow("ceres", 0.1, 1.0 / 3.0, 2e-9);
  row.clock = TradeoffClock::kCpu;
  row.threads = 2;
  row.repeats = 3;
  row.looks = 4711;
  row.reference = true;
  row.errors.points_missing = 3;
  row.note = "two\nlines";
  std::vector<TradeoffRow> rows{row, ChosenRow("reduced", 1.0, 0.0, 0.0)};
  MarkPareto(&rows);
  const std::vector<TradeoffRow> back = TradeoffRowsOf(TradeoffTable(rows));
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].stage, TradeoffStage::kSolver);
  EXPECT_EQ(back[0].clock, TradeoffClock::kCpu);
  EXPECT_EQ(back[0].looks, 4711U);
  EXPECT_EQ(back[0].errors.position_error, 1.0 / 3.0);
  EXPECT_EQ(back[0].errors.points_missing, 3U);
  EXPECT_TRUE(back[0].reference);
  EXPECT_EQ(back[0].threads, 2);
  EXPECT_TRUE(std::isnan(back[0].errors.nees));
  EXPECT_FALSE(back[0].pareto);
  EXPECT_TRUE(back[1].pareto);
  EXPECT_EQ(back[0].note, "two lines");
  // A row alone does not say whether others beat it.
  EXPECT_EQ(StudyTable(TradeoffColumns(), {CellsOf(rows[1])}).rows()[0][9], StudyCell());
}

TEST(TradeoffTableTest, SaysOfARowThatWasNotRunWhyAndNoFigures) {
  TradeoffChoice choice;
  choice.stage = TradeoffStage::kSolver;
  choice.name = "ceres";
  choice.options.threads = 2;
  std::vector<TradeoffRow> rows{ChosenRow("reduced", 1.0, 0.0, 0.0),
                                NotRun(choice, 1000, TradeoffClock::kWall, "it takes an hour")};
  rows[0].repeats = 3;
  rows[0].looks = 4711;
  MarkPareto(&rows);
  EXPECT_TRUE(rows[0].pareto);
  EXPECT_FALSE(rows[1].pareto);
  const StudyTable table = TradeoffTable(rows);
  EXPECT_EQ(table.rows()[1][3], StudyCell());  // looks
  EXPECT_EQ(CellsOf(rows[1])[3], StudyCell());
  const std::vector<TradeoffRow> back = TradeoffRowsOf(table);
  EXPECT_EQ(back[1].repeats, 0);
  EXPECT_EQ(back[1].threads, 2);
  EXPECT_EQ(back[1].note, "not run: it takes an hour");
  EXPECT_THAT(TradeoffPage(back, {}),
              testing::AllOf(HasSubstr("4711 looks"),
                             HasSubstr("| solver | ceres | 2 |  |  |  |  |  |  |  | not run: it "
                                       "takes an hour |")));
}

TEST(RecommendTest, NamesTheFastestThatIsGoodEnough) {
  std::vector<TradeoffRow> rows{ChosenRow("ceres", 0.1, 0.0, 0.0),
                                ChosenRow("reduced", 1.0, 0.0, 0.0),
                                ChosenRow("loose", 2.0, 0.3, 0.0),
                                ChosenRow("block", 1.0, 0.0, 0.0),
                                ChosenRow("intersection", 1.3, 0.0, 0.6),
                                ChosenRow("leberl", 40.0, 12.0, 0.9)};
  rows[1].threads = 2;
  rows[3].stage = rows[4].stage = TradeoffStage::kCovariance;
  rows[5].stage = TradeoffStage::kModel;
  rows[5].errors.nees = 25.0;
  MarkPareto(&rows);
  EXPECT_EQ(Recommend(rows, 1000, {}),
            "1000 points: the fastest that are good enough are reduced, double, block: 0.5 s on 2 "
            "threads, 7 MiB beyond the block; "
            "leberl is 40 times faster, its positions up to 12 sigmas off, errors 5 times as large "
            "as it says");
  EXPECT_THAT(Recommend(rows, 1000, {1e-9, 0.05}), HasSubstr("no choice is good enough"));
}

TEST(RecommendTest, NamesTheFastestModelWhereTheStudyComparesModelsAlone) {
  std::vector<TradeoffRow> rows{ChosenRow("auto", 1.0, 0.0, 0.0),
                                ChosenRow("states", 2.0, 3.0, 0.0)};
  for (TradeoffRow& row : rows) row.stage = TradeoffStage::kModel;
  MarkPareto(&rows);
  EXPECT_EQ(Recommend(rows, 1000, {}),
            "1000 points: the fastest that is good enough is auto, 0.5 s on 1 thread");
  EXPECT_EQ(Recommend(rows, 1000, {1e-9, -1.0}), "1000 points: no model is good enough");
}

}  // namespace
}  // namespace sarblock
