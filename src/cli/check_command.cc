// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/files/adjust_options.h"
#include "sarblock/files/block_file.h"

#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include "commands.h"
#include "core/memory.h"
#include "print_summary.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

struct CheckArguments {
  std::string block;
  std::string rejections;
  double memory_mib = 0.0;
  std::string scratch;
};

/// Reads the other files that an adjustment of the block would read; returns looks left out.
std::size_t ReadNamedFiles(const CheckArguments& arguments, BlockFile* file) {
  AdjustOptions& adjust = file->adjust;
  if (!arguments.rejections.empty()) {
    adjust.rejections_file = std::filesystem::absolute(arguments.rejections).string();
  }
  if (adjust.pairs == PairChoice::kList) {
    static_cast<void>(ReadPairs(arguments.block, adjust.pairs_file, file->block));
  }
  if (adjust.rejections_file.empty()) return 0;
  return ApplyRejections(arguments.block, adjust.rejections_file, &file->block);
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
          {"sum_operations", needs.sum_operations_1},
          {"factor_operations", needs.factor_operations_1}};
}

int RunCheck(const CheckArguments& arguments, const Session& session) {
  std::optional<ScratchScope> scratch;
  if (!arguments.scratch.empty()) scratch.emplace(arguments.scratch);
  ReadOptions read;
  read.set_overrides = session.set;
  read.progress = session.progress.get();
  BlockFile file = ReadBlock(arguments.block, read);
  const std::size_t left_out = ReadNamedFiles(arguments, &file);
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  file.adjust.threads = session.Threads();
  file.adjust.memory_mib = arguments.memory_mib;
  const BlockCheck check = Naming(
      arguments.block, [&] { return CheckBlock(file.block, file.adjust, session.progress.get()); });
  std::vector<std::string> warnings = file.warnings;
  warnings.insert(warnings.end(), check.findings.begin(), check.findings.end());
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
                                    {"left_out_by_rejections", left_out},
                                    {"corrections", check.corrections},
                                    {"needs", NeedsJson(check.needs)},
                                    {"warnings", warnings}};
    fmt::print("{}\n", summary.dump(2));
    return kAccepted;
  }
  std::string text =
      fmt::format("{}  corrections {}\n", DescribeBlock(file.block), check.corrections);
  if (left_out > 0) {
    text += fmt::format("  looks left out by {}: {}\n", file.adjust.rejections_file, left_out);
  }
  text += fmt::format("  {}\n", DescribeNeeds(check.needs));
  for (const std::string& warning : warnings) text += fmt::format("  warning: {}\n", warning);
  session.Show(text);
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

}  // namespace sarblock::cli
