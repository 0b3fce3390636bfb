// SPDX-License-Identifier: Apache-2.0
#include "study_rows.h"

#include "sarblock/core/version.h"
#include "sarblock/io/atomic_file.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "io/csv_reader.h"
#include "io/csv_writer.h"
#include "io/number.h"
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRecordFormat = "sarblock-study-progress 2 ";

std::uint64_t Hash(std::string_view text, std::uint64_t state = 0xcbf29ce484222325u) {
  for (const char c : text) {
    state ^= static_cast<unsigned char>(c);
    state *= 0x100000001b3u;
  }
  return state;
}

std::string HeadingOf(const std::vector<StudyColumn>& columns) {
  std::string line;
  for (const StudyColumn& column : columns) {
    if (!line.empty()) line += ',';
    AppendCsvText(column.name, &line);
  }
  return line + '\n';
}

std::string FirstLineOf(const StudyIdentity& identity) {
  std::uint64_t hash = Hash(Version());
  hash = Hash(HeadingOf(identity.columns), hash);
  hash = Hash(fmt::format("{}\n{}\n{}", identity.name, identity.tasks, identity.text), hash);
  return fmt::format("{}{:016x}\n", kRecordFormat, hash);
}

std::string TextOf(const std::vector<StudyRow>& rows) {
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

/// Takes "WORD N" off a line; nothing where it reads otherwise.
bool TakeNumber(std::string_view* line, std::string_view word, std::size_t* value) {
  if (!line->starts_with(word)) return false;
  line->remove_prefix(word.size());
  const auto [end, error] = std::from_chars(line->data(), line->data() + line->size(), *value);
  if (error != std::errc()) return false;
  line->remove_prefix(static_cast<std::size_t>(end - line->data()));
  return true;
}

/// The line that ends a record. The checksum of its rows tells a damaged file from a whole one.
std::string LastLineOf(std::size_t task, std::string_view rows) {
  return fmt::format("end {} {:016x}", task, Hash(rows));
}

/// The whole records of a journal: text of the rows by task, and where the last one ends. What
/// stands behind a record that is cut or damaged is not read.
struct Journal {
  std::map<std::size_t, std::string> rows;
  std::size_t end = 0;
};

Journal ReadJournal(std::string_view text, std::size_t begin, std::size_t tasks) {
  Journal journal;
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

std::vector<TableColumn> Asked(const std::vector<StudyColumn>& columns) {
  std::vector<TableColumn> asked;
  for (const StudyColumn& column : columns) asked.push_back({column.name, ColumnNeed::kRequired});
  return asked;
}

std::vector<StudyRow> RowsOf(CsvReader reader, const std::vector<StudyColumn>& columns) {
  std::vector<StudyRow> rows;
  while (reader.Next()) {
    StudyRow row(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!reader.Given(i)) continue;
      if (columns[i].kind == StudyCellKind::kText) {
        row[i] = std::string(reader.Text(i));
      } else if (columns[i].kind == StudyCellKind::kNumber) {
        row[i] = reader.Number(i);
      } else {
        row[i] = static_cast<std::int64_t>(reader.Number(i));
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

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
    for (auto found = waiting.find(next); found != waiting.end(); found = waiting.find(++next)) {
      ready += found->second;
      waiting.erase(found);
    }
    return ready;
  }
};

StudyRows::StudyRows(const fs::path& folder, StudyIdentity identity, StudyStart start)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.identity = std::move(identity);
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
  const std::string first = FirstLineOf(state.identity);
  std::string text;
  if (start == StudyStart::kResume) text = state.journal->Text();
  if (text.find('\n') == std::string::npos) text.clear();  // not even its first line was written
  if (!text.empty() && !text.starts_with(first)) {
    throw InputError(FilePlace{journal.string(), 0, ""},
                     "belongs to another study, or to another version of this one or of the "
                     "program; another folder, or --restart to compute all rows anew, is allowed");
  }
  if (text.empty()) {
    state.journal->Shorten(0);
    state.journal->Append(first);
  } else {
    Journal read = ReadJournal(text, first.size(), state.identity.tasks);
    state.journal->Shorten(read.end);
    const std::string heading = HeadingOf(state.identity.columns);
    for (auto& [task, rows] : read.rows) {
      const std::vector<StudyColumn>& columns = state.identity.columns;
      const std::string whole = heading + rows;
      state.earlier[task] = RowsOf(CsvReader(journal.string(), whole, Asked(columns)), columns);
      state.waiting[task] = std::move(rows);
    }
    state.kept = state.earlier.size();
  }
  AtomicFile study(folder / (state.identity.name + ".study.toml"));
  study.Write("# written by sarblock: the study of " + table.filename().string() + "\n");
  study.Write(state.identity.text);
  study.Commit();
  AtomicFile begin(table);
  begin.Write(HeadingOf(state.identity.columns));
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
  std::string text = TextOf(rows);
  state_->journal->Append(
      fmt::format("task {} rows {}\n{}{}\n", task, rows.size(), text, LastLineOf(task, text)));
  state_->waiting[task] = std::move(text);
  state_->table->Append(state_->TakeReady());
}

std::size_t StudyRows::kept() const { return state_->kept; }

std::string StudyTableText(const StudyTable& table) {
  return HeadingOf(table.columns()) + TextOf(table.rows());
}

StudyTable ReadStudyTable(const std::filesystem::path& file, std::vector<StudyColumn> columns) {
  std::vector<StudyRow> rows = RowsOf(CsvReader(file, Asked(columns)), columns);
  return {std::move(columns), std::move(rows)};
}

}  // namespace sarblock
