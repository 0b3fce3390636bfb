// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/adjust_table.h"
#include "sarblock/io/block_files.h"

#include <array>
#include <memory>

#include "commands.h"
#include "core/parallel.h"
#include "determinacy/block_structure.h"
#include "determinacy/point_defects.h"
#include "print_summary.h"
#include "solve/start_values.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

/// What the adjustment would say of the block before it forms an equation.
std::vector<Finding> Examine(AdjustmentProblem* problem, const Session& session) {
  const StartReport start = ComputeStartValues(problem, session.progress.get());
  const PointDefects defects = FindPointDefects(*problem, start.state);
  LeaveOutOpenPoints(defects, problem);
  std::vector<Finding> findings = ExamineStructure(*problem, start.state);
  for (Finding& finding : DescribePoints(*problem, defects)) findings.push_back(std::move(finding));
  return findings;
}

int Run(const std::string& folder, const Session& session) {
  ReadOptions read;
  read.set_overrides = session.set;
  read.progress = session.progress.get();
  const BlockFile file = ReadBlock(folder, read);
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  const ThreadLimit limit(session.Threads());
  AdjustmentProblem problem(file.block,
                            file.adjust.corrections == CorrectionChoice::kGiven
                                ? file.adjust.groups
                                : std::vector<CorrectionGroup>{});
  const int corrections = problem.layout.size();
  std::vector<std::string> warnings = file.warnings;
  for (const Finding& finding : Examine(&problem, session)) warnings.push_back(finding.text);
  if (session.json) {
    std::array<std::size_t, 3> roles{};
    for (const PointRole role : file.block.points.role) ++roles[static_cast<std::size_t>(role)];
    const nlohmann::json summary = {{"format", "sarblock-check 1"},
                                    {"block", file.block.name},
                                    {"passes", file.block.passes.size()},
                                    {"points", file.block.points.size()},
                                    {"tie", roles[0]},
                                    {"control", roles[1]},
                                    {"check", roles[2]},
                                    {"looks", file.block.looks.size()},
                                    {"corrections", corrections},
                                    {"warnings", warnings}};
    fmt::print("{}\n", summary.dump(2));
    return kAccepted;
  }
  fmt::print("{}  corrections {}\n", DescribeBlock(file.block), corrections);
  for (const std::string& warning : warnings) fmt::print("  warning: {}\n", warning);
  return kAccepted;
}

}  // namespace

void AddCheck(CLI::App* app, Session* session) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = app->add_subcommand("check", "Validate and describe a block, change nothing");
  command->add_option("block", *folder, "Folder of the block")->required();
  command->callback([=] { session->run = [=] { return Run(*folder, *session); }; });
}

}  // namespace sarblock::cli
