// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/study/study_table.h"

#include <string>

#include "io/scene_table.h"

namespace sarblock {

/// Takes `format`, `study`, `name`, `purpose` and `seed`, which every study file has, and refuses a
/// file of another kind; the rest is the reader's. `kind` is the command ("densification").
[[nodiscard]] StudyHeading TakeStudyHeading(const std::string& kind, SceneTable* table);

}  // namespace sarblock
