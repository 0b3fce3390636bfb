// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace sarblock {

/// What a folder, or a file that stands for one, holds. Studies are folders, and so are parts of
/// the draws of an adjustment (montecarlo_part.h).
enum class FolderContent { kResult, kBlock, kStudy, kPart };

/// "result", "block", "study" or "part of an adjustment".
[[nodiscard]] constexpr const char* NameOf(FolderContent content) {
  constexpr const char* kNames[] = {"result", "block", "study", "part of an adjustment"};
  return kNames[static_cast<std::size_t>(content)];
}

/// Whether a file that is to be written is one file of all tables: its name ends in ".h5".
[[nodiscard]] bool NamesContainer(const std::filesystem::path& path);
/// What a block or a result at this path is called where it has no other name: the folder's own, or
/// the file's without ".h5".
[[nodiscard]] std::string NameAt(const std::filesystem::path& path);
/// Whether an HDF5 file stands there.
[[nodiscard]] bool IsContainer(const std::filesystem::path& path);
/// What an HDF5 file says that it holds; nothing if it is not one of ours or cannot be read.
[[nodiscard]] std::optional<FolderContent> ContentOf(const std::filesystem::path& container);

}  // namespace sarblock
