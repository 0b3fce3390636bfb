// SPDX-License-Identifier: Apache-2.0
#include "study.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "tables/csv.h"
#include "tables/toml.h"
#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

namespace sarblock {
namespace {

/// What a task sees of the caller's sink: whether to stop, and nothing of its bar.
class QuietSink final : public ProgressSink {
 public:
  explicit QuietSink(const ProgressSink* sink) : sink_(sink) {}
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {}
  [[nodiscard]] bool Cancelled() const override { return sink_ != nullptr && sink_->Cancelled(); }

 private:
  const ProgressSink* sink_;
};

bool Fits(const StudyCell& cell, StudyCellKind kind) {
  if (std::holds_alternative<std::monostate>(cell)) return true;
  switch (kind) {
    case StudyCellKind::kNumber:
      return std::holds_alternative<double>(cell) && std::isfinite(std::get<double>(cell));
    case StudyCellKind::kInteger:
      return std::holds_alternative<std::int64_t>(cell);
    case StudyCellKind::kText:
      break;
  }
  return std::holds_alternative<std::string>(cell) &&
         std::get<std::string>(cell).find_first_of("\r\n") == std::string::npos;
}

void RequireFit(const StudyRow& row, const std::vector<StudyColumn>& columns) {
  if (row.size() != columns.size()) throw std::logic_error("a row of a study lacks cells");
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (!Fits(row[i], columns[i].kind)) {
      throw std::logic_error("a cell of a study does not fit its column " + columns[i].name);
    }
  }
}

/// Tasks begun in their order, kept one at a time.
class Runner {
 public:
  Runner(const StudyPlan& plan, StudyStore* store, ProgressSink* progress, TaskPart part)
      : plan_(plan), store_(store), progress_(progress), rows_(plan.tasks.size()) {
    for (std::size_t i = part.index; i < plan.tasks.size(); i += part.count) {
      ++tasks_;
      const std::vector<StudyRow>* kept = store == nullptr ? nullptr : store->Find(i);
      if (kept == nullptr) {
        missing_.push_back(i);
      } else {
        for (const StudyRow& row : *kept) RequireFit(row, plan.columns);
        rows_[i] = *kept;
      }
    }
  }

  StudyTable Run() {
    Show({});
    if (plan_.order == TaskOrder::kOneByOne) {
      for (std::size_t i = 0; i < missing_.size(); ++i) RunNext();
    } else {
      // A piece takes the next task, whichever piece it is, so that tasks begin in their order.
      ParallelForChunks(missing_.size(), 1, [this](std::size_t, std::size_t, std::size_t) {
        RunIsolated([this] { RunNext(); });
      });
    }
    std::vector<StudyRow> all;
    for (std::vector<StudyRow>& rows : rows_) {
      for (StudyRow& row : rows) all.push_back(std::move(row));
    }
    return {plan_.columns, std::move(all)};
  }

 private:
  void Show(const std::string& detail) {
    sarblock::Step(progress_, "study", tasks_ - missing_.size() + done_, tasks_, detail);
  }

  void RunNext() {
    const std::size_t index = missing_[next_.fetch_add(1)];
    const StudyTask& task = plan_.tasks[index];
    QuietSink quiet(progress_);
    if (quiet.Cancelled()) throw Interrupted("study");
    std::vector<StudyRow> rows = task.compute(&quiet);
    for (const StudyRow& row : rows) RequireFit(row, plan_.columns);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (store_ != nullptr) store_->Keep(index, rows);
    rows_[index] = std::move(rows);
    ++done_;
    Show(task.name);
  }

  const StudyPlan& plan_;
  StudyStore* store_;
  ProgressSink* progress_;
  std::vector<std::vector<StudyRow>> rows_;
  std::vector<std::size_t> missing_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::size_t tasks_ = 0, done_ = 0;
};

}  // namespace

StudyRowMaker& StudyRowMaker::Set(std::string_view column, StudyCell cell) {
  const auto found = std::find_if(columns_.begin(), columns_.end(), [&](const StudyColumn& known) {
    return known.name == column;
  });
  if (found == columns_.end()) throw std::logic_error("no column " + std::string(column));
  const auto* number = std::get_if<double>(&cell);
  if (number != nullptr && !std::isfinite(*number)) cell = StudyCell{};
  row_[static_cast<std::size_t>(found - columns_.begin())] = std::move(cell);
  return *this;
}

StudyRowMaker& StudyRowMaker::Count(std::string_view column, std::size_t count) {
  return Set(column, static_cast<std::int64_t>(count));
}

StudyRowMaker& StudyRowMaker::Message(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return Set("message", std::move(text));
}

StudyTable::StudyTable(std::vector<StudyColumn> columns, std::vector<StudyRow> rows)
    : columns_(std::move(columns)), rows_(std::move(rows)) {
  for (const StudyRow& row : rows_) RequireFit(row, columns_);
}

