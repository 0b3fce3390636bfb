// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sarblock {

/// One file that a run has read.
struct InputFile {
  std::string name;         ///< within its folder: "observations.csv.gz"
  std::uint64_t bytes = 0;  ///< as it stands there, compressed or not
  std::string sha256;       ///< of these bytes, 64 hexadecimal digits: what `sha256sum` prints
};

/// SHA-256 (FIPS 180-4) of a file in hexadecimal. Throws InputError if it cannot be read.
[[nodiscard]] std::string Sha256OfFile(const std::filesystem::path& file);

/// The files that an adjustment of a block depends on: block.toml, the tables trajectories,
/// observations and points, or the one file of all, then the lists of pairs and rejections that
/// `options` names. Files that are not there are left out: reading the block says what is missing.
[[nodiscard]] std::vector<InputFile> ListInputFiles(const std::filesystem::path& block,
                                                    const AdjustOptions& options);

}  // namespace sarblock
