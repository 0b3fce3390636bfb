// SPDX-License-Identifier: Apache-2.0
// What `auto` stands for, held against the recorded study of speed against accuracy
// (datasets/studies/tradeoff, docs/studies/tradeoff.md). Evidence: recorded measurements; nothing
// is timed here.
#include <algorithm>
#include <string>
#include <vector>

#include "solve/reduced_engine.h"
#include "studies/study.h"
#include "studies/tradeoff.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

std::vector<TradeoffRow> Recorded() {
  return TradeoffRowsOf(ReadStudyTable(
      std::string(SARBLOCK_DATASETS) + "/studies/tradeoff/tradeoff.csv", TradeoffColumns()));
}

const TradeoffRow* Find(const std::vector<TradeoffRow>& rows,
                        TradeoffStage stage,
                        std::size_t points,
                        const std::string& choice) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const TradeoffRow& row) {
    return row.stage == stage && row.points == points && row.choice == choice;
  });
  return found == rows.end() ? nullptr : &*found;
}

/// Names of the rows in the shipped study.
std::string RowOf(Engine engine, CeresSolver solver) {
  if (engine == Engine::kReduced) return "reduced";
  return solver == CeresSolver::kDenseSchur    ? "ceres-dense"
         : solver == CeresSolver::kSparseSchur ? "ceres-sparse"
                                               : "ceres-iterative";
}
std::string RowOf(CovarianceMethod method) {
  return method == CovarianceMethod::kReduced ? "block" : "block-ceres";
}

/// The rows but those that differ from others in their threads alone, with the marks of these: how
/// many threads there are is not for `auto` to choose.
std::vector<TradeoffRow> RecordedForAuto() {
  std::vector<TradeoffRow> rows = Recorded();
  std::erase_if(rows, [](const TradeoffRow& row) { return row.choice.ends_with("-1-thread"); });
  MarkPareto(&rows);
  return rows;
}

TEST(RecordedTradeoffTest, AutoTakesChoicesThatNothingBeats) {
  const std::vector<TradeoffRow> rows = RecordedForAuto();
  ASSERT_GE(SizesOf(rows).size(), 3U);
  for (const std::size_t points : SizesOf(rows)) {
    SCOPED_TRACE(points);
    const TradeoffRow* reference = Find(rows, TradeoffStage::kSolver, points, "reduced");
    ASSERT_NE(reference, nullptr);
    const CeresSolver solver =
        Resolve(CeresSolver::kAuto, static_cast<int>(reference->corrections));
    // The default tolerance is that of this row too.
    const TradeoffRow* engine =
        Find(rows, TradeoffStage::kSolver, points, RowOf(Resolve(Engine::kAuto), solver));
    ASSERT_NE(engine, nullptr);
    EXPECT_TRUE(engine->pareto) << engine->choice;
    const TradeoffRow* method =
        Find(rows, TradeoffStage::kCovariance, points, RowOf(Resolve(CovarianceMethod::kAuto)));
    ASSERT_NE(method, nullptr);
    EXPECT_TRUE(method->pareto) << method->choice;
  }
}

// Ceres' rows of the same threads and tolerance against each other.
TEST(RecordedTradeoffTest, TheCeresSolverOfAutoIsOneThatNoOtherBeats) {
  std::vector<TradeoffRow> rows;
  for (const TradeoffRow& row : Recorded()) {
    if (row.choice == "ceres-dense" || row.choice == "ceres-sparse" ||
        row.choice == "ceres-iterative") {
      rows.push_back(row);
    }
  }
  MarkPareto(&rows);
  std::size_t fixed = 0;
  for (const std::size_t points : SizesOf(rows)) {
    SCOPED_TRACE(points);
    std::size_t corrections = 0;
    for (const TradeoffRow& row : rows) {
      if (row.points == points) corrections = std::max(corrections, row.corrections);
    }
    if (corrections == 0) continue;  // none was run
    const TradeoffRow* of_auto =
        Find(rows,
             TradeoffStage::kSolver,
             points,
             RowOf(Engine::kCeres, Resolve(CeresSolver::kAuto, static_cast<int>(corrections))));
    ASSERT_NE(of_auto, nullptr);
    EXPECT_TRUE(of_auto->pareto) << of_auto->choice;
    ++fixed;
  }
  EXPECT_GE(fixed, 3U);
}