const StudyCell& StudyTable::Cell(std::size_t row, std::string_view column) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (columns_[i].name == column) return rows_.at(row)[i];
  }
  throw std::logic_error("a study has no column " + std::string(column));
}

double StudyTable::Number(std::size_t row, std::string_view column) const {
  const StudyCell& cell = Cell(row, column);
  if (const auto* number = std::get_if<double>(&cell)) return *number;
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return static_cast<double>(*integer);
  if (std::holds_alternative<std::monostate>(cell)) return std::numeric_limits<double>::quiet_NaN();
  throw std::logic_error("column " + std::string(column) + " holds text");
}

std::string StudyTable::Text(std::size_t row, std::string_view column) const {
  const StudyCell& cell = Cell(row, column);
  if (std::holds_alternative<std::monostate>(cell)) return {};
  return std::get<std::string>(cell);
}

std::string NameOfStudy(const TaskPart& part) {
  return part.IsWhole() ? "a whole study" : NameOf(part);
}

StudyTable RunStudy(const StudyPlan& plan,
                    StudyStore* store,
                    ProgressSink* progress,
                    TaskPart part) {
  return Runner(plan, store, progress, part).Run();
}

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
  std::map<std::size_t, std::string> waiting;  // finished before a task that precedes them
  std::size_t next = 0;                        // first task that is not in the table
  std::size_t kept = 0;

  /// Text of the tasks that can be shown now.
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

namespace {

std::vector<TableColumn> TableColumnsOf(const std::vector<StudyColumn>& columns) {
  std::vector<TableColumn> out;
  for (const StudyColumn& column : columns) {
    const bool text = column.kind == StudyCellKind::kText;
    out.push_back({column.name, ColumnNeed::kRequired, text ? CellKind::kText : CellKind::kNumber});
  }
  return out;
}

std::vector<StudyRow> ReadStudyRows(TableReader* table, const std::vector<StudyColumn>& columns) {
  std::vector<StudyRow> rows;
  ForRows(table, [&](const Row& row) {
    StudyRow cells(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!row.Given(i)) continue;
      if (columns[i].kind == StudyCellKind::kText) {
        cells[i] = std::string(row.Text(i));
      } else if (columns[i].kind == StudyCellKind::kNumber) {
        cells[i] = row.Number(i);
      } else {
        cells[i] = static_cast<std::int64_t>(row.Number(i));
      }
    }
    rows.push_back(std::move(cells));
  });
  return rows;
}

}  // namespace

StudyTable ReadStudyTable(const std::filesystem::path& file, std::vector<StudyColumn> columns) {
  std::vector<StudyRow> rows = ReadStudyRows(ReadCsv(file, TableColumnsOf(columns)).get(), columns);
  return {std::move(columns), std::move(rows)};
}

namespace {

constexpr std::string_view kRecordFormat = "sarblock-study-progress 2 ";

/// Takes "WORD N" off a line; nothing where it reads otherwise.
bool TakeNumber(std::string_view* line, std::string_view word, std::size_t* value) {
  if (!line->starts_with(word)) return false;
  line->remove_prefix(word.size());
  const auto [end, error] = std::from_chars(line->data(), line->data() + line->size(), *value);
  if (error != std::errc()) return false;
  line->remove_prefix(static_cast<std::size_t>(end - line->data()));
  return true;
}

/// The line that ends a record. The checksum of its rows detects damage.
std::string LastLineOf(std::size_t task, std::string_view rows) {
  return fmt::format("end {} {:016x}", task, Fnv1a(rows));
}

/// The line behind the first one of a journal, without its end.
std::string_view SecondLineOf(std::string_view text) {
  const std::size_t first = text.find('\n');
  if (first == std::string_view::npos) return {};
  text.remove_prefix(first + 1);
  const std::size_t second = text.find('\n');
  return second == std::string_view::npos ? std::string_view() : text.substr(0, second);
}

}  // namespace

std::string StudyJournalHead(const StudyIdentity& identity) {
  std::uint64_t hash = Fnv1a(Version());
  hash = Fnv1a(StudyHeadingText(identity.columns), hash);
  hash = Fnv1a(fmt::format("{}\n{}\n{}", identity.name, identity.tasks, identity.text), hash);
  std::string head = fmt::format("{}{:016x}\n", kRecordFormat, hash);
  if (!identity.part.IsWhole()) {
    head += fmt::format("part {} {}\n", identity.part.index, identity.part.count);
  }
  return head;
}

TaskPart PartOfJournal(std::string_view text) {
  std::string_view line = SecondLineOf(text);
  TaskPart part;
  if (TakeNumber(&line, "part ", &part.index) && TakeNumber(&line, " ", &part.count) &&
      line.empty() && part.index < part.count) {
    return part;
  }
  return {};
}

