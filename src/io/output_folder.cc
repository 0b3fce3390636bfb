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

#include <nlohmann/json.hpp>
#include <unistd.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporary = ".tmp-";  // and the number of the process

const char* MarkerOf(FolderContent content) {
  if (content == FolderContent::kPart) return "part.json";
  return content == FolderContent::kResult ? "summary.json" : "block.toml";
}

[[noreturn]] void Fail(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Whether a file is JSON whose `format` begins like this.
bool HasFormat(const fs::path& file, std::string_view begin) {
  const nlohmann::json text = nlohmann::json::parse(TextOf(file), nullptr, false);
  if (!text.is_object() || !text.contains("format") || !text["format"].is_string()) return false;
  return text["format"].get<std::string>().starts_with(begin);
}

bool IsBlockOfOurs(const fs::path& folder) {
  return TextOf(folder / "block.toml").starts_with(kWrittenBySarblock);
}

bool HasMark(const fs::path& file, FileMarks marks) {
  constexpr std::streamsize kRead = 65536;
  std::string head(kRead, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), kRead);
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return std::any_of(marks.begin(), marks.end(), [&head](std::string_view mark) {
    return head.find(mark) != std::string::npos;
  });
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

bool IsStudyOfOurs(const fs::path& folder) {
  if (!fs::is_directory(folder)) return false;
  const std::vector<std::string> names = VisibleNames(folder);
  return std::any_of(names.begin(), names.end(), [&folder](const std::string& name) {
    return name.ends_with(".study.toml") && HasMark(folder / name, {"# written by sarblock"});
  });
}

/// Whether there is a folder; throws InputError where its name is taken by a file.
bool IsThere(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return false;
  if (status.type() == fs::file_type::none) Fail(folder, "cannot be read: " + error.message());
  if (!fs::is_directory(status)) Fail(folder, "is a file, the name of a folder is needed");
  return true;
}

bool CanReplace(const fs::path& file, FileMarks marks) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || fs::file_size(file, ignored) == 0) return true;
  return HasMark(file, marks);
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
  if (fs::is_directory(status)) Fail(file, "is a folder, the name of a file is needed");
  if (!fs::is_regular_file(status)) Fail(file, "is neither a folder nor a file");
  if (foreign == ForeignFiles::kReplace || ContentOf(file) == content) return;
  Fail(file,
       std::string("is no ") + NameOf(content) +
           " that sarblock wrote; the name of a new file is allowed, or --force to replace it");
}

}  // namespace

bool HoldsOurs(FolderContent content, const fs::path& folder) {
  switch (content) {
    case FolderContent::kResult:
      return HasFormat(folder / "summary.json", "sarblock-result ");
    case FolderContent::kBlock:
      return IsBlockOfOurs(folder);
    case FolderContent::kStudy:
      return IsStudyOfOurs(folder);
    case FolderContent::kPart:
      return HasFormat(folder / "part.json", "sarblock-part ");
  }
  return false;
}

void RequireFolderFor(FolderContent content, const fs::path& folder, ForeignFiles foreign) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (NamesContainer(folder) && fs::exists(status)) {
    RequireContainerFor(content, folder, status, foreign);
    return;
  }
  if (!IsThere(folder)) return;
  const std::vector<std::string> names = VisibleNames(folder);
  if (foreign == ForeignFiles::kReplace || names.empty()) return;
  if (content == FolderContent::kResult &&
      std::find(names.begin(), names.end(), "block.toml") != names.end()) {
    Fail(folder,
         "is a block, whose tables a result would overwrite; a new or empty folder is allowed, or "
         "--force");
  }
  if (HoldsOurs(content, folder) || IsUnfinished(content, folder)) return;
  Fail(folder,
       std::string("is not empty and no ") + NameOf(content) + " that sarblock wrote (" +
           FirstOf(names) +
           "); a new or empty folder is allowed, or --force to write among these files");
}

void RequireFileFor(const fs::path& file, FileMarks marks, ForeignFiles foreign) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) Fail(file, "is a folder, the name of a file is needed");
  if (foreign == ForeignFiles::kReplace || CanReplace(file, marks)) return;
  Fail(file,
       "is there and sarblock did not write it; another name is allowed, or --force to replace it");
}

void RequireFilesFor(const fs::path& folder, FileMarks marks, ForeignFiles foreign) {
  if (!IsThere(folder) || foreign == ForeignFiles::kReplace) return;
  std::vector<std::string> others;
  for (const std::string& name : VisibleNames(folder)) {
    if (!CanReplace(folder / name, marks)) others.push_back(name);
  }
  if (others.empty()) return;
  Fail(folder,
       "holds files that sarblock did not write (" + FirstOf(others) +
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
    if (std::find(written.begin(), written.end(), name) != written.end()) continue;
    if (name.ends_with(".html") && !HasMark(folder_ / name, {kReportMark})) continue;
    fs::remove(folder_ / name);
  }
  for (const std::string& name : written) fs::rename(stage() / name, folder_ / name);
}

}  // namespace sarblock
