// SPDX-License-Identifier: Apache-2.0
#include "study_command.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <array>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "core/threads.h"
#include "studies/densification_file.h"
#include "studies/stability.h"
#include "studies/study.h"
#include "studies/tradeoff_study.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

/// Every kind of study; a new one is a line here and its Prepare function.
constexpr std::array kKinds = {
    StudyKind{"densification",
              "How much control, where, and what the next point is worth",
              PrepareDensification,
              DensificationKeys,
              true},
    StudyKind{"tradeoff",
              "Speed against accuracy of everything a user can choose, one stage at a time",
              PrepareTradeoff,
              TradeoffKeys,
              false},  // timed, each row beside its reference
    StudyKind{"stability",
              "Blocks pushed to the extremes beside the same adjustment in 50 digits",
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
    session.Show(words);
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
  StudyAnswer answer = study.conclude(table, session.progress.get());
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
      fmt::format("{}\n{} rows; {} written to {}\n",
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
    session.Say(fmt::format("sarblock: {} of {} tasks of the study are there already",
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
        "--restart", arguments->restart, "Compute all rows anew, whatever the folder holds");
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
