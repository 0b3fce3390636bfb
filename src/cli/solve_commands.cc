// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/adjust_options.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "adjust_parts.h"
#include "commands.h"
#include "core/memory.h"
#include "core/threads.h"
#include "diagnose_command.h"
#include "environment.h"
#include "files/montecarlo_part.h"
#include "print_summary.h"
#include "report_command.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

struct SolveArguments {
  std::string block;
  std::string out;
  bool strict = false;
  bool gzip = false;
  bool report = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
  std::string rejections;
  double memory_mib = 0.0;
  std::string scratch;
  AdjustParts parts;
};

/// What differs between the three commands.
struct Solver {
  const char* name;
  const char* help;
  Measurements measurements;
  bool adjusts;  ///< explains a result that fails, draws in parts
  std::function<AdjustResult(BlockFile*, const std::string& folder, ProgressSink*)> solve;
};

PointPairs PairsOf(const BlockFile& file, const std::string& folder) {
  if (file.adjust.pairs != PairChoice::kList) return {};
  return ReadPairs(folder, file.adjust.pairs_file, file.block);
}

/// What threads of Ceres sum in the order in which they finish would not be the same on all ranks.
void RequireOwnEngine(const AdjustOptions& options) {
  const char* const words = "'ceres' is for a process alone; among ranks auto, reduced are allowed";
  if (options.engine == Engine::kCeres) throw InputError("adjust.engine", words);
  if (options.covariance_method == CovarianceMethod::kCeres) {
    throw InputError("adjust.covariance_method", words);
  }
}

int RunSolve(const Solver& solver, const SolveArguments& arguments, const Session& session) {
  std::optional<ScratchScope> scratch;
  if (!arguments.scratch.empty()) scratch.emplace(arguments.scratch);
  std::vector<StageCost> reading;
  BlockFile file;
  {
    const StageTimer timer("read", &reading);
    ReadOptions read;
    read.measurements = solver.measurements;
    read.set_overrides = session.set;
    read.progress = session.progress.get();
    try {
      RunTogether(session.ranks, [&] { file = ReadBlock(arguments.block, read); });
    } catch (const InputError&) {
      if (solver.adjusts && session.first()) ExplainUnread(arguments.block, read, session);
      throw;
    }
  }
  if (!arguments.rejections.empty()) {
    file.adjust.rejections_file = std::filesystem::absolute(arguments.rejections).string();
  }
  file.adjust.threads = session.Threads();
  file.adjust.memory_mib = arguments.memory_mib;
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.block, arguments.out, ignored)) {
    throw InputError(arguments.out,
                     "is the block, whose tables the result would overwrite; any other name is "
                     "allowed");
  }
  if (session.ranks != nullptr) RequireOwnEngine(file.adjust);
  SetParts(arguments.parts, arguments.out, &file.adjust);
  RequireFolderFor(arguments.parts.output(), arguments.out, arguments.foreign);
  if (!file.adjust.rejections_file.empty()) {
    const std::size_t rejected =
        ApplyRejections(arguments.block, file.adjust.rejections_file, &file.block);
    session.Say(
        fmt::format("sarblock: {} looks left out by {}", rejected, file.adjust.rejections_file));
  }
  ResultContext context;
  {
    const StageTimer timer("checksum", &reading);
    context.inputs = ListInputFiles(arguments.block, file.adjust);
  }
  std::optional<MonteCarloParts> joined;
  if (!arguments.parts.join.empty()) {
    joined.emplace(arguments.parts.join, file.adjust, context.inputs);
  }
  AdjustResult result;
  try {
    RunTogether(session.ranks, [&] {
      result = Naming(arguments.block,
                      [&] { return solver.solve(&file, arguments.block, session.progress.get()); });
    });
  } catch (const UndeterminedError&) {
    if (solver.adjusts && session.first()) ExplainRefusal(file, session);
    throw;
  }
  if (!session.first()) return kAccepted;  // the first rank writes, and its exit code holds for all
  result.stages.insert(result.stages.begin(), reading.begin(), reading.end());
  context.command = solver.name;
  context.warnings = file.warnings;
  context.compression = arguments.gzip ? Compression::kGzip : Compression::kNone;
  const bool failed = arguments.strict && result.assessment.verdict == Verdict::kTestsFailed;
  const int exit_code = result.accepted() && !failed ? kAccepted : kNotAccepted;
  if (!arguments.parts.part.empty()) {
    WritePart(arguments.out,
              file.block,
              file.adjust,
              result,
              context.inputs,
              context.compression,
              session);
    return exit_code;
  }
  if (joined) joined->Join(file.block, file.adjust, &result);
  if (solver.adjusts) {
    context.diagnosis =
        ExplainFailure(file.block, file.adjust, file.warnings, &result, session.progress.get());
  }
  const std::string summary = WriteResult(arguments.out, file.block, file.adjust, result, context);
  if (session.json) {
    fmt::print("{}", summary);
  } else {
    for (const std::string& warning : file.warnings) session.Say("sarblock: warning: " + warning);
    session.Show(
        DescribeResult(
            file.block, file.adjust, result, std::sqrt(CovarianceFactor(file.adjust, result))) +
        "  written to " + arguments.out + "\n");
  }
  if (arguments.report) ReportResult(arguments.out, session);
  return exit_code;
}

