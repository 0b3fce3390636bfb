// SPDX-License-Identifier: Apache-2.0
#include "block_data.h"

#include "sarblock/core/error.h"
#include "sarblock/files/adjust_options.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/simulate.h"

#include <utility>

#include "core/threads.h"
#include "tables/open.h"
#include "tables/table.h"

namespace sarblock::python {
namespace {

std::vector<std::string> PassIds(const Block& block) {
  std::vector<std::string> ids;
  for (const Pass& pass : block.passes) ids.push_back(pass.id);
  return ids;
}

}  // namespace

BlockPointer ReadBlockAt(const std::filesystem::path& path,
                         const std::vector<std::string>& overrides,
                         Measurements measurements,
                         ProgressSink* progress) {
  auto data = std::make_shared<BlockData>();
  std::tie(data->toml_name, data->toml) = TablesAt(path, FolderContent::kBlock)->Read("block.toml");
  ReadOptions options;
  options.measurements = measurements;
  options.set_overrides = overrides;
  options.progress = progress;
  data->file = ReadBlock(path, options);
  data->overrides = overrides;
  data->path = path;
  data->inputs = ListInputFiles(path, data->file.adjust);
  data->measurements = measurements;
  return data;
}

BlockPointer BlockOfArrays(const BlockArrays& arrays,
                           Measurements measurements,
                           ProgressSink* progress) {
  auto data = std::make_shared<BlockData>();
  ReadOptions options;
  options.measurements = measurements;
  options.progress = progress;
  data->file = ReadBlockArrays(arrays, options);
  data->toml = arrays.block_toml;
  data->toml_name = "block.toml";
  data->measurements = measurements;
  return data;
}

BlockPointer SimulateScene(const std::string& name,
                           const std::string* text,
                           const std::vector<std::string>& overrides,
                           int threads,
                           ProgressSink* progress) {
  const ThreadLimit limit(threads);
  const Scene scene =
      text == nullptr ? ReadScene(name, overrides) : ParseScene(*text, name, overrides);
  SimulatedBlock simulated = Naming(name, [&] { return Simulate(scene, progress); });
  auto data = std::make_shared<BlockData>();
  data->file.adjust = ReadAdjustTable(scene.adjust_toml, name, PassIds(simulated.block));
  data->file.block = std::move(simulated.block);
  data->truth = std::move(simulated.truth);
  data->toml = DumpAdjustTable(data->file.adjust);  // as its block.toml would have it
  data->toml_name = name;
  return data;
}

AdjustOptions OptionsOf(const BlockData& data,
                        const std::vector<std::string>& overrides,
                        int threads) {
  std::vector<std::string> all = data.overrides;
  for (const std::string& text : overrides) {
    if (text.starts_with("trajectory.")) {
      throw InputError("--set " + text.substr(0, text.find('=')),
                       "says how flight paths are read, which read_block does");
    }
    all.push_back(text);
  }
  AdjustOptions options = ReadAdjustTable(data.toml, data.toml_name, PassIds(data.file.block), all);
  options.threads = threads > 0 ? threads : AvailableCores();
  return options;
}

std::filesystem::path HomeOf(const BlockData& data) {
  return data.path.empty() ? std::filesystem::path(".") : data.path;
}

Truth TruthOf(const BlockData& data) {
  if (!data.truth.points_m.empty() || data.path.empty()) return data.truth;
  return ReadTruth(data.path, data.file.block);
}

}  // namespace sarblock::python
