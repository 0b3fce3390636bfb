// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <string>
#include <vector>

namespace sarblock::test {

/// Names of the shipped scenes, sorted; a test's name cannot hold their hyphens.
[[nodiscard]] std::vector<std::string> SceneFiles();
[[nodiscard]] std::string TestNameOf(const std::string& scene);

/// A shipped scene with at most 120 tie points and 10 check points, and its own [adjust]: what
/// differs between two routes is no matter of size.
struct SceneBlock {
  Block block;
  AdjustOptions options;
};
[[nodiscard]] SceneBlock SmallSceneBlock(const std::string& name);

}  // namespace sarblock::test