void AddSolver(CLI::App* app, Session* session, Solver solver) {
  auto arguments = std::make_shared<SolveArguments>();
  CLI::App* command = app->add_subcommand(solver.name, solver.help);
  command->add_option("block", arguments->block, "Folder or .h5 file of the block")->required();
  command->add_option("-o,--output", arguments->out, "Folder or .h5 file of the result to write")
      ->required();
  command->add_flag("--strict", arguments->strict, "Exit code 1 also if a test failed");
  command->add_flag("--gzip", arguments->gzip, "Write the tables compressed (.csv.gz, deflate)");
  AddForce(command, &arguments->foreign);
  CLI::Option* const report = command->add_flag(
      "--report", arguments->report, "Write report.html into the result's folder as well");
  command->add_option("--rejections",
                      arguments->rejections,
                      "Leave out the looks with rejected = 1 in this table, such as residuals.csv "
                      "of a result");
  if (solver.adjusts) AddMemory(command, &arguments->memory_mib);
  AddScratch(command, &arguments->scratch);
  if (solver.adjusts) AddAdjustParts(command, report, &arguments->parts);
  command->callback([=] { session->run = [=] { return RunSolve(solver, *arguments, *session); }; });
}

}  // namespace

void AddAdjust(CLI::App* app, Session* session) {
  AddSolver(app,
            session,
            {"adjust",
             "Adjust a block: positions, flight-path corrections, exact covariances",
             Measurements::kRequired,
             true,
             [](BlockFile* file, const std::string& folder, ProgressSink* progress) {
               const PointPairs pairs = PairsOf(*file, folder);
               return Adjust(&file->block, file->adjust, pairs, progress);
             }});
}

void AddIntersect(CLI::App* app, Session* session) {
  AddSolver(app,
            session,
            {"intersect",
             "Intersect every point alone, flight paths held, with its covariance",
             Measurements::kRequired,
             false,
             [](BlockFile* file, const std::string&, ProgressSink* progress) {
               return IntersectBlock(file->block, file->adjust, progress);
             }});
}

void AddPredict(CLI::App* app, Session* session) {
  AddSolver(app,
            session,
            {"predict",
             "Covariance from geometry and weights alone, no measured values needed",
             Measurements::kOptional,
             false,
             [](BlockFile* file, const std::string& folder, ProgressSink* progress) {
               const Truth truth = ReadTruth(folder, file->block);
               const PointPairs pairs = PairsOf(*file, folder);
               return Predict(file->block, file->adjust, truth.points_m, pairs, progress);
             }});
}

}  // namespace sarblock::cli
