// SPDX-License-Identifier: Apache-2.0
#include "output_folder.h"

#include "sarblock/core/error.h"
#include "sarblock/io/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "hdf5_file.h"
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporary = ".tmp-";  // and the number of the process

const char* MarkerOf(FolderContent content) {
  return content == FolderContent::kResult ? "summary.json" : "block.toml";
}

[[noreturn]] void Fail(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool IsResultOfOurs(const fs::path& folder) {
  const nlohmann::json summary =
      nlohmann::json::parse(TextOf(folder / "summary.json"), nullptr, false);
  if (!summary.is_object() || !summary.contains("format") || !summary["format"].is_string()) {
    return false;
  }
  return summary["format"].get<std::string>().starts_with("sarblock-result ");
}

bool IsBlockOfOurs(const fs::path& folder) {
  return TextOf(folder / "block.toml").starts_with(kWrittenBySarblock);
}

/// Names in a folder that do not begin with a dot, in order.
std::vector<std::string> VisibleNames(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with('.')) names.push_back(name);
  }
  if (error) Fail(folder, "cannot be read: " + error.message());
  std::sort(names.begin(), names.end());
  return names;
}

std::string FirstOf(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
  return text;
}

/// Number of the process that a name `.NAME.tmp-PID` belongs to (atomic_file.h); 0: no such name.
pid_t WriterOf(std::string_view name) {
  const std::size_t at = name.rfind(kTemporary);
  if (!name.starts_with('.') || at == std::string_view::npos || at == 0) return 0;
  const std::string_view digits = name.substr(at + kTemporary.size());
  const char* const end = digits.data() + digits.size();
  pid_t process = 0;
  const auto [stop, error] = std::from_chars(digits.data(), end, process);
  return error == std::errc() && stop == end && process > 0 ? process : 0;
}

bool HasEnded(pid_t process) { return ::kill(process, 0) != 0 && errno == ESRCH; }

/// What killed processes left half written.
std::vector<fs::path> AbandonedIn(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    const pid_t writer = WriterOf(entry->path().filename().string());
    if (writer != 0 && HasEnded(writer)) abandoned.push_back(entry->path());
  }
  return abandoned;
}

std::string StageName(FolderContent content) {
  return std::string(".") + MarkerOf(content) + std::string(kTemporary);
}

/// Whether a run was killed while it moved files into this folder.
bool IsUnfinished(FolderContent content, const fs::path& folder) {
  const std::vector<fs::path> abandoned = AbandonedIn(folder);
  return std::any_of(abandoned.begin(), abandoned.end(), [&](const fs::path& file) {
    return file.filename().string().starts_with(StageName(content));
  });
}

void RequireContainerFor(FolderContent content,
                         const fs::path& file,
                         const fs::file_status& status,
                         ForeignFiles foreign) {
  if (!fs::is_regular_file(status)) Fail(file, "is no file, which a name with .h5 is to be");
  if (foreign == ForeignFiles::kReplace || ContentOf(file) == content) return;
  Fail(file,
       std::string("is no ") + NameOf(content) +
           " that sarblock wrote; the name of a new file is allowed, or --force to replace it");
}

}  // namespace

void RequireFolderFor(FolderContent content, const fs::path& folder, ForeignFiles foreign) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return;
  if (status.type() == fs::file_type::none) Fail(folder, "cannot be read: " + error.message());
  if (NamesContainer(folder)) {
    RequireContainerFor(content, folder, status, foreign);
    return;
  }
  if (!fs::is_directory(status)) Fail(folder, "is a file, the name of a folder is needed");
  const std::vector<std::string> names = VisibleNames(folder);
  if (foreign == ForeignFiles::kReplace || names.empty()) return;
  const bool result = content == FolderContent::kResult;
  if (result && std::find(names.begin(), names.end(), "block.toml") != names.end()) {
    Fail(folder,
         "is a block, whose tables a result would overwrite; a new or empty folder is allowed, or "
         "--force");
  }
  if (result ? IsResultOfOurs(folder) : IsBlockOfOurs(folder)) return;
  if (IsUnfinished(content, folder)) return;
  Fail(folder,
       std::string("is not empty and no ") + (result ? "result" : "block") +
           " that sarblock wrote (" + FirstOf(names) +
           "); a new or empty folder is allowed, or --force to write among these files");
}

void RemoveAbandoned(const fs::path& file) {
  std::error_code ignored;
  const std::string begin = "." + file.filename().string() + std::string(kTemporary);
  for (const fs::path& left : AbandonedIn(file.has_parent_path() ? file.parent_path() : ".")) {
    if (left.filename().string().starts_with(begin)) fs::remove(left, ignored);
  }
}

StagedFolder::StagedFolder(FolderContent content, fs::path folder)
    : content_(content), folder_(std::move(folder)) {
  MakeFolder(folder_);
  std::error_code ignored;
  const std::vector<fs::path> abandoned = AbandonedIn(folder_);
  fs::remove_all(stage(), ignored);  // of a killed process that had the same number
  MakeFolder(stage());
  for (const fs::path& file : abandoned) fs::remove_all(file, ignored);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  fs::remove_all(stage(), ignored);
}

fs::path StagedFolder::stage() const {
  return folder_ / (StageName(content_) + std::to_string(::getpid()));
}

void StagedFolder::Write(const std::function<void(const fs::path&)>& write) {
  try {
    write(stage());
  } catch (const InputError& error) {
    std::string text = error.what();
    const std::string from = stage().string(), to = folder_.string();
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw;
    throw InputError(FilePlace{}, text.replace(at, from.size(), to));
  }
}

void StagedFolder::Publish(const std::vector<std::string>& known) {
  const std::string marker = MarkerOf(content_);
  std::vector<std::string> written;
  for (const fs::directory_entry& entry : fs::directory_iterator(stage())) {
    const std::string name = entry.path().filename().string();
    if (name != marker) written.push_back(name);
  }
  std::sort(written.begin(), written.end());
  written.push_back(marker);  // last
  fs::remove(folder_ / marker);
  for (const std::string& name : known) {
    if (std::find(written.begin(), written.end(), name) == written.end()) {
      fs::remove(folder_ / name);
    }
  }
  for (const std::string& name : written) fs::rename(stage() / name, folder_ / name);
}

}  // namespace sarblock
