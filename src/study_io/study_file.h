// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/study/study_table.h"

#include <filesystem>
#include <string>
#include <vector>

#include "io/scene_table.h"

namespace sarblock {

/// Takes `format`, `study`, `name`, `purpose` and `seed`, which every study file has, and refuses a
/// file of another kind; the rest is the reader's. `kind` is the command ("densification").
[[nodiscard]] StudyHeading TakeStudyHeading(const std::string& kind, SceneTable* table);

/// The study file's text after the overrides, for `--dump-config` and as a study's identity: the
/// same keys and values give the same text, whatever the comments. Checks syntax only.
[[nodiscard]] std::string EffectiveStudyText(const std::filesystem::path& path,
                                             const std::vector<std::string>& overrides = {});

/// A text as comment lines of TOML: a study's identity names its scenes so, and can be read as the
/// study that it is.
[[nodiscard]] std::string AsTomlComment(const std::string& text);

}  // namespace sarblock
