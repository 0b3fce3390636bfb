// SPDX-License-Identifier: Apache-2.0
// What `auto` stands for, held against the recorded study of speed against accuracy
// (datasets/studies/tradeoff, docs/studies/tradeoff.md). Evidence: recorded measurements; nothing
// is timed here.
#include "sarblock/adjust/engine_choice.h"
#include "sarblock/io/study_rows.h"
#include "sarblock/io/tradeoff_study.h"
#include "sarblock/study/tradeoff_report.h"
#include "sarblock/study/tradeoff_table.h"

#include <algorithm>
#include <string>
#include <vector>

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
std::string RowOf(Engine engine) { return engine == Engine::kReduced ? "reduced" : "ceres"; }
std::string RowOf(CovarianceMethod method) {
  return method == CovarianceMethod::kReduced ? "block" : "block-ceres";
}

TEST(RecordedTradeoffTest, AutoStandsForChoicesThatNothingBeats) {
  const std::vector<TradeoffRow> rows = Recorded();
  ASSERT_GE(SizesOf(rows).size(), 3U);
  for (const std::size_t points : SizesOf(rows)) {
    SCOPED_TRACE(points);
    const TradeoffRow* engine =
        Find(rows, TradeoffStage::kSolver, points, RowOf(Resolve(Engine::kAuto)));
    ASSERT_NE(engine, nullptr);
    EXPECT_TRUE(engine->pareto) << engine->choice;
    const TradeoffRow* method =
        Find(rows, TradeoffStage::kCovariance, points, RowOf(Resolve(CovarianceMethod::kAuto)));
    ASSERT_NE(method, nullptr);
    EXPECT_TRUE(method->pareto) << method->choice;
  }
}

TEST(RecordedTradeoffTest, TheModelThatAutoChoseIsOneThatNothingBeats) {
  const std::vector<TradeoffRow> rows = Recorded();
  for (const std::size_t points : SizesOf(rows)) {
    SCOPED_TRACE(points);
    const TradeoffRow* chosen = Find(rows, TradeoffStage::kModel, points, "auto");
    if (chosen == nullptr) continue;
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
    for (const TradeoffEntry& entry : study.choices) {
      if (!study.Wants(entry, points)) continue;
      EXPECT_NE(Find(rows, entry.choice.stage, points, entry.choice.name), nullptr)
          << points << ' ' << entry.choice.name;
    }
  }
}

}  // namespace
}  // namespace sarblock
