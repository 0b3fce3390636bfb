// SPDX-License-Identifier: Apache-2.0
#include "support/scene_blocks.h"

#include "sarblock/io/adjust_table.h"
#include "sarblock/io/scene_file.h"
#include "sarblock/simulate/simulate.h"

#include <algorithm>
#include <filesystem>

namespace sarblock::test {

std::vector<std::string> SceneFiles() {
  std::vector<std::string> files;
  const auto folder = std::filesystem::path(SARBLOCK_DATASETS) / "scenes";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path().stem());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string TestNameOf(const std::string& scene) {
  std::string name = scene;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

SceneBlock SmallSceneBlock(const std::string& name) {
  const auto file = std::filesystem::path(SARBLOCK_DATASETS) / "scenes" / (name + ".toml");
  const Scene scene = ReadScene(file, {"points.count=120", "check.count=10"});
  SceneBlock made;
  made.block = Simulate(scene).block;
  std::vector<std::string> ids;
  for (const Pass& pass : made.block.passes) ids.push_back(pass.id);
  made.options = ReadAdjustTable(scene.adjust_toml, name, ids);
  return made;
}

}  // namespace sarblock::test
