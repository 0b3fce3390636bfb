// SPDX-License-Identifier: Apache-2.0
#include "studies/study.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "manual.h"
#include "program.h"
#include "report/svg_plot.h"
#include "session.h"
#include "studies/densification.h"
#include "studies/design.h"
#include "studies/design_law.h"
#include "studies/stability.h"
#include "studies/tradeoff.h"
#include "study_plots.h"
#include <fmt/core.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

/// What a study says beside its table.
struct StudyAnswer {
  std::vector<std::string> words;   ///< lines for people, also written to NAME.txt
  std::vector<std::string> tables;  ///< lines printed above them: tables for a terminal
  /// Further files of the folder, name and content: plots, more tables.
  std::vector<StudyFile> files;
  /// The table with the columns that need all rows, where the kind has such: written in place of
  /// the one that grew.
  std::optional<StudyTable> table;
};

/// A study read from its file, ready to run.
struct PreparedStudy {
  StudyPlan plan;
  /// Everything that the rows are a function of, as text: EffectiveStudyText and the texts of the
  /// scenes it names. A folder with rows of another identity is not resumed.
  std::string identity;
  std::function<StudyAnswer(const StudyTable& table)> conclude;
};

/// One kind of study: `sarblock study NAME STUDY.toml -o DIR` writes DIR/NAME.csv. Everything but
/// these two functions is common: the options, the threads, resuming, the files.
struct StudyKind {
  const char* name;
  const char* help;
  /// `threads` are those of the session, for tasks that run one by one.
  PreparedStudy (*prepare)(const std::string& file,
                           const std::vector<std::string>& overrides,
                           int threads);
  /// Dotted keys of the study file that `--set` may name.
  std::vector<std::string> (*keys)();
  bool divisible;  ///< whether parts of it may be computed apart
};

constexpr std::array kStages{
    TradeoffStage::kModel, TradeoffStage::kSolver, TradeoffStage::kCovariance};

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

/// The error that a stage trades: of the covariance in that stage, of positions in all others. At
/// least the floor of the plot: the limit of equality, or the last digit where digits are compared.
double ErrorOf(const TradeoffRow& row) {
  const double error = row.stage == TradeoffStage::kCovariance ? row.errors.covariance_error
                                                               : row.errors.position_error;
  return std::max(error, row.stage == TradeoffStage::kSolver ? 1e-16 : kSamePosition);
}

/// A line a choice through its sizes.
template <typename PointOf>
Plot Draw(Plot plot,
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
  return plot;
}

Plot PlotError(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
  Plot plot;
  plot.title = fmt::format("{}: error against speed", NameOf(stage));
  plot.x.label = fmt::format("speed by {} time, reference = 1",
                             rows.front().clock == TradeoffClock::kWall ? "wall" : "CPU");
  plot.y.label = stage == TradeoffStage::kCovariance ? "largest relative error of a 3 x 3"
                                                     : "largest shift [sigma]";
  plot.notes = {"a line: one choice,", "from small to large"};
  return Draw(std::move(plot), rows, stage, [](const TradeoffRow& row) {
    return std::array{row.speed_ratio, ErrorOf(row)};
  });
}

Plot PlotTime(const std::vector<TradeoffRow>& rows, TradeoffStage stage) {
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
  std::vector<PlotPanel> errors, times;
  for (const TradeoffStage stage : kStages) {
    if (ChoicesOf(rows, stage).empty()) continue;
    errors.emplace_back(PlotError(rows, stage));
    times.emplace_back(PlotTime(rows, stage));
  }
  answer.files.emplace_back("tradeoff_error.svg", SvgOf(errors, 1));
  answer.files.emplace_back("tradeoff_time.svg", SvgOf(times, 1));
  return answer;
}

PreparedStudy PrepareTradeoff(const std::string& file,
                              const std::vector<std::string>& overrides,
                              int threads) {
  const auto study = std::make_shared<TradeoffStudy>(ReadTradeoffStudy(file, overrides));
  return {PlanTradeoff(*study, threads), study->identity, [study](const StudyTable& table) {
            return ConcludeTradeoff(*study, table);
          }};
}

StudyAnswer ConcludeDensification(const DensificationStudy& study, const StudyTable& table) {
  return {DescribeDensification(study, table), {}, PlotsOf(study, table), {}};
}

PreparedStudy PrepareDensification(const std::string& file,
                                   const std::vector<std::string>& overrides,
                                   int /*threads*/) {
  const auto read = std::make_shared<DensificationFile>(ReadDensification(file, overrides));
  return {PlanDensification(read->study), read->identity, [read](const StudyTable& table) {
            return ConcludeDensification(read->study, table);
          }};
}

