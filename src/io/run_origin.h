// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/input_files.h"
#include "sarblock/model/options.h"

#include <vector>

#include <nlohmann/json.hpp>

namespace sarblock {

/// The [adjust] table that held for a run, key by key, and the number of its threads.
[[nodiscard]] nlohmann::ordered_json ConfigurationJson(const AdjustOptions& options);
/// The files that it read: file, bytes, sha256 each.
[[nodiscard]] nlohmann::ordered_json InputsJson(const std::vector<InputFile>& files);

}  // namespace sarblock
