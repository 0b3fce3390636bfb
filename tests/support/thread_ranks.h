// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "core/ranks.h"

namespace sarblock::test {

/// Runs work as so many ranks, each a thread of this process with a RanksScope, and waits for all.
/// What a rank throws must be caught in its work.
void RunRanks(int ranks, const std::function<void(Ranks*)>& work);

}  // namespace sarblock::test
