// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "block/swath.h"
#include "core/memory.h"
#include "core/threads.h"
#include "files/summary.h"
#include "print_result.h"
#include "program.h"
#include "session.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

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
};

/// What differs between the three commands.
struct Solver {
  const char* name;
  const char* help;
  files::Measurements measurements;
  bool adjusts;  ///< explains a result that fails
  std::function<AdjustResult(files::BlockFile*, const std::string& folder, ProgressSink*)> solve;
};

/// What explains a block that could not be solved, on standard error after the refusal; nothing
/// with `diagnose = false`.
void AddExplanation(const files::BlockFile& file, Session* session) {
  if (!file.adjust.diagnose || session->quiet) return;
  const Diagnosis diagnosis = ExplainRefusal(file.block, file.adjust, session->progress.get());
  for (const std::string& remark : diagnosis.remarks) {
    session->after_error.push_back("warning: " + remark);
  }
  for (const std::string& text : diagnosis.Sentences()) session->after_error.push_back(text);
}

/// The same of a block that was refused for contradictions as it was read.
void ExplainUnread(const std::string& folder, files::ReadOptions read, Session* session) {
  read.contradictions = files::Contradictions::kKeep;
  try {
    AddExplanation(files::ReadBlock(folder, read), session);
  } catch (const InputError&) {  // a file that cannot be read at all: keep its message
  }
}

PointPairs PairsOf(const files::BlockFile& file, const std::string& folder) {
  if (file.adjust.pairs != PairChoice::kList) return {};
  return files::ReadPairs(folder, file.adjust.pairs_file, file.block);
}

/// What threads of Ceres sum in the order in which they finish would not be the same on all ranks.
void RequireOwnEngine(const AdjustOptions& options) {
  const char* const words = "'ceres' is for a process alone; among ranks auto, reduced are allowed";
  if (options.engine == Engine::kCeres) throw InputError("adjust.engine", words);
  if (options.covariance_method == CovarianceMethod::kCeres) {
    throw InputError("adjust.covariance_method", words);
  }
}

int RunSolve(const Solver& solver, const SolveArguments& arguments, Session& session) {
  std::optional<ScratchScope> scratch;
  if (!arguments.scratch.empty()) scratch.emplace(arguments.scratch);
  std::vector<StageCost> reading;
  files::BlockFile file;
  {
    const StageTimer timer("read", &reading);
    files::ReadOptions read;
    read.measurements = solver.measurements;
    read.set_overrides = session.set;
    read.progress = session.progress.get();
    try {
      RunTogether(session.ranks, [&] { file = files::ReadBlock(arguments.block, read); });
    } catch (const InputError&) {
      if (solver.adjusts && session.first()) ExplainUnread(arguments.block, read, &session);
      throw;
    }
  }
  if (!arguments.rejections.empty()) {
    file.adjust.rejections_file = std::filesystem::absolute(arguments.rejections).string();
  }
  file.adjust.threads = session.Threads();
  file.adjust.memory_mib = arguments.memory_mib;
  if (session.dump_config) {
    fmt::print("{}", files::DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.block, arguments.out, ignored)) {
    throw InputError(arguments.out,
                     "is the block, whose tables the result would overwrite; any other name is "
                     "allowed");
  }
  if (session.ranks != nullptr) RequireOwnEngine(file.adjust);
  std::optional<OutputLock> lock;
  RunTogether(session.ranks, [&] {
    RequireFolderFor(FolderContent::kResult, arguments.out, arguments.foreign);
    if (session.first()) lock.emplace(arguments.out);
  });
  if (!file.adjust.rejections_file.empty()) {
    const std::size_t rejected =
        files::ApplyRejections(arguments.block, file.adjust.rejections_file, &file.block);
    session.Warn(
        fmt::format("sarblock: {} looks left out by {}", rejected, file.adjust.rejections_file));
  }
  files::ResultContext context;
  {
    const StageTimer timer("checksum", &reading);
    context.inputs = files::ListInputFiles(arguments.block, file.adjust);
  }
  AdjustResult result;
  try {
    RunTogether(session.ranks, [&] {
      result = Naming(arguments.block,
                      [&] { return solver.solve(&file, arguments.block, session.progress.get()); });
    });
  } catch (const UndeterminedError&) {
    if (solver.adjusts && session.first()) AddExplanation(file, &session);
    throw;
  }
  if (!session.first()) return kAccepted;  // the first rank writes, and its exit code holds for all
  result.stages.insert(result.stages.begin(), reading.begin(), reading.end());
  context.command = solver.name;
  context.warnings = file.warnings;
  context.compression = arguments.gzip ? Compression::kGzip : Compression::kNone;
  const bool failed = arguments.strict && result.assessment.verdict == Verdict::kTestsFailed;
  const int exit_code = result.usable() && !failed ? kAccepted : kNotAccepted;
  if (solver.adjusts && file.adjust.diagnose) {
    context.diagnosis =
        ExplainFailure(file.block, file.adjust, file.warnings, &result, session.progress.get());
  }
  const std::string summary =
      files::WriteResult(arguments.out, file.block, file.adjust, result, context);
  if (session.json) {
    fmt::print("{}", summary);
  } else {
    for (const std::string& warning : file.warnings) session.Warn("sarblock: warning: " + warning);
    session.Print(DescribeResult(file.block, file.adjust, result) + "  written to " +
                  arguments.out + "\n");
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
  command->add_flag(
      "--report", arguments->report, "Write report.html into the result's folder as well");
  command->add_option("--rejections",
                      arguments->rejections,
                      "Leave out the looks with rejected = 1 in this table, such as residuals.csv "
                      "of a result");
  if (solver.adjusts) AddMemory(command, &arguments->memory_mib);
  AddScratch(command, &arguments->scratch);
  command->callback([=] { session->run = [=] { return RunSolve(solver, *arguments, *session); }; });
}

}  // namespace

