// SPDX-License-Identifier: Apache-2.0
#include "study_parts.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <charconv>
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

std::size_t TasksOf(const StudyPart& part, std::size_t tasks) {
  return part.index < tasks ? (tasks - part.index - 1) / part.count + 1 : 0;
}

/// Which folder holds which part, and what is wrong with that.
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
           folders_.empty() ? "its rows are of another version of the study or of the program"
                            : "belongs to another study than " + folders_.front().string() +
                                  ", or to another version of the program");
    }
    const StudyPart part = identity_.part;
    if (part.IsWhole()) Fail(folder, "holds a whole study, no part to join");
    if (folders_.empty()) held_by_.resize(part.count);
    if (part.count != held_by_.size()) {
      Fail(folder,
           fmt::format("holds {}, but {} one of {} parts",
                       NameOf(part),
                       folders_.front().string(),
                       held_by_.size()));
    }
    if (!held_by_[part.index].empty()) {
      Fail(folder, "holds " + NameOf(part) + ", as does " + held_by_[part.index]);
    }
    TakeRows(folder, text, head.size());
    folders_.push_back(folder);
    held_by_[part.index] = folder.string();
  }

  std::vector<std::vector<StudyRow>> Rows() && {
    std::vector<std::string> missing;
    for (std::size_t number = 1; number <= held_by_.size(); ++number) {
      const StudyPart part{number % held_by_.size(), held_by_.size()};
      if (held_by_[part.index].empty()) missing.push_back(NameOf(part));
    }
    if (!missing.empty()) {
      const std::size_t count = missing.size(), named = std::min<std::size_t>(5, count);
      missing.resize(named);
      std::string names = fmt::format("{}", fmt::join(missing, ", "));
      if (count > named) names += fmt::format(" and {} more", count - named);
      Fail(folders_.front(), "is one of several parts; missing to join: " + names);
    }
    return std::move(rows_);
  }

 private:
  void TakeRows(const fs::path& folder, const std::string& text, std::size_t begin) {
    const StudyPart part = identity_.part;
    const std::string file = (folder / (identity_.name + ".progress")).string();
    const StudyJournal journal = ReadStudyJournal(text, begin, identity_.tasks);
    std::size_t finished = 0;
    for (const auto& [task, rows] : journal.rows) {
      if (!part.Holds(task)) continue;
      rows_[task] = StudyRowsOf(rows, identity_.columns, file);
      ++finished;
    }
    const std::size_t tasks = TasksOf(part, identity_.tasks);
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
  std::vector<fs::path> folders_;
  std::vector<std::string> held_by_;  // by part
};

}  // namespace

std::optional<StudyPart> StudyPartOf(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto number = [&](std::size_t from, std::size_t to, std::size_t* value) {
    const auto [end, error] = std::from_chars(text.data() + from, text.data() + to, *value);
    return from < to && error == std::errc() && end == text.data() + to;
  };
  StudyPart part;
  if (slash == std::string::npos || !number(0, slash, &part.index) ||
      !number(slash + 1, text.size(), &part.count) || part.count < 1 ||
      part.count > kMostStudyParts || part.index > part.count) {
    return std::nullopt;
  }
  part.index %= part.count;
  return part;
}

std::vector<std::vector<StudyRow>> JoinStudyParts(const std::vector<fs::path>& folders,
                                                  const StudyIdentity& identity) {
  Joined joined(identity);
  for (const fs::path& folder : folders) joined.Take(folder);
  return std::move(joined).Rows();
}

}  // namespace sarblock
