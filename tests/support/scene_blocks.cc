// SPDX-License-Identifier: Apache-2.0
#include "support/scene_blocks.h"

#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace sarblock::test {

std::vector<std::string> SceneFiles(const std::string& folder) {
  std::vector<std::string> files;
  const auto place = std::filesystem::path(SARBLOCK_DATASETS) / folder;
  for (const auto& entry : std::filesystem::directory_iterator(place)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path().stem());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string TestNameOf(const std::string& scene) {
  std::string name = scene;
  std::replace(name.begin(), name.end(), '-', '_');
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

SceneBlock SimulatedSceneBlock(const std::string& folder,
                               const std::string& name,
                               const std::vector<std::string>& sets) {
  const auto file = std::filesystem::path(SARBLOCK_DATASETS) / folder / (name + ".toml");
  const Scene scene = files::ReadScene(file, sets);
  SceneBlock made;
  SimulatedBlock simulated = Simulate(scene);
  made.block = std::move(simulated.block);
  made.truth = std::move(simulated.truth);
  std::vector<std::string> ids;
  for (const Pass& pass : made.block.passes) ids.push_back(pass.id);
  made.options = files::ReadAdjustTable(scene.adjust_toml, name, ids);
  return made;
}

SceneBlock SmallSceneBlock(const std::string& name) {
  return SimulatedSceneBlock("scenes", name, {"points.count=120", "check.count=10"});
}

SceneBlock NetInNoOrder(const std::vector<std::string>& sets) {
  std::vector<std::string> all = {"points.count=6000",
                                  "points.east_m=[500, 50500]",
                                  "points.north_m=[13500, 118100]",
                                  "flight.0.count=14",
                                  "flight.1.count=14",
                                  "flight.0.segments=10",
                                  "flight.1.segments=10",
                                  "control.count=40",
                                  "check.count=9",
                                  "check.sigma_m=[1, 1, 1]"};
  all.insert(all.end(), sets.begin(), sets.end());
  return SimulatedSceneBlock("benchmarks", "network", all);
}

}  // namespace sarblock::test
