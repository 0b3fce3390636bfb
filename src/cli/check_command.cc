// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/parameters.h"
#include "sarblock/io/adjust_table.h"
#include "sarblock/io/block_files.h"

#include <array>
#include <memory>

#include "commands.h"
#include "print_summary.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

int Run(const std::string& folder, const Session& session) {
  ReadOptions read;
  read.set_overrides = session.set;
  read.progress = session.progress.get();
  const BlockFile file = ReadBlock(folder, read);
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  const ParameterLayout layout = MakeParameterLayout(
      file.block,
      file.adjust.corrections == CorrectionChoice::kGiven ? file.adjust.groups
                                                          : std::vector<CorrectionGroup>{});
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
                                    {"corrections", layout.size()},
                                    {"warnings", file.warnings}};
    fmt::print("{}\n", summary.dump(2));
    return kAccepted;
  }
  fmt::print("{}  corrections {}\n", DescribeBlock(file.block), layout.size());
  for (const std::string& warning : file.warnings) fmt::print("  warning: {}\n", warning);
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
