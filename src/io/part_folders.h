// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <filesystem>
#include <string>
#include <vector>

namespace sarblock {

/// Which folder holds which part of what is to be joined. Errors are InputErrors that name the
/// folder.
class PartFolders {
 public:
  /// Takes a folder with what it says that it holds; refuses a part of another number of parts and
  /// one that is there already.
  void Add(const std::filesystem::path& folder, const TaskPart& part);
  /// Refuses if a part is missing, naming the first five.
  void RequireAll() const;
  /// In the order of Add().
  [[nodiscard]] const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  std::vector<std::filesystem::path> folders_;
  std::vector<std::string> held_by_;  // by part
};

/// Refuses an output that is one of the folders to join.
void RequireNoneOf(const std::vector<std::string>& folders, const std::filesystem::path& output);

}  // namespace sarblock
