// SPDX-License-Identifier: Apache-2.0
#include "study_rows.h"

#include "sarblock/tables/output.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "study_file.h"
#include "tables/csv.h"
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

/// A file that only grows, each time by whole lines in one piece.
class GrowingFile {
 public:
  explicit GrowingFile(fs::path path) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (descriptor_ < 0) Fail("cannot be written");
  }
  ~GrowingFile() { ::close(descriptor_); }
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  void Append(std::string_view text) {
    while (!text.empty()) {
      const ssize_t done = ::write(descriptor_, text.data(), text.size());
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) Fail("writing failed");
      text.remove_prefix(static_cast<std::size_t>(done));
    }
  }
  void Shorten(std::size_t bytes) {
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) Fail("cannot be shortened");
  }
  /// False where another process holds it.
  [[nodiscard]] bool Lock() { return ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0; }
  [[nodiscard]] std::string Text() const {
    std::ifstream stream(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }

 private:
  [[noreturn]] void Fail(const std::string& doing) const {
    throw InputError(FilePlace{path_.string(), 0, ""}, doing + ": " + std::strerror(errno));
  }
  fs::path path_;
  int descriptor_ = -1;
};

}  // namespace

struct StudyRows::State {
  StudyIdentity identity;
  std::optional<GrowingFile> journal;
  std::optional<GrowingFile> table;
  std::map<std::size_t, std::vector<StudyRow>> earlier;
  std::map<std::size_t, std::string> waiting;  // finished before a task that stands before them
  std::size_t next = 0;                        // first task that is not in the table
  std::size_t kept = 0;

  /// Text of the tasks that can be told now.
  std::string TakeReady() {
    std::string ready;
    for (auto found = waiting.find(next); found != waiting.end(); found = waiting.find(next)) {
      ready += found->second;
      waiting.erase(found);
      next += identity.part.count;
    }
    return ready;
  }
};

StudyRows::StudyRows(const fs::path& folder, StudyIdentity identity, StudyStart start)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.identity = std::move(identity);
  state.next = state.identity.part.index;
  MakeFolder(folder);
  const fs::path table = folder / (state.identity.name + ".csv");
  const fs::path journal = folder / (state.identity.name + ".progress");
  if (start == StudyStart::kResume && fs::exists(table) && !fs::exists(journal)) {
    throw InputError(FilePlace{table.string(), 0, ""},
                     "is there already, without the record " + journal.filename().string() +
                         " to resume from; another folder or --restart is allowed");
  }
  state.journal.emplace(journal);
  if (!state.journal->Lock()) {
    throw InputError(FilePlace{journal.string(), 0, ""},
                     "is in use: another run of this study writes to this folder");
  }
  const std::string first = StudyJournalHead(state.identity);
  std::string text;
  if (start == StudyStart::kResume) text = state.journal->Text();
  if (text.find('\n') == std::string::npos) text.clear();  // not even its first line was written
  const TaskPart held = PartOfJournal(text);
  if (!text.empty() && held != state.identity.part) {
    throw InputError(FilePlace{journal.string(), 0, ""},
                     "holds " + NameOfStudy(held) + ", not " + NameOfStudy(state.identity.part) +
                         "; another folder, or --restart to compute its rows anew, is allowed");
  }
  if (!text.empty() && !text.starts_with(first)) {
    throw InputError(FilePlace{journal.string(), 0, ""},
                     "belongs to another study, or to another version of this one or of the "
                     "program; another folder, or --restart to compute all rows anew, is allowed");
  }
  if (text.empty()) {
    state.journal->Shorten(0);
    state.journal->Append(first);
  } else {
    StudyJournal read = ReadStudyJournal(text, first.size(), state.identity.tasks);
    state.journal->Shorten(read.end);
    for (auto& [task, rows] : read.rows) {
      state.earlier[task] = StudyRowsOf(rows, state.identity.columns, journal.string());
      state.waiting[task] = std::move(rows);
    }
    state.kept = state.earlier.size();
  }
  AtomicFile study(folder / (state.identity.name + ".study.toml"));
  study.Write(StudyAsItRan(table.filename().string(), state.identity.text));
  study.Commit();
  AtomicFile begin(table);
  begin.Write(StudyHeadingText(state.identity.columns));
  begin.Write(state.TakeReady());
  begin.Commit();
  state.table.emplace(table);
}

StudyRows::~StudyRows() = default;

const std::vector<StudyRow>* StudyRows::Find(std::size_t task) const {
  const auto found = state_->earlier.find(task);
  return found == state_->earlier.end() ? nullptr : &found->second;
}

void StudyRows::Keep(std::size_t task, const std::vector<StudyRow>& rows) {
  std::string text = StudyRowsText(rows);
  state_->journal->Append(StudyRecord(task, rows.size(), text));
  state_->waiting[task] = std::move(text);
  state_->table->Append(state_->TakeReady());
}

std::size_t StudyRows::kept() const { return state_->kept; }

std::string StudyTableText(const StudyTable& table) {
  return StudyHeadingText(table.columns()) + StudyRowsText(table.rows());
}

StudyTable ReadStudyTable(const std::filesystem::path& file, std::vector<StudyColumn> columns) {
  std::vector<StudyRow> rows = StudyRowsOf(CsvReader(file, AskedColumns(columns)), columns);
  return {std::move(columns), std::move(rows)};
}

}  // namespace sarblock
