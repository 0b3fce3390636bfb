// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "study/study_table.h"
#include "tables/toml.h"

namespace sarblock {

/// Takes `format`, `study`, `name`, `purpose` and `seed`, which every study file has, and refuses a
/// file of another kind; the rest is the reader's. `kind` is the command ("densification").
[[nodiscard]] StudyHeading TakeStudyHeading(const std::string& kind, SceneTable* table);

/// The study file's text after the overrides, for `--dump-config` and as a study's identity: the
/// same keys and values give the same text, whatever the comments. Checks syntax only.
[[nodiscard]] std::string EffectiveStudyText(const std::filesystem::path& path,
                                             const std::vector<std::string>& overrides = {});

/// The text of NAME.study.toml: the study whose rows stand in `table`, "NAME.csv".
[[nodiscard]] std::string StudyAsItRan(const std::string& table, const std::string& identity);

/// A scene as comment lines of TOML, its name before its text: a study as it ran, NAME.study.toml,
/// carries its scenes so and can be read as the study that it is.
[[nodiscard]] std::string SceneAsComment(const std::string& name, const std::string& text);

/// Texts of scenes by the names that a study gives them: those that the study's own text carries,
/// the others of files beside it.
[[nodiscard]] std::function<std::string(const std::string& name)> ScenesOf(
    const std::filesystem::path& study_file, const std::string& study_text);

}  // namespace sarblock