StudyJournal ReadStudyJournal(std::string_view text, std::size_t begin, std::size_t tasks) {
  StudyJournal journal;
  journal.end = begin;
  std::size_t at = begin;
  const auto next = [&]() -> std::optional<std::string_view> {
    const std::size_t stop = text.find('\n', at);
    if (stop == std::string_view::npos) return std::nullopt;
    const std::string_view line = text.substr(at, stop - at);
    at = stop + 1;
    return line;
  };
  for (;;) {
    std::optional<std::string_view> line = next();
    std::size_t task = 0, count = 0;
    if (!line || !TakeNumber(&*line, "task ", &task) || !TakeNumber(&*line, " rows ", &count) ||
        !line->empty() || task >= tasks) {
      return journal;
    }
    const std::size_t rows_begin = at;
    for (std::size_t i = 0; i < count; ++i) {
      if (!next()) return journal;
    }
    const std::string_view rows = text.substr(rows_begin, at - rows_begin);
    line = next();
    if (!line || *line != LastLineOf(task, rows)) return journal;
    journal.rows[task] = rows;
    journal.end = at;
  }
}

std::string StudyRecord(std::size_t task, std::size_t rows, std::string_view text) {
  return fmt::format("task {} rows {}\n{}{}\n", task, rows, text, LastLineOf(task, text));
}

std::string StudyHeadingText(const std::vector<StudyColumn>& columns) {
  std::string line;
  for (const StudyColumn& column : columns) {
    if (!line.empty()) line += ',';
    AppendCsvText(column.name, &line);
  }
  return line + '\n';
}

std::string StudyRowsText(const std::vector<StudyRow>& rows) {
  std::string text;
  for (const StudyRow& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      if (const auto* number = std::get_if<double>(&row[i])) {
        AppendNumber(*number, &text);
      } else if (const auto* integer = std::get_if<std::int64_t>(&row[i])) {
        text += std::to_string(*integer);
      } else if (const auto* words = std::get_if<std::string>(&row[i])) {
        AppendCsvText(*words, &text);
      }
    }
    text += '\n';
  }
  return text;
}

std::vector<StudyRow> StudyRowsOf(const std::string& text,
                                  const std::vector<StudyColumn>& columns,
                                  const std::string& file) {
  const std::string whole = StudyHeadingText(columns) + text;
  return ReadStudyRows(ReadCsvText(file, whole, TableColumnsOf(columns)).get(), columns);
}

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

namespace {

constexpr char kStudyFormat[] = "sarblock-study 1";
constexpr char kAsItRan[] = "# written by sarblock: the study of ";

}  // namespace

std::string EffectiveStudyText(const std::filesystem::path& path,
                               const std::vector<std::string>& overrides) {
  return TextOf(ParseToml(ReadTomlText(path, "a study"), path.string(), overrides));
}

std::string StudyAsItRan(const std::string& table, const std::string& identity) {
  return kAsItRan + table + "\n" + identity;
}

std::string SceneAsComment(const std::string& name, const std::string& text) {
  std::string out;
  std::istringstream stream(name + "\n" + text);
  for (std::string line; std::getline(stream, line);) out += "\n# " + line;
  return out + "\n";
}

std::function<std::string(const std::string& name)> ScenesOf(
    const std::filesystem::path& study_file, const std::string& study_text) {
  std::map<std::string, std::string> carried;
  std::string* scene = nullptr;
  bool after_blank = false;
  std::istringstream stream(study_text.starts_with(kAsItRan) ? study_text : std::string());
  for (std::string line; std::getline(stream, line);) {
    const bool comment = line.starts_with("# ");
    if (comment && after_blank) {
      scene = &carried[line.substr(2)];
    } else if (comment && scene != nullptr) {
      *scene += line.substr(2) + "\n";
    } else {
      scene = nullptr;
    }
    after_blank = line.empty();
  }
  return [carried = std::move(carried),
          beside = SceneTextsBeside(study_file)](const std::string& name) {
    const auto found = carried.find(name);
    return found == carried.end() ? beside(name) : found->second;
  };
}

StudyHeading TakeStudyHeading(const std::string& kind, SceneTable* table) {
  StudyHeading heading;
  const auto require = [&](const std::string& key, const std::string& wanted) {
    const std::string problem = "must be \"" + wanted + "\"";
    const auto given = table->Take(key);
    if (!given) throw InputError(table->PlaceOf(key), problem);
    if (given->Text() != wanted) given->Fail(problem);
  };
  require("format", kStudyFormat);
  require("study", kind);
  table->Text("name", &heading.name);
  table->Text("purpose", &heading.purpose);
  table->Count("seed", &heading.seed);
  return heading;
}

}  // namespace sarblock
