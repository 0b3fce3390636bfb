// SPDX-License-Identifier: Apache-2.0
#include "part_folders.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void RefuseFolder(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

}  // namespace

void PartFolders::Add(const fs::path& folder, const TaskPart& part) {
  if (folders_.empty()) held_by_.resize(part.count);
  if (part.count != held_by_.size()) {
    RefuseFolder(folder,
                 fmt::format("holds {}, but {} one of {} parts",
                             NameOf(part),
                             folders_.front().string(),
                             held_by_.size()));
  }
  if (!held_by_[part.index].empty()) {
    RefuseFolder(folder, "holds " + NameOf(part) + ", as does " + held_by_[part.index]);
  }
  folders_.push_back(folder);
  held_by_[part.index] = folder.string();
}

void PartFolders::RequireAll() const {
  std::vector<std::string> missing;
  for (std::size_t number = 1; number <= held_by_.size(); ++number) {
    const TaskPart part{number % held_by_.size(), held_by_.size()};
    if (held_by_[part.index].empty()) missing.push_back(NameOf(part));
  }
  if (missing.empty()) return;
  const std::size_t count = missing.size(), named = std::min<std::size_t>(5, count);
  missing.resize(named);
  std::string names = fmt::format("{}", fmt::join(missing, ", "));
  if (count > named) names += fmt::format(" and {} more", count - named);
  RefuseFolder(folders_.front(), "is one of several parts; missing to join: " + names);
}

void RequireNoneOf(const std::vector<std::string>& folders, const fs::path& output) {
  for (const std::string& folder : folders) {
    std::error_code ignored;
    if (fs::equivalent(folder, output, ignored)) {
      RefuseFolder(output, "is one of the parts to join; another folder is needed");
    }
  }
}

}  // namespace sarblock