StudyAnswer ConcludeDesign(const DesignStudy& study, const StudyTable& table) {
  StudyAnswer answer;
  answer.words = DescribeDesign(study, table);
  const StudyTable marked = MarkPareto(study, table);
  answer.tables = DesignTables(study, marked);
  answer.files = PlotsOf(study, marked);
  if (study.law) {
    const std::vector<FittedLaw> laws = FitLaws(study, marked);
    for (std::string& line : LawLines(study, laws)) answer.tables.push_back(std::move(line));
    for (std::string& line : DescribeLaws(study, laws)) answer.words.push_back(std::move(line));
    answer.files.emplace_back("design_law.csv", StudyTableText(LawTable(study, laws)));
  }
  if (study.prices.Given()) answer.table = marked;
  return answer;
}

PreparedStudy PrepareDesign(const std::string& file,
                            const std::vector<std::string>& overrides,
                            int /*threads*/) {
  const auto read = std::make_shared<DesignFile>(ReadDesign(file, overrides));
  return {PlanDesign(read->study), read->identity, [read](const StudyTable& table) {
            return ConcludeDesign(read->study, table);
          }};
}

/// Digits of a column against the condition, a marker a row.
PlotSeries DigitsAgainstCondition(const StudyTable& table,
                                  const char* column,
                                  const char* name,
                                  std::size_t colour) {
  PlotSeries series;
  series.name = name;
  series.mark = PlotMark::kMarkers;
  series.colour = colour;
  for (std::size_t row = 0; row < table.size(); ++row) {
    series.points.push_back({table.Number(row, "condition"), table.Number(row, column)});
  }
  return series;
}

/// The decades that cover every condition of the table.
double LargestCondition(const StudyTable& table) {
  double largest = 10.0;
  for (std::size_t row = 0; row < table.size(); ++row) {
    // NaN leaves it as it is.
    largest = std::fmax(largest, table.Number(row, "condition"));
  }
  return std::pow(10.0, std::ceil(std::log10(largest)));
}

PlotAxis Condition(double largest) {
  return {.label = "condition k of the column-scaled Jacobian",
          .scale = PlotScale::kLog,
          .range = {{1.0, largest}}};
}

/// A line without markers in black.
PlotSeries Line(const char* name, PlotDash dash, std::vector<std::array<double, 2>> points) {
  PlotSeries series;
  series.name = name;
  series.mark = PlotMark::kLine;
  series.dash = dash;
  series.colour = PlotSeries::kBlack;
  series.points = std::move(points);
  return series;
}

/// Digits that a rounding of `digits` leaves where the condition counts with its `power`.
PlotSeries Law(const char* name, PlotDash dash, double digits, double power, double largest) {
  const double end = std::min(largest, std::pow(10.0, digits / power));
  return Line(name, dash, {{1.0, digits}, {end, digits - power * std::log10(end)}});
}

std::string PlotMethods(const StudyTable& table) {
  const double largest = LargestCondition(table);
  Plot plot;
  plot.title = "Digits of the covariance by method";
  plot.x = Condition(largest);
  plot.y = {.label = "correct digits of the worst 3 x 3 block", .range = {{0.0, 16.0}}};
  plot.series = {DigitsAgainstCondition(table, "covariance_digits", "production", 0),
                 DigitsAgainstCondition(table, "normal_digits", "all normals, double", 1),
                 DigitsAgainstCondition(table, "ceres_digits", "Ceres, sparse QR", 2),
                 DigitsAgainstCondition(table, "single_digits", "all normals, single", 3),
                 Law("16 - log k", PlotDash::kSolid, 16.0, 1.0, largest),
                 Law("16 - 2 log k", PlotDash::kDashed, 16.0, 2.0, largest),
                 Law("7.2 - 2 log k", PlotDash::kDotted, 7.2, 2.0, largest)};
  return SvgOf(plot);
}

std::string PlotErrors(const StudyTable& table) {
  const double largest = LargestCondition(table);
  Plot plot;
  plot.title = "Largest error of a position or correction";
  plot.x = Condition(largest);
  plot.y = {.label = "error [sigma]", .scale = PlotScale::kLog, .range = {}};
  constexpr std::array kOutcomes = {std::pair{StabilityOutcome::kOk, 0u},
                                    std::pair{StabilityOutcome::kWarned, 3u},
                                    std::pair{StabilityOutcome::kWrong, 4u}};
  for (const auto& [outcome, colour] : kOutcomes) {
    PlotSeries series;
    series.name = NameOf(outcome);
    series.mark = PlotMark::kMarkers;
    series.colour = colour;
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (table.Text(row, "outcome") != series.name) continue;
      series.points.push_back({table.Number(row, "condition"), table.Number(row, "error_sigma")});
    }
    plot.series.push_back(std::move(series));
  }
  plot.series.push_back(
      Line("wrong unless warned of", PlotDash::kDashed, {{1.0, kMaxError}, {largest, kMaxError}}));
  return SvgOf(plot);
}

