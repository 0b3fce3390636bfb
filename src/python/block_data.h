// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sarblock::python {

/// A block in memory, never changed once it is made, and what is needed to read `[adjust]` anew
/// with other options.
struct BlockData {
  BlockFile file;
  Truth truth;                         ///< of a simulation
  std::string toml;                    ///< where [adjust] stands
  std::string toml_name;               ///< for messages
  std::vector<std::string> overrides;  ///< KEY=VALUE that it was read with
  std::filesystem::path path;          ///< empty: it was never a file
  std::vector<InputFile> inputs;       ///< of the path, as they were when it was read
  Measurements measurements = Measurements::kRequired;
};
using BlockPointer = std::shared_ptr<const BlockData>;

[[nodiscard]] BlockPointer ReadBlockAt(const std::filesystem::path& path,
                                       const std::vector<std::string>& overrides,
                                       Measurements measurements,
                                       ProgressSink* progress);
[[nodiscard]] BlockPointer BlockOfArrays(const BlockArrays& arrays,
                                         Measurements measurements,
                                         ProgressSink* progress);
/// `text` is that of a scene, or null: the file `name` is read.
[[nodiscard]] BlockPointer SimulateScene(const std::string& name,
                                         const std::string* text,
                                         const std::vector<std::string>& overrides,
                                         int threads,
                                         ProgressSink* progress);

/// The options of the block with others over them.
[[nodiscard]] AdjustOptions OptionsOf(const BlockData& data,
                                      const std::vector<std::string>& overrides,
                                      int threads);
/// The folder from which the names of lists count.
[[nodiscard]] std::filesystem::path HomeOf(const BlockData& data);
/// True positions where they are known: those of the simulation, or of the path's truth.csv.
[[nodiscard]] Truth TruthOf(const BlockData& data);

}  // namespace sarblock::python
