// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "densification.h"

namespace sarblock {

/// A densification study as read, every case's scene and options made and checked.
struct DensificationFile {
  DensificationStudy study;
  std::string identity;  ///< the study's effective text and those of its scenes
};

/// Reads a study (docs/studies.md). `overrides` are `KEY=VALUE` as for a scene. Throws InputError
/// with FILE:LINE: field for syntax, unknown keys, wrong types and values, and for a case whose
/// scene or [adjust] cannot be made, naming the case.
[[nodiscard]] DensificationFile ReadDensification(const std::filesystem::path& path,
                                                  const std::vector<std::string>& overrides = {});

/// The same from text; `file` names it in messages, `scene_text` gives the text of a scene by the
/// name that the study gives.
[[nodiscard]] DensificationFile ParseDensification(
    std::string_view text,
    const std::string& file,
    const std::vector<std::string>& overrides,
    const std::function<std::string(const std::string& name)>& scene_text);

/// Keys of the study file with their dotted names, for `--set`: those outside its lists of tables
/// and those of the first [[placement]]; those of the scene inside `set` not among them.
[[nodiscard]] std::vector<std::string> DensificationKeys();

}  // namespace sarblock
