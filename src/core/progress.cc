// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/progress.h"

#include "sarblock/core/error.h"

#include <string>

namespace sarblock {

void Step(ProgressSink* sink,
          std::string_view stage,
          std::size_t done,
          std::size_t total,
          std::string_view detail) {
  if (sink == nullptr) return;
  sink->Update(stage, done, total, detail);
  if (sink->Cancelled()) throw Interrupted(std::string(stage));
}

}  // namespace sarblock
