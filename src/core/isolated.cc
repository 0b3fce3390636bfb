// SPDX-License-Identifier: Apache-2.0
#include "isolated.h"

#include <oneapi/tbb/task_arena.h>

namespace sarblock {

void RunIsolated(const std::function<void()>& work) { tbb::this_task_arena::isolate(work); }

}  // namespace sarblock
