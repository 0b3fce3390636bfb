// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <string>
#include <vector>

namespace sarblock::test {

/// Names of the shipped scenes in a folder of the datasets, sorted; a test's name cannot hold their
/// hyphens and slashes.
[[nodiscard]] std::vector<std::string> SceneFiles(const std::string& folder = "scenes");
[[nodiscard]] std::string TestNameOf(const std::string& scene);

struct SceneBlock {
  Block block;
  Truth truth;
  AdjustOptions options;
};
/// The scene `folder`/`name` of the datasets, with these settings, and its own [adjust].
[[nodiscard]] SceneBlock SimulatedSceneBlock(const std::string& folder,
                                             const std::string& name,
                                             const std::vector<std::string>& sets);
/// A shipped scene with at most 120 tie points and 10 check points: what differs between two routes
/// is no matter of size.
[[nodiscard]] SceneBlock SmallSceneBlock(const std::string& name);
/// 280 passes of a net that see 6,000 points in no order, and what else `sets` says.
[[nodiscard]] SceneBlock NetInNoOrder(const std::vector<std::string>& sets);

}  // namespace sarblock::test