PreparedStudy PrepareStability(const std::string& file,
                               const std::vector<std::string>& overrides,
                               int /*threads*/) {
  const auto study = std::make_shared<StabilityStudy>(ReadStability(file, overrides));
  return {PlanStability(*study),
          EffectiveStudyText(file, overrides),
          [study](const StudyTable& table) -> StudyAnswer {
            return {DescribeStability(*study, table),
                    {},
                    {{"stability_methods.svg", PlotMethods(table)},
                     {"stability_errors.svg", PlotErrors(table)}},
                    {}};
          }};
}

/// Every kind of study; a new one is a line here and its Prepare function.
constexpr std::array kKinds = {
    StudyKind{"densification",
              "How much control, where, and what the next point is worth",
              PrepareDensification,
              DensificationKeys,
              true},
    StudyKind{"design",
              "One or two keys of a scene swept: accuracy, goals and cost of each block",
              PrepareDesign,
              DesignKeys,
              true},
    StudyKind{"tradeoff",
              "Speed against accuracy of everything a user can choose, one stage at a time",
              PrepareTradeoff,
              TradeoffKeys,
              false},  // timed, each row beside its reference
    StudyKind{"stability",
              "Extreme blocks, compared with the same adjustment in 50 digits",
              PrepareStability,
              StabilityKeys,
              true},
};

