// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstdint>
#include <vector>

namespace sarblock::test {

/// Gives a pass other recorded states, read in the way that it asks for.
void ReplaceStates(std::vector<StateVector> states, std::uint32_t pass, Block* block);

/// Adds a pass that is a copy of another with its looks, named "COPY".
void AppendPassCopy(std::uint32_t pass, Block* block);

/// Adds a tie point "copy" with the looks of another one.
void AppendPointCopy(std::uint32_t point, Block* block);

}  // namespace sarblock::test
