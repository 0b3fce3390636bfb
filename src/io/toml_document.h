// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "toml_reader.h"

namespace sarblock {

/// Scenes and studies: a TOML file with the overrides of the command line.

/// The file's text; `what` ("a scene") is for messages.
[[nodiscard]] std::string ReadTomlText(const std::filesystem::path& path, const std::string& what);

/// Reads scenes by the name that stands in a study, relative to the study's folder.
[[nodiscard]] std::function<std::string(const std::string& name)> SceneTextsBeside(
    const std::filesystem::path& study_file);

/// Parses a text and sets every `KEY=VALUE`: a dotted key, elements of lists by their index from 0,
/// and a TOML value; what is not a TOML value is taken as a text.
[[nodiscard]] toml::table ParseToml(std::string_view text,
                                    const std::string& file,
                                    const std::vector<std::string>& overrides);

[[nodiscard]] std::string TextOf(const toml::table& table);

/// Place of a dotted field, or of the nearest table around it that stands in the file.
[[nodiscard]] FilePlace PlaceOfField(const toml::table& root,
                                     const std::string& file,
                                     const std::string& field);

}  // namespace sarblock
