// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace sarblock {

/// Memory that this process may still take without swapping: what /proc/meminfo calls available,
/// and no more than the control groups that the process is in (version 1 or 2, all of the path)
/// leave below their limits, their page cache counted as free. Infinite where the system tells
/// nothing. `root` is where the system's files stand; a test gives a folder.
[[nodiscard]] double AvailableMemory_bytes(const std::filesystem::path& root = "/");

}  // namespace sarblock
