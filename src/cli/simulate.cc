// SPDX-License-Identifier: Apache-2.0
// `sarblock simulate`: a block from a scene, and what of the scene no look shows.
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/threads.h"
#include "print_result.h"
#include "program.h"
#include "session.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

/// What the files and people call a LookLoss, in its order.
struct LossName {
  const char* key;
  const char* words;
};
constexpr std::array<LossName, std::tuple_size_v<LossCounts>> kLossNames = {
    {{"beyond_reach", "out of reach of the pass"},
     {"beyond_strip", "beyond the ends of the strip"},
     {"wrong_side", "on the other side"},
     {"below_horizon", "below the horizon"},
     {"outside_swath", "outside the swath"},
     {"shadow", "in shadow"},
     {"layover", "in layover"}}};

std::size_t At(const LossCounts& counts, LookLoss loss) {
  return counts[static_cast<std::size_t>(loss)];
}

std::size_t LostToTerrain(const LossCounts& counts) {
  return At(counts, LookLoss::kShadow) + At(counts, LookLoss::kLayover);
}

nlohmann::json LossJson(const LossCounts& counts) {
  nlohmann::json json;
  for (std::size_t i = 0; i < counts.size(); ++i) json[kLossNames[i].key] = counts[i];
  return json;
}

nlohmann::json CoverageJson(const Block& block, const SceneCoverage& coverage) {
  nlohmann::json passes = nlohmann::json::array();
  for (std::size_t i = 0; i < coverage.passes.size(); ++i) {
    passes.push_back({{"id", block.passes[i].id},
                      {"shown", coverage.passes[i].shown},
                      {"lost", LossJson(coverage.passes[i].lost)}});
  }
  const auto points = [&](PointRole role) -> nlohmann::json {
    const SceneCoverage::Points& of = coverage.of(role);
    return {{"placed", of.placed}, {"left_out", of.left_out}, {"unseen", of.unseen}};
  };
  return {{"tie", points(PointRole::kTie)},
          {"control", points(PointRole::kControl)},
          {"check", points(PointRole::kCheck)},
          {"points_by_looks", coverage.points_by_looks},
          {"lost", LossJson(coverage.lost)},
          {"lost_of_left_out", LossJson(coverage.lost_of_left_out)},
          {"passes", passes}};
}

/// "120 in shadow, 96 outside the swath". Passes out of reach explain what no other pass loses.
std::string DescribeLosses(LossCounts counts) {
  std::size_t& beyond_reach = counts[static_cast<std::size_t>(LookLoss::kBeyondReach)];
  if (std::any_of(counts.begin() + 1, counts.end(), [](std::size_t n) { return n > 0; })) {
    beyond_reach = 0;
  }
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[i], kLossNames[i].words);
  }
  return text;
}

/// The passes that lose looks to the terrain.
std::string DescribePasses(const Block& block, const SceneCoverage& coverage) {
  constexpr std::size_t kShown = 40;
  std::string text;
  std::size_t reported = 0;
  for (std::size_t i = 0; i < coverage.passes.size(); ++i) {
    const PassCoverage& pass = coverage.passes[i];
    const std::size_t lost = LostToTerrain(pass.lost);
    if (lost == 0 || ++reported > kShown) continue;
    if (reported == 1) {
      text += fmt::format("  {:<30} {:>8} {:>10} {:>10} {:>8}\n",
                          "points placed, by pass",
                          "shown",
                          "in shadow",
                          "in layover",
                          "lost %");
    }
    text += fmt::format("  {:<30} {:>8} {:>10} {:>10} {:>8.1f}\n",
                        block.passes[i].id,
                        pass.shown,
                        At(pass.lost, LookLoss::kShadow),
                        At(pass.lost, LookLoss::kLayover),
                        100.0 * static_cast<double>(lost) / static_cast<double>(pass.shown + lost));
  }
  if (reported > kShown) text += fmt::format("  and {} passes more\n", reported - kShown);
  return text;
}

/// Nothing where every point is in the block with all the looks of its passes.
std::string DescribeCoverage(const Scene& scene, const SimulatedBlock& simulated) {
  const SceneCoverage& coverage = simulated.coverage;
  const auto part = [&](PointRole role, std::size_t SceneCoverage::Points::*lost, const char* of) {
    const SceneCoverage::Points& points = coverage.of(role);
    if (points.*lost == 0) return std::string();
    return fmt::format("{} of {} {} points", points.*lost, points.placed, of);
  };
  std::string left_out = part(PointRole::kTie, &SceneCoverage::Points::left_out, "tie");
  const std::string checks = part(PointRole::kCheck, &SceneCoverage::Points::left_out, "check");
  if (!left_out.empty() && !checks.empty()) left_out += " and ";
  left_out += checks;
  const std::string unseen = part(PointRole::kControl, &SceneCoverage::Points::unseen, "control");
  std::string text;
  if (!left_out.empty()) {
    text += fmt::format("  {} left out, seen by fewer than {} passes; looks they lose: {}\n",
                        left_out,
                        scene.points.min_looks,
                        DescribeLosses(coverage.lost_of_left_out));
  }
  if (!unseen.empty()) text += fmt::format("  {} are seen by no pass\n", unseen);
  const std::string passes = DescribePasses(simulated.block, coverage);
  if (text.empty() && passes.empty()) return text;
  return text +
         fmt::format("  all placed points, {}\n", DescribeLooksPerPoint(coverage.points_by_looks)) +
         passes;
}

struct SimulateArguments {
  std::string scene;
  std::string out;
  bool gzip = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

int RunSimulate(const SimulateArguments& arguments, const Session& session) {
  if (session.dump_config) {
    fmt::print("{}\n", files::EffectiveSceneText(arguments.scene, session.set));
    return kAccepted;
  }
  RequireFolderFor(FolderContent::kBlock, arguments.out, arguments.foreign);
  const OutputLock lock(arguments.out);
  const ThreadLimit limit(session.Threads());
  const Scene scene = files::ReadScene(arguments.scene, session.set);
  const SimulatedBlock simulated =
      Naming(arguments.scene, [&] { return Simulate(scene, session.progress.get()); });
  std::vector<std::string> passes;
  for (const Pass& pass : simulated.block.passes) passes.push_back(pass.id);
  const files::AdjustTable adjust =
      files::ReadAdjustTable(scene.adjust_toml, arguments.scene, passes);
  files::WriteBlock(arguments.out,
                    simulated.block,
                    adjust,
                    &simulated.truth,
                    arguments.gzip ? Compression::kGzip : Compression::kNone);
  if (session.json) {
    const nlohmann::json summary = {
        {"format", "sarblock-simulation 1"},
        {"block", arguments.out},
        {"scene", scene.name},
        {"seed", scene.seed},
        {"passes", simulated.block.passes.size()},
        {"points", simulated.block.points.size()},
        {"looks", simulated.block.looks.size()},
        {"coverage", CoverageJson(simulated.block, simulated.coverage)}};
    fmt::print("{}\n", summary.dump(2));
  } else {
    session.Print(fmt::format("{}: {} passes, {} points, {} looks written to {}\n",
                              scene.name,
                              simulated.block.passes.size(),
                              simulated.block.points.size(),
                              simulated.block.looks.size(),
                              arguments.out) +
                  DescribeCoverage(scene, simulated));
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
