// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/statistics.h"

#include <functional>
#include <string>
#include <vector>

namespace sarblock::test {

/// What a diagnosis is to say of a block with a mistake in it: a cause of the list and, where there
/// are some, its passes or points. An empty list of causes: nothing can be seen, or the list of
/// hypotheses does not have it.
struct Planted {
  bool done = false;  ///< the block has what the mistake needs
  std::vector<std::string> causes;
  std::vector<std::string> passes, points;
  std::string words;
};

/// A mistake that a user may make, its place, sign and size drawn.
struct Plant {
  std::string name;
  std::function<Planted(Block* block, RandomStream* random)> make;
};

/// Every mistake of the table in docs/validation.md.
[[nodiscard]] const std::vector<Plant>& Plants();
/// That of Plants() with this name; throws InputError for none.
[[nodiscard]] const Plant& PlantNamed(const std::string& name);
/// Errors that no hypothesis describes.
[[nodiscard]] const std::vector<Plant>& UnlistedErrors();

}  // namespace sarblock::test