struct StudyArguments {
  std::string file;
  std::vector<std::string> parts;  ///< folders, of `join`
  std::string part;
  std::string out;
  bool restart = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

void WriteFile(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

StudyIdentity IdentityOf(const StudyKind& kind, const PreparedStudy& study, TaskPart part = {}) {
  return {kind.name, study.plan.columns, study.plan.tasks.size(), study.identity, part};
}

StudyStart StartIn(const StudyArguments& arguments) {
  const bool replaces = arguments.foreign == ForeignFiles::kReplace &&
                        !HoldsOurs(FolderContent::kStudy, arguments.out);  // nothing to go on from
  return arguments.restart || replaces ? StudyStart::kRestart : StudyStart::kResume;
}

/// What every run of a study says of itself, and what only this kind of run has.
nlohmann::json Summary(const StudyKind& kind,
                       const StudyTable& table,
                       std::size_t kept,
                       const StudyArguments& arguments,
                       const nlohmann::json& more) {
  nlohmann::json summary = {{"format", "sarblock-study-summary 1"},
                            {"study", kind.name},
                            {"folder", arguments.out},
                            {"rows", table.size()},
                            {"tasks_kept", kept}};
  summary.update(more);
  return summary;
}

void ShowSummary(const nlohmann::json& summary, const std::string& words, const Session& session) {
  if (session.json) {
    fmt::print("{}\n", summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    session.Print(words);
  }
}

/// Words, plots and the table where it has columns that need all rows.
void Conclude(const StudyKind& kind,
              const PreparedStudy& study,
              const StudyTable& table,
              const StudyArguments& arguments,
              std::size_t kept,
              const Session& session) {
  const std::filesystem::path folder = arguments.out;
  StudyAnswer answer = study.conclude(table);
  std::vector<std::string> files = {fmt::format("{}.csv", kind.name)};
  answer.files.emplace_back(fmt::format("{}.txt", kind.name),
                            fmt::format("{}\n", fmt::join(answer.words, "\n")));
  if (answer.table) WriteFile(folder / files.front(), StudyTableText(*answer.table));
  for (const auto& [name, text] : answer.files) {
    WriteFile(folder / name, text);
    files.push_back(name);
  }
  ShowSummary(
      Summary(kind,
              table,
              kept,
              arguments,
              {{"tasks", study.plan.tasks.size()}, {"words", answer.words}, {"files", files}}),
      fmt::format("{}{}{}\n{} rows; {} written to {}\n",
                  fmt::join(answer.tables, "\n"),
                  answer.tables.empty() ? "" : "\n",
                  fmt::join(answer.words, "\n"),
                  table.size(),
                  fmt::join(files, ", "),
                  arguments.out),
      session);
}

int RunOneStudy(const StudyKind& kind, const StudyArguments& arguments, const Session& session) {
  if (session.dump_config) {
    fmt::print("{}", EffectiveStudyText(arguments.file, session.set));
    return kAccepted;
  }
  const TaskPart part = TaskPartOf(arguments.part).value_or(TaskPart{});
  RequireFolderFor(FolderContent::kStudy, arguments.out, arguments.foreign);
  const StudyStart start = StartIn(arguments);
  const ThreadLimit limit(session.Threads());
  const PreparedStudy study = Naming(
      arguments.file, [&] { return kind.prepare(arguments.file, session.set, session.Threads()); });
  StudyRows rows(arguments.out, IdentityOf(kind, study, part), start);
  if (rows.kept() > 0) {
    session.Warn(fmt::format("sarblock: {} of {} tasks of the study are there already",
                             rows.kept(),
                             study.plan.tasks.size()));
  }
  const StudyTable table = Naming(
      arguments.file, [&] { return RunStudy(study.plan, &rows, session.progress.get(), part); });
  if (part.IsWhole()) {
    Conclude(kind, study, table, arguments, rows.kept(), session);
  } else {
    ShowSummary(
        Summary(kind, table, rows.kept(), arguments, {{"part", arguments.part}}),
        fmt::format(
            "{}: {} rows written to {}; \"sarblock study join\" makes the study of all parts\n",
            NameOf(part),
            table.size(),
            arguments.out),
        session);
  }
  return kAccepted;
}

/// The kind of study of which a folder holds a part, and the study as it ran there.
std::pair<const StudyKind*, std::string> StudyIn(const std::filesystem::path& folder) {
  for (const StudyKind& kind : kKinds) {
    const std::filesystem::path file = folder / fmt::format("{}.study.toml", kind.name);
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return {&kind, file.string()};
  }
  throw InputError(FilePlace{folder.string(), 0, ""}, "holds no part of a study");
}

int RunJoin(const StudyArguments& arguments, const Session& session) {
  RequireNoneOf(arguments.parts, arguments.out);
  const auto [kind, file] = StudyIn(arguments.parts.front());
  RequireFolderFor(FolderContent::kStudy, arguments.out, arguments.foreign);
  const StudyStart start = StartIn(arguments);
  const ThreadLimit limit(session.Threads());
  const PreparedStudy study = kind->prepare(file, {}, session.Threads());
  const StudyIdentity identity = IdentityOf(*kind, study);
  const std::vector<std::vector<StudyRow>> joined =
      JoinStudyParts({arguments.parts.begin(), arguments.parts.end()}, identity);
  StudyRows rows(arguments.out, identity, start);
  std::vector<StudyRow> all;
  for (std::size_t task = 0; task < joined.size(); ++task) {
    if (rows.Find(task) == nullptr) rows.Keep(task, joined[task]);
    all.insert(all.end(), joined[task].begin(), joined[task].end());
  }
  Conclude(*kind, study, {study.plan.columns, std::move(all)}, arguments, rows.kept(), session);
  return kAccepted;
}

}  // namespace

std::vector<std::string> StudyKeys(const std::string& command_path) {
  for (const StudyKind& kind : kKinds) {
    if (command_path == fmt::format("study {}", kind.name)) return kind.keys();
  }
  return {};
}

void AddStudy(CLI::App* app, Session* session) {
  CLI::App* study = app->add_subcommand("study", "Studies over many blocks, before a mission");
  study->require_subcommand(1);
  for (const StudyKind& kind : kKinds) {
    auto arguments = std::make_shared<StudyArguments>();
    CLI::App* command = study->add_subcommand(kind.name, kind.help);
    command->add_option("study", arguments->file, "Study file (TOML, docs/studies.md)")->required();
    command->add_option("-o,--output", arguments->out, "Folder to write to")->required();
    if (kind.divisible) {
      AddPart(command,
              &arguments->part,
              "Only the tasks I modulo N, for `study join`; I from 0 or from 1");
    }
    command->add_flag(
        "--restart", arguments->restart, "Compute all rows again, even those that the folder has");
    AddForce(command, &arguments->foreign);
    command->callback([=, &kind] {
      session->run = [=, &kind] { return RunOneStudy(kind, *arguments, *session); };
    });
  }
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* join = study->add_subcommand("join", "One study of the parts that --part computed");
  join->add_option("parts", arguments->parts, "Folders of all its parts")->required();
  join->add_option("-o,--output", arguments->out, "Folder to write to")->required();
  join->add_flag("--restart", arguments->restart, "Replace the study that the folder holds");
  AddForce(join, &arguments->foreign);
  join->callback([=] { session->run = [=] { return RunJoin(*arguments, *session); }; });
}

}  // namespace sarblock::cli
