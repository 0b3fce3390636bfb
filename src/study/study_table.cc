// SPDX-License-Identifier: Apache-2.0
#include "study/study_table.h"

#include "sarblock/core/error.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "core/threads.h"

namespace sarblock {
namespace {

/// What a task sees of the caller's sink: whether to stop, and nothing of its bar.
class QuietSink final : public ProgressSink {
 public:
  explicit QuietSink(const ProgressSink* sink) : sink_(sink) {}
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {}
  [[nodiscard]] bool Cancelled() const override { return sink_ != nullptr && sink_->Cancelled(); }

 private:
  const ProgressSink* sink_;
};

bool Fits(const StudyCell& cell, StudyCellKind kind) {
  if (std::holds_alternative<std::monostate>(cell)) return true;
  switch (kind) {
    case StudyCellKind::kNumber:
      return std::holds_alternative<double>(cell) && std::isfinite(std::get<double>(cell));
    case StudyCellKind::kInteger:
      return std::holds_alternative<std::int64_t>(cell);
    case StudyCellKind::kText:
      break;
  }
  return std::holds_alternative<std::string>(cell) &&
         std::get<std::string>(cell).find_first_of("\r\n") == std::string::npos;
}

void RequireFit(const StudyRow& row, const std::vector<StudyColumn>& columns) {
  if (row.size() != columns.size()) throw std::logic_error("a row of a study lacks cells");
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (!Fits(row[i], columns[i].kind)) {
      throw std::logic_error("a cell of a study does not fit its column " + columns[i].name);
    }
  }
}

/// Tasks begun in their order, kept one at a time.
class Runner {
 public:
  Runner(const StudyPlan& plan, StudyStore* store, ProgressSink* progress, TaskPart part)
      : plan_(plan), store_(store), progress_(progress), rows_(plan.tasks.size()) {
    for (std::size_t i = part.index; i < plan.tasks.size(); i += part.count) {
      ++tasks_;
      const std::vector<StudyRow>* kept = store == nullptr ? nullptr : store->Find(i);
      if (kept == nullptr) {
        missing_.push_back(i);
      } else {
        for (const StudyRow& row : *kept) RequireFit(row, plan.columns);
        rows_[i] = *kept;
      }
    }
  }

  StudyTable Run() {
    Show({});
    if (plan_.order == TaskOrder::kOneByOne) {
      for (std::size_t i = 0; i < missing_.size(); ++i) RunNext();
    } else {
      // A piece takes the next task, whichever piece it is, so that tasks begin in their order.
      ParallelForChunks(missing_.size(), 1, [this](std::size_t, std::size_t, std::size_t) {
        RunIsolated([this] { RunNext(); });
      });
    }
    std::vector<StudyRow> all;
    for (std::vector<StudyRow>& rows : rows_) {
      for (StudyRow& row : rows) all.push_back(std::move(row));
    }
    return {plan_.columns, std::move(all)};
  }

 private:
  void Show(const std::string& detail) {
    sarblock::Step(progress_, "study", tasks_ - missing_.size() + done_, tasks_, detail);
  }

  void RunNext() {
    const std::size_t index = missing_[next_.fetch_add(1)];
    const StudyTask& task = plan_.tasks[index];
    QuietSink quiet(progress_);
    if (quiet.Cancelled()) throw Interrupted("study");
    std::vector<StudyRow> rows = task.compute(&quiet);
    for (const StudyRow& row : rows) RequireFit(row, plan_.columns);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (store_ != nullptr) store_->Keep(index, rows);
    rows_[index] = std::move(rows);
    ++done_;
    Show(task.name);
  }

  const StudyPlan& plan_;
  StudyStore* store_;
  ProgressSink* progress_;
  std::vector<std::vector<StudyRow>> rows_;
  std::vector<std::size_t> missing_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::size_t tasks_ = 0, done_ = 0;
};

}  // namespace

StudyTable::StudyTable(std::vector<StudyColumn> columns, std::vector<StudyRow> rows)
    : columns_(std::move(columns)), rows_(std::move(rows)) {
  for (const StudyRow& row : rows_) RequireFit(row, columns_);
}

const StudyCell& StudyTable::Cell(std::size_t row, std::string_view column) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (columns_[i].name == column) return rows_.at(row)[i];
  }
  throw std::logic_error("a study has no column " + std::string(column));
}

double StudyTable::Number(std::size_t row, std::string_view column) const {
  const StudyCell& cell = Cell(row, column);
  if (const auto* number = std::get_if<double>(&cell)) return *number;
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return static_cast<double>(*integer);
  if (std::holds_alternative<std::monostate>(cell)) return std::numeric_limits<double>::quiet_NaN();
  throw std::logic_error("column " + std::string(column) + " holds text");
}

std::string StudyTable::Text(std::size_t row, std::string_view column) const {
  const StudyCell& cell = Cell(row, column);
  if (std::holds_alternative<std::monostate>(cell)) return {};
  return std::get<std::string>(cell);
}

std::string NameOfStudy(const TaskPart& part) {
  return part.IsWhole() ? "a whole study" : NameOf(part);
}

StudyTable RunStudy(const StudyPlan& plan,
                    StudyStore* store,
                    ProgressSink* progress,
                    TaskPart part) {
  return Runner(plan, store, progress, part).Run();
}

}  // namespace sarblock
