// SPDX-License-Identifier: Apache-2.0
#include "sarblock/simulate/simulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "report/svg_plot.h"
#include "studies/tradeoff.h"
#include "studies/tradeoff_study.h"
#include "study_command.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

constexpr std::array kStages{TradeoffStage::kModel,
                             TradeoffStage::kSolver,
                             TradeoffStage::kCovariance,
                             TradeoffStage::kPrecision};
/// Measures rows; holds the block of the size at hand, simulated when its first row is measured.
class Bench {
 public:
  Bench(TradeoffStudy study, int threads) : study_(std::move(study)), threads_(threads) {}

  [[nodiscard]] const TradeoffStudy& study() const { return study_; }

  std::vector<StudyRow> Measure(const TradeoffSize& size,
                                const TradeoffEntry& entry,
                                ProgressSink* progress) {
    const std::string reason = study_.WhyNotRun(entry, size);
    if (!reason.empty()) {
      TradeoffChoice choice = entry.choice;
      choice.options.threads = entry.ThreadsOf(threads_);
      return {CellsOf(NotRun(choice, size.points, study_.clock, reason))};
    }
    Prepare(size, progress);
    const int repeats = entry.repeats > 0  ? entry.repeats
                        : size.repeats > 0 ? size.repeats
                                           : study_.repeats;
    return {CellsOf(
        bench_->Measure(Bound(entry, size, bench_->block()),
                        Bound(study_.ReferenceOf(entry.choice.stage), size, bench_->block()),
                        {repeats, size.longest_s},
                        study_.clock,
                        progress))};
  }

 private:
  [[nodiscard]] TradeoffChoice Bound(const TradeoffEntry& entry,
                                     const TradeoffSize& size,
                                     const Block& block) const {
    return BindChoice(entry, size.scene, block, threads_);
  }

  void Prepare(const TradeoffSize& size, ProgressSink* progress) {
    if (bench_ != nullptr && points_ == size.points) return;
    bench_.reset();
    SimulatedBlock simulated = Simulate(size.scene, progress);
    // The best answer: the first reference that adjusts. The reader has seen to it that one does.
    const auto best =
        std::find_if(study_.choices.begin(), study_.choices.end(), [](const TradeoffEntry& entry) {
          return entry.reference && entry.choice.run == TradeoffChoice::Run::kAdjust;
        });
    const TradeoffChoice tight = Bound(*best, size, simulated.block);
    bench_ = std::make_unique<TradeoffBench>(std::move(simulated), size.points, tight, progress);
    points_ = size.points;
  }

  TradeoffStudy study_;
  int threads_ = 1;
  std::unique_ptr<TradeoffBench> bench_;
  std::size_t points_ = 0;
};

/// Choices of a stage in the order of the rows.
std::vector<std::string> ChoicesOf(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  std::vector<std::string> names;
  for (const TradeoffRow& row : rows) {
    if (row.stage != stage) continue;
    if (std::find(names.begin(), names.end(), row.choice) == names.end()) {
      names.push_back(row.choice);
    }
  }
  return names;
}

/// The error that a stage is about: of the covariance there, of positions in all others. Never
/// below the floor of the plot: what counts as equal, or where digits are the matter the last one.
double ErrorOf(const TradeoffRow& row) {
  const double error_1 = row.stage == TradeoffStage::kCovariance ? row.errors.covariance_error_1
                                                                 : row.errors.position_error_1;
  const bool digits = row.stage == TradeoffStage::kSolver || row.stage == TradeoffStage::kPrecision;
  return std::max(error_1, digits ? 1e-16 : kSamePosition_1);
}

/// A line a choice through its sizes.
template <typename PointOf>
std::string Draw(Plot plot,
                 const std::vector<TradeoffRow>& rows,
                 TradeoffStage stage,
                 const PointOf& point_of) {
  plot.x.scale = plot.y.scale = PlotScale::kLog;
  for (const std::string& choice : ChoicesOf(rows, stage)) {
    PlotSeries series;
    series.name = choice;
    SetStyle(plot.series.size(), &series);
    for (const TradeoffRow& row : rows) {
      if (row.stage != stage || row.choice != choice) continue;
      const std::array<double, 2> point = point_of(row);
      if (std::isfinite(point[0]) && std::isfinite(point[1])) series.points.push_back(point);
    }
    plot.series.push_back(std::move(series));
  }
  return SvgOf(plot);
}

std::string PlotError(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  Plot plot;
  plot.title = fmt::format("{}: error against speed", NameOf(stage));
  plot.x.label = fmt::format("speed by {} time, reference = 1",
                             rows.front().clock == TradeoffClock::kWall ? "wall" : "CPU");
  plot.y.label = stage == TradeoffStage::kCovariance ? "largest relative error of a 3 x 3"
                                                     : "largest shift [sigma]";
  plot.notes = {"a line: one choice,", "from small to large"};
  return Draw(std::move(plot), rows, stage, [](const TradeoffRow& row) {
    return std::array{row.speed_ratio_1, ErrorOf(row)};
  });
}

std::string PlotTime(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  const bool wall = rows.front().clock == TradeoffClock::kWall;
  Plot plot;
  plot.title = fmt::format("{}: time", NameOf(stage));
  plot.x.label = "points";
  plot.y.label = wall ? "wall time [s]" : "CPU time [s]";
  return Draw(std::move(plot), rows, stage, [wall](const TradeoffRow& row) {
    return std::array{static_cast<double>(row.points), wall ? row.wall_s : row.cpu_s};
  });
}

StudyAnswer ConcludeTradeoff(const TradeoffStudy& study, const StudyTable& table) {
  std::vector<TradeoffRow> rows = TradeoffRowsOf(table);
  MarkPareto(&rows);
  StudyAnswer answer;
  for (const std::size_t points : SizesOf(rows)) {
    answer.words.push_back(Recommend(rows, points, study.goal));
  }
  answer.table = TradeoffTable(rows);
  answer.files.emplace_back("tradeoff.md", TradeoffPage(rows, study.goal));
  for (const TradeoffStage stage : kStages) {
    if (ChoicesOf(rows, stage).empty()) continue;
    const std::string name = fmt::format("tradeoff_{}", NameOf(stage));
    answer.files.emplace_back(name + "_error.svg", PlotError(rows, stage));
    answer.files.emplace_back(name + "_time.svg", PlotTime(rows, stage));
  }
  return answer;
}

}  // namespace

PreparedStudy PrepareTradeoff(const std::string& file,
                              const std::vector<std::string>& overrides,
                              int threads) {
  const auto bench = std::make_shared<Bench>(ReadTradeoffStudy(file, overrides), threads);
  const TradeoffStudy& study = bench->study();
  PreparedStudy prepared;
  prepared.plan.columns = TradeoffColumns();
  prepared.plan.order = TaskOrder::kOneByOne;
  for (const TradeoffSize& size : study.sizes) {
    for (const TradeoffEntry& entry : study.choices) {
      if (!study.Wants(entry, size.points)) continue;
      prepared.plan.tasks.push_back(
          {fmt::format(
               "{} {}, {} points", NameOf(entry.choice.stage), entry.choice.name, size.points),
           [bench, &size, &entry](ProgressSink* progress) {
             return bench->Measure(size, entry, progress);
           }});
    }
  }
  prepared.identity = study.identity;
  prepared.conclude = [bench](const StudyTable& table, ProgressSink*) {
    return ConcludeTradeoff(bench->study(), table);
  };
  return prepared;
}

}  // namespace sarblock::cli