void AddAdjust(CLI::App* app, Session* session) {
  AddSolver(app,
            session,
            {"adjust",
             "Adjust a block: positions, flight-path corrections, exact covariances",
             files::Measurements::kRequired,
             true,
             [](files::BlockFile* file, const std::string& folder, ProgressSink* progress) {
               const PointPairs pairs = PairsOf(*file, folder);
               return Adjust(&file->block, file->adjust, pairs, progress);
             }});
}

void AddIntersect(CLI::App* app, Session* session) {
  AddSolver(app,
            session,
            {"intersect",
             "Intersect every point by itself with fixed flight paths, with its covariance",
             files::Measurements::kRequired,
             false,
             [](files::BlockFile* file, const std::string&, ProgressSink* progress) {
               return IntersectBlock(file->block, file->adjust, progress);
             }});
}

void AddPredict(CLI::App* app, Session* session) {
  AddSolver(app,
            session,
            {"predict",
             "Covariance from geometry and weights alone, no measured values needed",
             files::Measurements::kOptional,
             false,
             [](files::BlockFile* file, const std::string& folder, ProgressSink* progress) {
               const Truth truth = files::ReadTruth(folder, file->block);
               const PointPairs pairs = PairsOf(*file, folder);
               return Predict(file->block, file->adjust, truth.points_m, pairs, progress);
             }});
}