// A row of one thread has the answer of the row of two: what a thread changes is time.
TEST(RecordedTradeoffTest, ThreadsChangeNoAnswer) {
  const std::vector<TradeoffRow> rows = Recorded();
  std::size_t fixed = 0;
  for (const TradeoffRow& one : rows) {
    const std::size_t at = one.choice.find("-1-thread");
    if (at == std::string::npos || one.repeats == 0) continue;
    const TradeoffRow* two = Find(rows, one.stage, one.points, one.choice.substr(0, at));
    ASSERT_NE(two, nullptr);
    EXPECT_EQ(one.threads, 1);
    EXPECT_NEAR(one.errors.position_error, two->errors.position_error, kSamePosition);
    EXPECT_NEAR(one.errors.covariance_error, two->errors.covariance_error, kSameCovariance);
    ++fixed;
  }
  EXPECT_GE(fixed, 3U);
}

// What a tolerance promises, the answers hold: no point is further off than all unknowns together.
TEST(RecordedTradeoffTest, AnswersOfEveryToleranceAreWithinIt) {
  for (const TradeoffRow& row : Recorded()) {
    if (row.stage != TradeoffStage::kSolver || row.repeats == 0) continue;
    const double tolerance = row.choice.ends_with("1e-3")   ? 1e-3
                             : row.choice.ends_with("1e-9") ? 1e-9
                                                            : AdjustOptions{}.tolerance;
    EXPECT_TRUE(row.accepted);
    // The best answer has kBestTolerance to go itself.
    EXPECT_LE(row.errors.position_error, tolerance + kBestTolerance)
        << row.points << ' ' << row.choice;
  }
}

TEST(RecordedTradeoffTest, TheModelThatAutoChoseIsOneThatNothingBeats) {
  const std::vector<TradeoffRow> rows = Recorded();
  for (const std::size_t points : SizesOf(rows)) {
    SCOPED_TRACE(points);
    const TradeoffRow* chosen = Find(rows, TradeoffStage::kModel, points, "auto");
    if (chosen == nullptr || chosen->repeats == 0) continue;
    EXPECT_TRUE(chosen->accepted);
    // "chose position.across.0 position.across.1 ...": the highest degree names the row.
    const char* row = chosen->note.find(".2") != std::string::npos   ? "quadratic"
                      : chosen->note.find(".1") != std::string::npos ? "linear"
                                                                     : "constant";
    const TradeoffRow* same = Find(rows, TradeoffStage::kModel, points, row);
    ASSERT_NE(same, nullptr);
    EXPECT_TRUE(same->pareto) << chosen->note;
  }
}

TEST(RecordedTradeoffTest, TheMarksOfTheTableAreThoseOfItsFigures) {
  const std::vector<TradeoffRow> rows = Recorded();
  std::vector<TradeoffRow> again = rows;
  MarkPareto(&again);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(again[i].pareto, rows[i].pareto) << rows[i].points << ' ' << rows[i].choice;
  }
}

TEST(RecordedTradeoffTest, TheShippedStudyHasEveryRowThatWasRecorded) {
  const TradeoffStudy study =
      ReadTradeoffStudy(std::string(SARBLOCK_DATASETS) + "/studies/tradeoff.toml");
  const std::vector<TradeoffRow> rows = Recorded();
  for (const std::size_t points : SizesOf(rows)) {
    const auto size = std::find_if(study.sizes.begin(),
                                   study.sizes.end(),
                                   [&](const TradeoffSize& one) { return one.points == points; });
    ASSERT_NE(size, study.sizes.end()) << points;
    for (const TradeoffEntry& entry : study.choices) {
      const TradeoffRow* row = Find(rows, entry.choice.stage, points, entry.choice.name);
      ASSERT_NE(row, nullptr) << points << ' ' << entry.choice.name;
      EXPECT_EQ(row->repeats == 0, !study.WhyNotRun(entry, *size).empty()) << row->note;
    }
  }
}

}  // namespace
}  // namespace sarblock
