// SPDX-License-Identifier: Apache-2.0
#include "study_command.h"

#include "sarblock/core/error.h"
#include "sarblock/io/atomic_file.h"
#include "sarblock/study_io/densification_file.h"
#include "sarblock/study_io/stability_file.h"
#include "sarblock/study_io/tradeoff_study.h"

#include <array>
#include <filesystem>
#include <memory>

#include "core/parallel.h"
#include "study_io/study_file.h"
#include "study_io/study_rows.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

/// Every kind of study; a new one is a line here and its Prepare function.
constexpr std::array kKinds = {
    StudyKind{"densification",
              "How much control, where, and what the next point is worth",
              PrepareDensification,
              DensificationKeys},
    StudyKind{"tradeoff",
              "Speed against accuracy of everything a user can choose, one stage at a time",
              PrepareTradeoff,
              TradeoffKeys},
    StudyKind{"stability",
              "Blocks pushed to the extremes beside the same adjustment in 50 digits",
              PrepareStability,
              StabilityKeys},
};

struct StudyArguments {
  std::string file;
  std::string out;
  bool restart = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

void WriteFile(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

int RunOneStudy(const StudyKind& kind, const StudyArguments& arguments, const Session& session) {
  if (session.dump_config) {
    fmt::print("{}", EffectiveStudyText(arguments.file, session.set));
    return kAccepted;
  }
  const std::filesystem::path folder = arguments.out;
  RequireFolderFor(FolderContent::kStudy, folder, arguments.foreign);
  const bool replaces = arguments.foreign == ForeignFiles::kReplace &&
                        !HoldsOurs(FolderContent::kStudy, folder);  // nothing to go on from
  const ThreadLimit limit(session.Threads());
  PreparedStudy study = Naming(
      arguments.file, [&] { return kind.prepare(arguments.file, session.set, session.Threads()); });
  StudyRows rows(
      folder,
      {kind.name, study.plan.columns, study.plan.tasks.size(), std::move(study.identity)},
      arguments.restart || replaces ? StudyStart::kRestart : StudyStart::kResume);
  if (rows.kept() > 0) {
    session.Say(fmt::format("sarblock: {} of {} parts of the study are there already",
                            rows.kept(),
                            study.plan.tasks.size()));
  }
  const StudyTable table =
      Naming(arguments.file, [&] { return RunStudy(study.plan, &rows, session.progress.get()); });
  StudyAnswer answer = study.conclude(table, session.progress.get());
  std::vector<std::string> files = {fmt::format("{}.csv", kind.name)};
  answer.files.emplace_back(fmt::format("{}.txt", kind.name),
                            fmt::format("{}\n", fmt::join(answer.words, "\n")));
  if (answer.table) WriteFile(folder / files.front(), StudyTableText(*answer.table));
  for (const auto& [name, text] : answer.files) {
    WriteFile(folder / name, text);
    files.push_back(name);
  }
  if (session.json) {
    const nlohmann::json summary = {{"format", "sarblock-study-summary 1"},
                                    {"study", kind.name},
                                    {"folder", arguments.out},
                                    {"rows", table.size()},
                                    {"parts", study.plan.tasks.size()},
                                    {"parts_kept", rows.kept()},
                                    {"words", answer.words},
                                    {"files", files}};
    fmt::print("{}\n", summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    session.Show(fmt::format("{}\n{} rows; {} written to {}\n",
                             fmt::join(answer.words, "\n"),
                             table.size(),
                             fmt::join(files, ", "),
                             arguments.out));
  }
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
    command->add_flag(
        "--restart", arguments->restart, "Compute all rows anew, whatever the folder holds");
    AddForce(command, &arguments->foreign);
    command->callback([=, &kind] {
      session->run = [=, &kind] { return RunOneStudy(kind, *arguments, *session); };
    });
  }
}

}  // namespace sarblock::cli
