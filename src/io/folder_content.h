// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock {

/// What a folder, or a file that stands for one, holds.
enum class FolderContent { kResult, kBlock };

/// "block" or "result".
[[nodiscard]] constexpr const char* NameOf(FolderContent content) {
  return content == FolderContent::kBlock ? "block" : "result";
}

}  // namespace sarblock