namespace {

struct CheckArguments {
  std::string block;
  std::string rejections;
  double memory_mib = 0.0;
  std::string scratch;
};

/// Reads the other files that an adjustment of the block would read; returns looks left out.
std::size_t ReadNamedFiles(const CheckArguments& arguments, files::BlockFile* file) {
  files::AdjustTable& adjust = file->adjust;
  if (!arguments.rejections.empty()) {
    adjust.rejections_file = std::filesystem::absolute(arguments.rejections).string();
  }
  if (adjust.pairs == PairChoice::kList) {
    static_cast<void>(files::ReadPairs(arguments.block, adjust.pairs_file, file->block));
  }
  if (adjust.rejections_file.empty()) return 0;
  return files::ApplyRejections(arguments.block, adjust.rejections_file, &file->block);
}

nlohmann::json NeedsJson(const ResourceNeeds& needs) {
  return {{"memory_bytes", needs.peak_bytes},
          {"scratch_bytes", needs.scratch_bytes},
          {"looks_bytes", needs.looks_bytes},
          {"points_bytes", needs.points_bytes},
          {"matrix_bytes", needs.matrix_bytes},
          {"partial_sums_bytes", needs.partial_sums_bytes},
          {"factor_bytes", needs.factor_bytes},
          {"fronts_bytes", needs.fronts_bytes},
          {"inverse_bytes", needs.inverse_bytes},
          {"sum_operations", needs.sum_operations},
          {"factor_operations", needs.factor_operations}};
}

/// Whether no look has a measured time or range: what `predict` takes and nothing else does.
bool IsPlan(const Block& block) {
  const auto given = [](double value) { return std::isfinite(value); };
  return std::none_of(block.looks.time_s.begin(), block.looks.time_s.end(), given) &&
         std::none_of(block.looks.range_m.begin(), block.looks.range_m.end(), given);
}

/// Reads a block of measured looks, else a plan. Of what is neither the measured block's fault is
/// thrown.
files::BlockFile ReadBlockOrPlan(const std::string& path, files::ReadOptions read) {
  std::exception_ptr fault;
  try {
    return files::ReadBlock(path, read);
  } catch (const InputError&) {
    fault = std::current_exception();
  }
  read.measurements = files::Measurements::kOptional;
  try {
    files::BlockFile plan = files::ReadBlock(path, read);
    if (IsPlan(plan.block)) return plan;
  } catch (const InputError&) {  // the first fault is the one to name
  }
  std::rethrow_exception(fault);
}

/// Gives a plan the looks that `predict` would take; returns the positions at which it would.
std::vector<Eigen::Vector3d> PlanLooks(const std::string& path, Block* plan) {
  std::vector<Eigen::Vector3d> positions_m = files::ReadTruth(path, *plan).points_m;
  positions_m.resize(plan->points.size(), Eigen::Vector3d::Constant(kNotGiven));
  for (std::size_t i = 0; i < positions_m.size(); ++i) {
    if (!positions_m[i].allFinite()) positions_m[i] = plan->points.given_m[i];
  }
  *plan = FillMeasurements(*plan, positions_m);
  return positions_m;
}

nlohmann::json CoverageJson(const Coverage& coverage) {
  return {{"looks_per_point", coverage.looks_per_point},
          {"fewest_looks", coverage.fewest},
          {"most_looks", coverage.most},
          {"points_by_looks", coverage.points_by_looks},
          {"least_look_deg", coverage.least_look_rad / kRadPerDeg},
          {"largest_look_deg", coverage.most_look_rad / kRadPerDeg}};
}

int RunCheck(const CheckArguments& arguments, const Session& session) {
  std::optional<ScratchScope> scratch;
  if (!arguments.scratch.empty()) scratch.emplace(arguments.scratch);
  files::ReadOptions read;
  read.set_overrides = session.set;
  read.progress = session.progress.get();
  files::BlockFile file = ReadBlockOrPlan(arguments.block, read);
  const std::size_t left_out = ReadNamedFiles(arguments, &file);
  const bool plan = IsPlan(file.block);
  if (session.dump_config) {
    fmt::print("{}", files::DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  file.adjust.threads = session.Threads();
  file.adjust.memory_mib = arguments.memory_mib;
  std::optional<Coverage> coverage;  // of a plan
  if (plan) {
    const bool no_rows = file.block.looks.size() == 0;
    const std::vector<Eigen::Vector3d> positions_m = PlanLooks(arguments.block, &file.block);
    coverage = CoverageOf(file.block, positions_m);
    if (const auto warning = WarningOfPlan(file.block, positions_m); no_rows && warning) {
      file.warnings.push_back(*warning);
    }
  }
  const BlockCheck check = Naming(
      arguments.block, [&] { return CheckBlock(file.block, file.adjust, session.progress.get()); });
  std::vector<std::string> warnings = file.warnings;
  warnings.insert(warnings.end(), check.findings.begin(), check.findings.end());
  if (session.json) {
    std::array<std::size_t, 3> roles{};
    for (const PointRole role : file.block.points.role) ++roles[static_cast<std::size_t>(role)];
    nlohmann::json summary = {{"format", "sarblock-check 1"},
                              {"block", file.block.name},
                              {"passes", file.block.passes.size()},
                              {"points", file.block.points.size()},
                              {"tie", roles[0]},
                              {"control", roles[1]},
                              {"check", roles[2]},
                              {"looks", file.block.looks.size()},
                              {"plan", plan},
                              {"left_out_by_rejections", left_out},
                              {"corrections", check.corrections},
                              {"needs", NeedsJson(check.needs)},
                              {"warnings", warnings}};
    if (coverage) summary["coverage"] = CoverageJson(*coverage);
    fmt::print("{}\n", summary.dump(2));
    return kAccepted;
  }
  std::string text =
      fmt::format("{}  corrections {}\n", DescribeBlock(file.block), check.corrections);
  if (coverage) {
    text += "  a plan: no look is measured, those that predict would take are counted\n";
    text += fmt::format("  {}\n", Describe(*coverage));
  }
  if (left_out > 0) {
    text += fmt::format("  looks left out by {}: {}\n", file.adjust.rejections_file, left_out);
  }
  text += fmt::format("  {}\n", DescribeNeeds(check.needs));
  for (const std::string& warning : warnings) text += fmt::format("  warning: {}\n", warning);
  session.Print(text);
  return kAccepted;
}

}  // namespace

void AddCheck(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* command = app->add_subcommand("check", "Validate and describe a block, change nothing");
  command->add_option("block", arguments->block, "Folder or .h5 file of the block")->required();
  command->add_option("--rejections",
                      arguments->rejections,
                      "Leave out the looks with rejected = 1 in this table, as adjust would");
  AddMemory(command, &arguments->memory_mib);
  AddScratch(command, &arguments->scratch);
  command->callback([=] { session->run = [=] { return RunCheck(*arguments, *session); }; });
}

namespace {

struct DiagnoseArguments {
  std::string block;
  std::string rejections;
  bool all = false;
};

std::string DescribeDiagnosis(const Diagnosis& diagnosis) {
  std::string text;
  for (const std::string& sentence : diagnosis.Sentences()) text += "  " + sentence + "\n";
  if (diagnosis.contradicts && diagnosis.explanations.empty()) {
    text += "  none of " + std::to_string(diagnosis.hypotheses) +
            " mistakes tried explains half of the excess of v'Pv over its redundancy\n";
  }
  if (diagnosis.untried > 0) {
    text += "  " + std::to_string(diagnosis.untried) +
            " explanations were not tried, since their work was bounded: "
            "sarblock diagnose --all tries them\n";
  }
  return text;
}

int RunDiagnose(const DiagnoseArguments& arguments, const Session& session) {
  files::ReadOptions read;
  read.set_overrides = session.set;
  read.progress = session.progress.get();
  read.contradictions = files::Contradictions::kKeep;
  files::BlockFile file = files::ReadBlock(arguments.block, read);
  file.adjust.threads = session.Threads();
  if (!arguments.rejections.empty()) {
    file.adjust.rejections_file = std::filesystem::absolute(arguments.rejections).string();
  }
  if (session.dump_config) {
    fmt::print("{}", files::DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  if (!file.adjust.rejections_file.empty()) {
    static_cast<void>(
        files::ApplyRejections(arguments.block, file.adjust.rejections_file, &file.block));
  }
  DiagnosisBounds bounds;
  if (arguments.all) bounds.adjustments = std::numeric_limits<double>::infinity();
  const Diagnosis diagnosis = Diagnose(file.block, file.adjust, session.progress.get(), bounds);
  if (session.json) {
    const nlohmann::ordered_json summary = {{"format", "sarblock-diagnosis 1"},
                                            {"block", file.block.name},
                                            {"contradicts", diagnosis.contradicts},
                                            {"points", diagnosis.points},
                                            {"square_sum", diagnosis.square_sum},
                                            {"redundancy", diagnosis.redundancy},
                                            {"hypotheses", diagnosis.hypotheses},
                                            {"solutions", diagnosis.solutions},
                                            {"untried", diagnosis.untried},
                                            {"diagnosis", files::DiagnosisSection(diagnosis)},
                                            {"remarks", diagnosis.remarks},
                                            {"warnings", file.warnings}};
    fmt::print("{}\n", summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return kAccepted;
  }
  std::string text =
      fmt::format("{}: {} of {} points, v'Pv {:.4g}, redundancy {:g}: {}\n",
                  file.block.name,
                  diagnosis.points,
                  file.block.points.size(),
                  diagnosis.square_sum,
                  diagnosis.redundancy,
                  diagnosis.contradicts ? "contradicts itself" : "nothing contradicts");
  for (const std::string& warning : file.warnings) text += "  warning: " + warning + "\n";
  for (const std::string& remark : RemarksBeside(file.warnings, diagnosis)) {
    text += "  warning: " + remark + "\n";
  }
  session.Print(text + DescribeDiagnosis(diagnosis));
  return kAccepted;
}

}  // namespace

void AddDiagnose(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<DiagnoseArguments>();
  CLI::App* command = app->add_subcommand(
      "diagnose", "Find the input mistakes that explain a contradictory block, most likely first");
  command->add_option("block", arguments->block, "Folder or .h5 file of the block")->required();
  command->add_option("--rejections",
                      arguments->rejections,
                      "Leave out the looks with rejected = 1 in this table, as adjust would");
  command->add_flag(
      "--all",
      arguments->all,
      "Try every explanation, however much work; else that of five adjustments at most");
  command->callback([=] { session->run = [=] { return RunDiagnose(*arguments, *session); }; });
}

}  // namespace sarblock::cli
