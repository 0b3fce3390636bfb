// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/threads.h"
#include "studies/study.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// Keeps rows in memory and counts.
class MemoryStore final : public StudyStore {
 public:
  [[nodiscard]] const std::vector<StudyRow>* Find(std::size_t task) const override {
    const auto found = rows.find(task);
    return found == rows.end() ? nullptr : &found->second;
  }
  void Keep(std::size_t task, const std::vector<StudyRow>& kept) override { rows[task] = kept; }
  std::map<std::size_t, std::vector<StudyRow>> rows;
};

/// Cancelled once `after` tasks were reported.
class StopAfter final : public ProgressSink {
 public:
  explicit StopAfter(std::size_t after) : after_(after) {}
  void Update(std::string_view, std::size_t done, std::size_t, std::string_view) override {
    if (done >= after_) cancelled_ = true;
  }
  [[nodiscard]] bool Cancelled() const override { return cancelled_; }

 private:
  std::size_t after_;
  std::atomic<bool> cancelled_{false};
};

/// Task i gives i % 3 rows of i, i^2 and a name; each has a loop of its own inside.
StudyPlan Squares(std::size_t tasks, std::atomic<int>* computed) {
  StudyPlan plan;
  plan.columns = {{"n", StudyCellKind::kInteger},
                  {"square", StudyCellKind::kNumber},
                  {"name", StudyCellKind::kText}};
  for (std::size_t i = 0; i < tasks; ++i) {
    plan.tasks.push_back({"task " + std::to_string(i), [i, computed](ProgressSink*) {
                            ++*computed;
                            std::vector<double> parts(200);
                            ParallelForChunks(
                                parts.size(), 1, [&](std::size_t k, std::size_t, std::size_t) {
                                  parts[k] = static_cast<double>(i * i) / 200.0;
                                });
                            double sum = 0.0;
                            for (const double part : parts) sum += part;
                            std::vector<StudyRow> rows;
                            for (std::size_t k = 0; k < i % 3; ++k) {
                              rows.push_back({static_cast<std::int64_t>(i), sum, std::string("r")});
                            }
                            return rows;
                          }});
  }
  return plan;
}

TEST(StudyTableTest, RowsAreInTheOrderOfTheTasksWithAnyNumberOfThreads) {
  std::atomic<int> computed{0};
  const StudyPlan plan = Squares(30, &computed);
  const ThreadLimit one(1);
  const StudyTable serial = RunStudy(plan);
  ASSERT_EQ(serial.size(), 30u);  // ten times 0 + 1 + 2
  EXPECT_EQ(serial.Number(0, "n"), 1.0);
  EXPECT_EQ(serial.Number(1, "n"), 2.0);
  EXPECT_EQ(serial.Number(2, "n"), 2.0);
  EXPECT_NEAR(serial.Number(29, "square"), 841.0, 1e-9);
  EXPECT_EQ(serial.Text(0, "name"), "r");
}

TEST(StudyTableTest, ThreadsChangeNoCell) {
  std::atomic<int> computed{0};
  const StudyPlan plan = Squares(30, &computed);
  const StudyTable parallel = RunStudy(plan);
  StudyPlan in_turn = plan;
  in_turn.order = TaskOrder::kOneByOne;
  EXPECT_EQ(RunStudy(in_turn).rows(), parallel.rows());
  EXPECT_EQ(computed, 60);
}

TEST(StudyTableTest, AnInterruptedStudyKeepsWhatWasFinishedAndGoesOnFromThere) {
  std::atomic<int> computed{0};
  const StudyPlan plan = Squares(24, &computed);
  MemoryStore store;
  StopAfter stop(5);
  EXPECT_THROW(static_cast<void>(RunStudy(plan, &store, &stop)), Interrupted);
  const std::size_t kept = store.rows.size();
  EXPECT_GE(kept, 5u);
  EXPECT_LT(kept, 24u);
  computed = 0;
  const StudyTable resumed = RunStudy(plan, &store);
  EXPECT_EQ(computed, static_cast<int>(24 - kept));
  EXPECT_EQ(resumed.rows(), RunStudy(plan).rows());
}

TEST(StudyTableTest, RefusesCellsThatDoNotFitTheirColumn) {
  StudyPlan plan;
  plan.columns = {{"value", StudyCellKind::kNumber}};
  StudyRow row;
  plan.tasks = {{"", [&row](ProgressSink*) { return std::vector<StudyRow>{row}; }}};
  for (const StudyRow& bad : {StudyRow{},
                              StudyRow{std::string("text")},
                              StudyRow{std::numeric_limits<double>::quiet_NaN()},
                              StudyRow{1.5, 2.5}}) {
    row = bad;
    EXPECT_THROW(static_cast<void>(RunStudy(plan)), std::logic_error);
  }
  row = {StudyCell{}};
  EXPECT_TRUE(std::isnan(RunStudy(plan).Number(0, "value")));
  EXPECT_THROW(static_cast<void>(RunStudy(plan).Number(0, "other")), std::logic_error);
}

}  // namespace
}  // namespace sarblock
