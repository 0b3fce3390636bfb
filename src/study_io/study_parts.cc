// SPDX-License-Identifier: Apache-2.0
#include "study_parts.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

std::string JournalIn(const fs::path& folder, const StudyIdentity& identity) {
  const fs::path file = folder / (identity.name + ".progress");
  std::error_code ignored;
  std::ifstream stream(file, std::ios::binary);
  if (!stream || !fs::is_regular_file(file, ignored)) {
    Fail(folder,
         "holds no part of a study " + identity.name + ": there is no file " +
             file.filename().string());
  }
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// The rows of all parts, and what is wrong with them.
class Joined {
 public:
  explicit Joined(StudyIdentity identity)
      : identity_(std::move(identity)), rows_(identity_.tasks) {}

  void Take(const fs::path& folder) {
    const std::string text = JournalIn(folder, identity_);
    identity_.part = PartOfJournal(text);
    const std::string head = StudyJournalHead(identity_);
    if (!text.starts_with(head)) {
      Fail(folder,
           folders_.folders().empty()
               ? "its rows are of another version of the study or of the program"
               : "belongs to another study than " + folders_.folders().front().string() +
                     ", or to another version of the program");
    }
    const TaskPart part = identity_.part;
    if (part.IsWhole()) Fail(folder, "holds a whole study, no part to join");
    folders_.Add(folder, part);
    TakeRows(folder, text, head.size());
  }

  std::vector<std::vector<StudyRow>> Rows() && {
    folders_.RequireAll();
    return std::move(rows_);
  }

 private:
  void TakeRows(const fs::path& folder, const std::string& text, std::size_t begin) {
    const TaskPart part = identity_.part;
    const std::string file = (folder / (identity_.name + ".progress")).string();
    const StudyJournal journal = ReadStudyJournal(text, begin, identity_.tasks);
    std::size_t finished = 0;
    for (const auto& [task, rows] : journal.rows) {
      if (!part.Holds(task)) continue;
      rows_[task] = StudyRowsOf(rows, identity_.columns, file);
      ++finished;
    }
    const std::size_t tasks = part.TasksOf(identity_.tasks);
    if (finished == tasks) return;
    Fail(folder,
         fmt::format(
             "{} is not finished, {} of {} tasks are there; the command that wrote it goes on",
             NameOf(part),
             finished,
             tasks));
  }

  StudyIdentity identity_;
  std::vector<std::vector<StudyRow>> rows_;
  PartFolders folders_;
};

}  // namespace

std::vector<std::vector<StudyRow>> JoinStudyParts(const std::vector<fs::path>& folders,
                                                  const StudyIdentity& identity) {
  Joined joined(identity);
  for (const fs::path& folder : folders) joined.Take(folder);
  return std::move(joined).Rows();
}

}  // namespace sarblock
