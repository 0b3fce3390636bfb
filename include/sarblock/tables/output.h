// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

enum class Compression { kNone, kGzip };

/// The name `.NAME.tmp-RANDOM` beside a target, for a file that appears whole or not at all:
/// whoever writes it calls Commit(), which renames it. Without a Commit() the destructor removes
/// it. The name is random, for the numbers of processes are the same in every container.
class TemporaryName {
 public:
  explicit TemporaryName(const std::filesystem::path& target);
  ~TemporaryName();
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Throws InputError naming the target if it cannot be replaced. Call once.
  void Commit();

 private:
  std::filesystem::path target_;
  std::string name_;  // empty: committed
  int slot_ = -1;
};

/// A file that appears whole or not at all: written under a TemporaryName and renamed by Commit().
/// A target that exists and is no regular file (a pipe, a device) is written directly.
/// Every write is checked; failures (no space left, no such folder) throw InputError naming the
/// file. Gzip output is the same bytes for the same text (no time stamp, no name).
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target,
                      Compression compression = Compression::kNone);
  ~AtomicFile();
  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  void Write(std::string_view text);
  /// Writes what is buffered, closes and renames. Call once.
  void Commit();

 private:
  struct State;
  void Flush();
  void WriteThrough(std::string_view text);
  [[noreturn]] void Fail(const std::string& doing);
  std::unique_ptr<State> state_;
};

/// Removes the temporary files that are open in this process. Async-signal-safe (a signal handler
/// may call it before the process ends); the files' AtomicFile objects must not be used afterwards.
void RemoveOpenTemporaryFiles() noexcept;

/// A file that goes with a block or a result: `name` in its folder, or next to the file that stands
/// for one: "x.report.html" for "x.h5".
[[nodiscard]] std::filesystem::path FileOf(const std::filesystem::path& owner,
                                           const std::string& name);

/// Makes a folder and its parents; throws InputError naming it where that fails.
void MakeFolder(const std::filesystem::path& folder);

/// What a folder, or a file that stands for one, holds. Studies are folders.
enum class FolderContent { kResult, kBlock, kStudy };

/// "result", "block" or "study".
[[nodiscard]] constexpr const char* NameOf(FolderContent content) {
  constexpr const char* kNames[] = {"result", "block", "study"};
  return kNames[static_cast<std::size_t>(content)];
}

/// Whether a file that is to be written is one file of all tables: its name ends in ".h5".
[[nodiscard]] bool NamesContainer(const std::filesystem::path& path);
/// What a block or a result at this path is called where it has no other name: the folder's own, or
/// the file's without ".h5".
[[nodiscard]] std::string NameAt(const std::filesystem::path& path);
/// Whether the path is an HDF5 file.
[[nodiscard]] bool IsContainer(const std::filesystem::path& path);
/// Whether HDF5 files are tried in a process of their own before they are read (true at first), by
/// posix_spawn() and without a handler of SIGCHLD: some damaged files crash libhdf5. A host that
/// wants no child processes risks its own process with such a file. The setting is for the whole
/// process; any thread may call it.
void TryHdf5Apart(bool apart);
/// What an HDF5 file says that it holds; nothing if it is not one of ours or cannot be read.
[[nodiscard]] std::optional<FolderContent> ContentOf(const std::filesystem::path& container);

/// What to do with a folder that holds files of somebody else.
enum class ForeignFiles { kRefuse, kReplace };

/// Throws InputError naming the folder where `content` must not be written to it: it is a file, it
/// cannot be read, or (kRefuse) it holds files that this program did not write as `content`. A
/// folder is one of ours by its summary.json (a result) or by the first line of its block.toml (a
/// block) or of a NAME.study.toml (a study), or where a run of this program was killed while it
/// wrote there; files beside the tables of such a folder stay and do not matter. A block whose
/// files were changed since it was written is refused like one of somebody else. A folder that does
/// not exist, and an empty one, can be written. Names that begin with a dot do not count. Call it
/// before the work whose outcome is to be written; an OutputLock then keeps it so. A name that ends
/// in ".h5" is that of a file, which is recognised as ours by its content.
void RequireFolderFor(FolderContent content,
                      const std::filesystem::path& folder,
                      ForeignFiles foreign);

/// Whether this program wrote what a folder holds as `content`.
[[nodiscard]] bool HoldsOurs(FolderContent content, const std::filesystem::path& folder);

/// Texts by which files of ours are recognised: one of them is in the first 64 KiB of each.
using FileMarks = std::initializer_list<std::string_view>;

/// Throws InputError where `file` must not be written: it is a folder, or (kRefuse) a file stands
/// there that is not empty and has none of `marks`.
void RequireFileFor(const std::filesystem::path& file, FileMarks marks, ForeignFiles foreign);

/// The same for a folder of files without one that says what the folder is: (kRefuse) every file in
/// it must be empty or have one of `marks`.
void RequireFilesFor(const std::filesystem::path& folder, FileMarks marks, ForeignFiles foreign);

/// Exclusive right of one run to write an output, a folder or a file: a lock (flock) on the hidden
/// file `.sarblock-lock` in the folder, `.NAME.sarblock-lock` beside a file, which says who holds
/// it and is gone afterwards. A process that is killed holds nothing. Take it before the work whose
/// outcome is written, so that a second run is refused before its own work. Functions that write
/// take it too; where this thread already holds it, that costs nothing.
class OutputLock {
 public:
  /// Makes the folder, or that of the file. Throws InputError where another run holds the lock,
  /// which it names with its computer and its time, and where nothing can be written. A folder that
  /// was made and to which nothing was written is removed with the last copy.
  explicit OutputLock(std::filesystem::path output);

  /// False on a file system without locks.
  [[nodiscard]] bool exclusive() const;

 private:
  struct Held;
  std::shared_ptr<Held> held_;
};

/// Files that appear in a folder together: they are written to a hidden folder inside it and moved
/// into place when all are whole. The file that says what the folder is (summary.json, block.toml)
/// is taken away before the others are moved and comes last. So a run that is killed, or finds no
/// space, leaves the older content whole or, ended while files move, a folder that no reader takes.
class StagedFolder {
 public:
  /// Makes the folder, takes its OutputLock and removes what ended processes left half written in
  /// it. Throws InputError.
  StagedFolder(FolderContent content, std::filesystem::path folder);
  /// Removes what was not published.
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// Has `write` write all files to the folder it is given; the errors it throws name the final
  /// files.
  void Write(const std::function<void(const std::filesystem::path&)>& write);
  /// Moves the files into place. Those in `known` that were not written now are of an older content
  /// and are removed; a page (.html) only if it is a report of ours. Call once.
  void Publish(const std::vector<std::string>& known);

 private:
  FolderContent content_;
  std::filesystem::path folder_;
  OutputLock lock_;
  std::filesystem::path stage_;
};

/// First line of every block.toml that this program writes.
inline constexpr const char* kWrittenBySarblock = "# written by sarblock\n";
/// Text of every report.
inline constexpr std::string_view kReportMark = "<meta name=\"generator\" content=\"sarblock ";

/// The folders that hold the parts of an output to be joined. Errors are InputErrors that name the
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
