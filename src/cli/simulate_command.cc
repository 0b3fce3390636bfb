// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/adjust_options.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/simulate.h"
#include "sarblock/tables/output.h"

#include <memory>

#include "commands.h"
#include "core/threads.h"
#include "print_summary.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

struct SimulateArguments {
  std::string scene;
  std::string out;
  bool gzip = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

int RunSimulate(const SimulateArguments& arguments, const Session& session) {
  if (session.dump_config) {
    fmt::print("{}\n", EffectiveSceneText(arguments.scene, session.set));
    return kAccepted;
  }
  RequireFolderFor(FolderContent::kBlock, arguments.out, arguments.foreign);
  const ThreadLimit limit(session.Threads());
  const Scene scene = ReadScene(arguments.scene, session.set);
  const SimulatedBlock simulated =
      Naming(arguments.scene, [&] { return Simulate(scene, session.progress.get()); });
  std::vector<std::string> passes;
  for (const Pass& pass : simulated.block.passes) passes.push_back(pass.id);
  const AdjustOptions adjust = ReadAdjustTable(scene.adjust_toml, arguments.scene, passes);
  WriteBlock(arguments.out,
             simulated.block,
             adjust,
             &simulated.truth,
             arguments.gzip ? Compression::kGzip : Compression::kNone);
  if (session.json) {
    const nlohmann::json summary = {{"format", "sarblock-simulation 1"},
                                    {"block", arguments.out},
                                    {"scene", scene.name},
                                    {"seed", scene.seed},
                                    {"passes", simulated.block.passes.size()},
                                    {"points", simulated.block.points.size()},
                                    {"looks", simulated.block.looks.size()}};
    fmt::print("{}\n", summary.dump(2));
  } else {
    session.Show(fmt::format("{}: {} passes, {} points, {} looks written to {}\n",
                             scene.name,
                             simulated.block.passes.size(),
                             simulated.block.points.size(),
                             simulated.block.looks.size(),
                             arguments.out));
  }
  return kAccepted;
}

}  // namespace

void AddSimulate(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app->add_subcommand("simulate", "Make a block with known truth from a scene");
  command->add_option("scene", arguments->scene, "Scene file (TOML, docs/scenes.md)")->required();
  command->add_option("-o,--output", arguments->out, "Folder or .h5 file of the block to write")
      ->required();
  command->add_flag("--gzip", arguments->gzip, "Write the tables compressed (.csv.gz, deflate)");
  AddForce(command, &arguments->foreign);
  command->callback([=] { session->run = [=] { return RunSimulate(*arguments, *session); }; });
}

}  // namespace sarblock::cli
