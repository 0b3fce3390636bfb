// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "folder_content.h"

namespace sarblock {

/// What to do with a folder that holds files of somebody else.
enum class ForeignFiles { kRefuse, kReplace };

/// Throws InputError naming the folder where `content` must not be written to it: it is a file, it
/// cannot be read, or (kRefuse) it holds files that this program did not write as `content`. A
/// folder is one of ours by its summary.json (a result) or part.json (a part) or by the first line
/// of its block.toml (a block) or of a NAME.study.toml (a study), or where a run of this program
/// was killed while it wrote there; files beside the tables of such a folder stay and do not
/// matter. A folder that does not exist, and an empty one, can be written. Names that begin with a
/// dot do not count. Call it before the work whose outcome is to be written. A name that ends in
/// ".h5" is one of a file, which is one of ours by what it holds.
void RequireFolderFor(FolderContent content,
                      const std::filesystem::path& folder,
                      ForeignFiles foreign);

/// Whether this program wrote what a folder holds as `content`.
[[nodiscard]] bool HoldsOurs(FolderContent content, const std::filesystem::path& folder);

/// What tells files of ours from others: texts, one of which stands in the first 64 KiB of each.
using FileMarks = std::initializer_list<std::string_view>;

/// Throws InputError where `file` must not be written: it is a folder, or (kRefuse) a file stands
/// there that is not empty and has none of `marks`.
void RequireFileFor(const std::filesystem::path& file, FileMarks marks, ForeignFiles foreign);

/// The same for a folder of files without one that says what the folder is: (kRefuse) every file in
/// it must be empty or have one of `marks`.
void RequireFilesFor(const std::filesystem::path& folder, FileMarks marks, ForeignFiles foreign);

/// Removes what ended processes left half written of this file: `.NAME.tmp-PID` beside it.
void RemoveAbandoned(const std::filesystem::path& file);

/// Files that appear in a folder together: they are written to a hidden folder inside it and moved
/// into place when all are whole. The file that says what the folder is (summary.json, block.toml)
/// is taken away before the others are moved and comes last. So a run that is killed, or finds no
/// space, leaves the older content whole or, ended while files move, a folder that no reader takes.
class StagedFolder {
 public:
  /// Makes the folder and removes what ended processes left half written in it. Throws InputError.
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
  [[nodiscard]] std::filesystem::path stage() const;
  FolderContent content_;
  std::filesystem::path folder_;
};

/// First line of every block.toml that this program writes.
inline constexpr const char* kWrittenBySarblock = "# written by sarblock\n";
/// What stands in every report.
inline constexpr std::string_view kReportMark = "<meta name=\"generator\" content=\"sarblock ";

}  // namespace sarblock
