// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"
#include "sarblock/simulate/simulated_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sarblock {

/// Draws the joint errors of pass number `pass_index` from its own stream of `seed` and adds them.
void AddJointErrors(const std::vector<JointPrior>& joint,
                    const Frame& frame,
                    const Pass& pass,
                    std::size_t pass_index,
                    std::uint64_t seed,
                    PassError* error);

}  // namespace sarblock
