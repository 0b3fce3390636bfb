// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/simulate/scene.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock::files {

/// Reads a scene (docs/scenes.md). `overrides` are `KEY=VALUE` with a dotted key
/// (`points.count=50`, `flight.0.height_m=9000`) and a TOML value; what is not a TOML value is
/// taken as a string. Throws InputError with FILE:LINE: field for syntax, unknown keys (naming the
/// nearest known one), wrong types and values no scene can have. The [adjust] table is not looked
/// into: it is returned as text in Scene::adjust_toml.
[[nodiscard]] Scene ReadScene(const std::filesystem::path& path,
                              const std::vector<std::string>& overrides = {});

/// The same from text; `file` names it in messages. Without a folder of its own it can name no
/// table of offsets (wander.table).
[[nodiscard]] Scene ParseScene(std::string_view text,
                               const std::string& file,
                               const std::vector<std::string>& overrides = {});

/// The scene file's text after the overrides, for `--dump-config`. Checks syntax only.
[[nodiscard]] std::string EffectiveSceneText(const std::filesystem::path& path,
                                             const std::vector<std::string>& overrides = {});

/// Every key of a scene, dotted as for `--set` (`flight.0.height_m`), but for those of its [adjust]
/// table. Collected from the readers, so that the list cannot differ from the keys that they
/// accept.
[[nodiscard]] std::vector<std::string> SceneKeys();

}  // namespace sarblock::files
