// SPDX-License-Identifier: Apache-2.0
#include "csv.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include "checksum.h"
#include "core/text.h"
#include "table.h"
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

namespace sarblock {
namespace {

constexpr std::size_t kBytesAtOnce = std::size_t{1} << 20;
constexpr std::size_t kMaxLineBytes = std::size_t{1} << 26;  // more is no table of ours
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool IsBlank(char c) { return c == ' ' || c == '\t'; }

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string Counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

class PlainFile final : public TableBytes {
 public:
  explicit PlainFile(int descriptor) : descriptor_(descriptor) {}
  ~PlainFile() override { ::close(descriptor_); }
  PlainFile(const PlainFile&) = delete;
  PlainFile& operator=(const PlainFile&) = delete;

  std::size_t Read(char* to, std::size_t size, std::string* problem) override {
    ssize_t got = 0;
    do {
      got = ::read(descriptor_, to, size);
    } while (got < 0 && errno == EINTR);
    if (got >= 0) return static_cast<std::size_t>(got);
    *problem = std::string("cannot be read: ") + std::strerror(errno);
    return 0;
  }

 private:
  int descriptor_;
};

/// One gzip stream or several behind each other, as RFC 1952 allows. (zlib's own gzread() drops
/// what stands behind them, whatever it is.)
class GzipFile final : public TableBytes {
 public:
  explicit GzipFile(int descriptor) : file_(descriptor), input_(std::size_t{1} << 18) {
    constexpr int kWindowBits = 15, kGzip = 16;
    if (inflateInit2(&stream_, kWindowBits + kGzip) != Z_OK) throw std::bad_alloc();
  }
  ~GzipFile() override { inflateEnd(&stream_); }
  GzipFile(const GzipFile&) = delete;
  GzipFile& operator=(const GzipFile&) = delete;

  std::size_t Read(char* to, std::size_t size, std::string* problem) override {
    constexpr std::size_t kMax = std::size_t{1} << 30;
    const std::size_t wanted = std::min(size, kMax);
    stream_.next_out = reinterpret_cast<Bytef*>(to);
    stream_.avail_out = static_cast<uInt>(wanted);
    while (stream_.avail_out > 0 && problem_.empty() && GoOn(&problem_)) {
    }
    const std::size_t got = wanted - stream_.avail_out;
    if (got == 0) *problem = problem_;  // reported after the last complete rows
    return got;
  }

 private:
  /// False at the end of the file, and where something is wrong.
  bool GoOn(std::string* problem) {
    if (stream_.avail_in == 0) {
      const std::size_t got = file_.Read(input_.data(), input_.size(), problem);
      stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
      stream_.avail_in = static_cast<uInt>(got);
      if (got == 0) {
        if (in_stream_ && problem->empty()) {
          *problem = "the gzip data end too early; the file was cut off";
        }
        return false;
      }
    }
    if (!in_stream_) {
      if (streams_ > 0 && *stream_.next_in == 0) {  // a medium filled up the last block
        ++stream_.next_in;
        --stream_.avail_in;
        return true;
      }
      if (streams_ > 0) inflateReset(&stream_);
      in_stream_ = true;
      ++streams_;
    }
    const int code = inflate(&stream_, Z_NO_FLUSH);
    if (code == Z_STREAM_END) {
      in_stream_ = false;
    } else if (code != Z_OK && code != Z_BUF_ERROR) {
      const bool begins = stream_.total_out == 0 && stream_.total_in < 10;  // the header's bytes
      *problem = !begins ? std::string("the gzip data are damaged (") +
                               (stream_.msg != nullptr ? stream_.msg : "out of memory") + ")"
                 : streams_ == 1
                     ? "is not gzip data, which the name's ending .gz promises"
                     : "the gzip data end here and other bytes follow; rows that are appended must "
                       "be compressed too";
    }
    return problem->empty();
  }

  PlainFile file_;
  std::vector<char> input_;
  z_stream stream_{};
  bool in_stream_ = false;
  std::size_t streams_ = 0;
  std::string problem_;
};

/// Bytes that must have this checksum when they end.
class CheckedBytes final : public TableBytes {
 public:
  CheckedBytes(std::unique_ptr<TableBytes> source, std::string sha256)
      : source_(std::move(source)), sha256_(std::move(sha256)) {}
  std::size_t Read(char* to, std::size_t size, std::string* problem) override {
    const std::size_t got = source_->Read(to, size, problem);
    if (got > 0) {
      sum_.Add({to, got});
    } else if (problem->empty() && std::exchange(sha256_, {}) != sum_.Digits()) {
      *problem =
          "is not the table that summary.json was written with (sha256): changed since, or of "
          "another run";
    }
    return got;
  }

 private:
  std::unique_ptr<TableBytes> source_;
  std::string sha256_;
  Sha256 sum_;
};

class TextInMemory final : public TableBytes {
 public:
  explicit TextInMemory(std::string_view text) : text_(text) {}
  std::size_t Read(char* to, std::size_t size, std::string* /*problem*/) override {
    const std::size_t count = text_.copy(to, size);
    text_.remove_prefix(count);
    return count;
  }
  bool MayBeCutOff() const override { return false; }

 private:
  std::string_view text_;
};

}  // namespace

std::unique_ptr<TableBytes> OpenBytes(const std::filesystem::path& file,
                                      const std::string& sha256) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    throw InputError(FilePlace{file.string(), 0, ""},
                     std::string("cannot be opened: ") + std::strerror(errno));
  }
  std::unique_ptr<TableBytes> source;
  if (file.extension() == ".gz") {
    source = std::make_unique<GzipFile>(descriptor);
  } else {
    source = std::make_unique<PlainFile>(descriptor);
  }
  if (sha256.empty()) return source;
  return std::make_unique<CheckedBytes>(std::move(source), sha256);
}

namespace {

/// The first line of a text, which loses it.
std::string_view TakeLine(std::string_view* text) {
  const std::size_t end = std::min(text->find('\n'), text->size());
  std::string_view line = text->substr(0, end);
  text->remove_prefix(std::min(end + 1, text->size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

bool IsRow(std::string_view line) {
  return !line.empty() && line.front() != '#' && !(IsBlank(line.front()) && Trimmed(line).empty());
}

/// The cells of a line, one after the other.
class Cells {
 public:
  explicit Cells(std::string_view line) : rest_(line) {}
  /// False behind the last cell, or where problem() says what is wrong with the line. The cell is
  /// valid until the next call.
  bool Next(std::string_view* cell) {
    if (ended_) return false;
    if (!rest_.empty() && rest_.front() == '"') {
      if (!Unquote()) return false;
      *cell = unquoted_;
    } else {
      const std::size_t comma = std::min(rest_.find(','), rest_.size());
      *cell = Trimmed(rest_.substr(0, comma));
      rest_.remove_prefix(comma);
    }
    ended_ = rest_.empty();
    if (!ended_) rest_.remove_prefix(1);
    return true;
  }
  [[nodiscard]] const char* problem() const { return problem_; }

 private:
  bool Unquote() {
    unquoted_.clear();
    rest_.remove_prefix(1);
    for (;;) {
      const std::size_t quote = rest_.find('"');
      if (quote == std::string_view::npos) {
        problem_ = "a quoted cell does not end on its line, a closing \" is needed";
        return false;
      }
      unquoted_ += rest_.substr(0, quote);
      rest_.remove_prefix(quote + 1);
      if (!rest_.starts_with('"')) break;
      unquoted_ += '"';  // a doubled quote
      rest_.remove_prefix(1);
    }
    while (!rest_.empty() && IsBlank(rest_.front())) rest_.remove_prefix(1);
    if (rest_.empty() || rest_.front() == ',') return true;
    problem_ = "text follows a closing quote, a comma is needed";
    return false;
  }
  std::string_view rest_;
  std::string unquoted_;
  const char* problem_ = nullptr;
  bool ended_ = false;
};

class CsvReader final : public TableReader {
 public:
  CsvReader(std::string name, std::unique_ptr<TableBytes> source, Schema schema)
      : TableReader(std::move(name), schema), source_(std::move(source)) {
    ReadHeader();
    RequireColumns();
  }

  bool Next(Batch* batch) override {
    if (!TakeLines(&batch->text)) return false;
    batch->first = lines_;
    lines_ += static_cast<std::size_t>(std::count(batch->text.begin(), batch->text.end(), '\n'));
    if (batch->text.back() != '\n') {
      ++lines_;
      unended_ = true;
    }
    return true;
  }

  void Parse(Batch* batch) const override {
    batch->Begin(schema_);
    batch->table = this;
    for (std::size_t i = 0; i < schema_.size(); ++i) {
      if (!Has(i)) batch->columns[i].texts = nullptr;
    }
    std::string_view rest = batch->text;
    for (std::uint32_t number = 1; !rest.empty(); ++number) {
      const std::string_view line = TakeLine(&rest);
      if (line.starts_with('#')) NoteComment(line, batch->first + number);
      if (!IsRow(line)) continue;
      if (const std::string problem = ParseRow(line, batch); !problem.empty()) {
        const FilePlace place{file_, batch->first + number, ""};
        batch->error = std::make_exception_ptr(InputError(place, problem));
        return;
      }
      batch->line.push_back(number);
      ++batch->rows;
    }
  }

  std::string TextOfCell(const Row& row, std::size_t column) const override {
    std::string_view rest = row.batch().text, line, cell;
    for (std::size_t i = row.batch().first; i < row.line(); ++i) line = TakeLine(&rest);
    Cells cells(line);
    for (std::size_t i = 0; i <= place_[column]; ++i) static_cast<void>(cells.Next(&cell));
    return std::string(cell);
  }
  FilePlace PlaceAt(std::size_t line, std::size_t column) const override {
    return {file_, line == 0 ? header_line_ : line, names_[column]};
  }
  std::string NameOfLine(std::size_t line) const override { return "line " + std::to_string(line); }
  std::vector<std::string> doubts() const override {
    std::vector<std::string> doubts;
    if (unended_ && source_->MayBeCutOff()) {
      doubts.emplace_back(
          "the last row does not end with a newline: the file may have been cut off there, and the "
          "row's last number with it");
    }
    if (const std::size_t count = row_comments_.count; count > 0) {
      doubts.push_back(
          (count == 1 ? "a line that begins with # has as many cells as the header and is"
                      : std::to_string(count) +
                            " lines that begin with # have as many cells as the header and are") +
          std::string(" taken for ") + (count == 1 ? "a comment" : "comments") + " (line " +
          std::to_string(row_comments_.first_line) +
          "): a name that begins with # must stand in quotes");
    }
    return doubts;
  }
  std::size_t first_commented_row() const override {
    return row_comments_.count > 0 ? row_comments_.first_line.load() : 0;
  }

 private:
  /// Whole lines, as many as are read; the last one may lack its end. False at the end.
  bool TakeLines(std::string* text) {
    text->assign(begun_);
    begun_.clear();
    std::size_t searched = 0;
    for (;;) {
      const std::size_t end = std::string_view(*text).substr(searched).rfind('\n');
      if (end != std::string_view::npos) {
        begun_ = text->substr(searched + end + 1);
        text->resize(searched + end + 1);
        return true;
      }
      searched = text->size();
      if (searched >= kMaxLineBytes) {
        FailLine(lines_ + 1, "the line is longer than " + std::to_string(kMaxLineBytes) + " bytes");
      }
      std::string problem;
      text->resize(searched + kBytesAtOnce);
      text->resize(searched + source_->Read(text->data() + searched, kBytesAtOnce, &problem));
      if (!problem.empty()) FailLine(lines_ + 1, problem);
      if (text->size() == searched) return !text->empty();
    }
  }

  void ReadHeader() {
    std::string text;
    std::string_view rest, line;
    do {
      if (rest.empty()) {
        if (!TakeLines(&text)) FailLine(lines_, "has no header row with column names");
        rest = text;
      }
      line = TakeLine(&rest);
      if (++lines_ == 1 && line.starts_with(kByteOrderMark)) {
        line.remove_prefix(kByteOrderMark.size());
      }
    } while (!IsRow(line));
    header_ = line;
    header_line_ = lines_;
    begun_.insert(0, rest);
    Cells cells(header_);
    for (std::string_view cell; cells.Next(&cell);) PlaceColumn(cell);
    if (cells.problem() != nullptr) FailLine(lines_, cells.problem());
  }
  void PlaceColumn(std::string_view name) {
    const auto known = std::find(names_.begin(), names_.end(), name);
    const auto column = static_cast<std::size_t>(known - names_.begin());
    if (known == names_.end()) {
      unknown_.emplace_back(name);
    } else if (place_[column] != kAbsent) {
      throw InputError(FilePlace{file_, lines_, *known}, "the header has this column twice");
    } else {
      place_[column] = column_of_cell_.size();
    }
    column_of_cell_.push_back(column);
  }

  /// A comment that reads like a row.
  void NoteComment(std::string_view text, std::size_t line) const {
    const auto commas = static_cast<std::size_t>(std::count(text.begin(), text.end(), ','));
    if (column_of_cell_.size() < 2 || commas + 1 != column_of_cell_.size()) return;
    ++row_comments_.count;
    std::size_t first = row_comments_.first_line;
    while (line < first && !row_comments_.first_line.compare_exchange_weak(first, line)) {
    }
  }

  /// Cells of a row of the batch; what is wrong with it, if anything.
  std::string ParseRow(std::string_view line, Batch* batch) const {
    std::size_t count = 0;
    Cells cells(line);
    for (std::string_view cell; cells.Next(&cell); ++count) {
      if (count >= column_of_cell_.size() || column_of_cell_[count] == schema_.size()) continue;
      const std::size_t i = column_of_cell_[count];
      if (IsText(schema_[i].kind)) {
        batch->columns[i].AppendText(cell);
      } else if (!cell.empty()) {
        batch->columns[i].SetNumber(batch->rows, NumberOfText(cell, schema_[i].kind));
      }
    }
    if (cells.problem() != nullptr) return cells.problem();
    if (count == column_of_cell_.size()) return {};
    return "the row has " + Counted(count, "cell") + ", the header has " +
           Counted(column_of_cell_.size(), "column");
  }
  [[noreturn]] void FailLine(std::size_t line, const std::string& problem) const {
    throw InputError(FilePlace{file_, line, ""}, problem);
  }
  std::string ColumnsThere() const override { return "the header has " + header_; }

  std::unique_ptr<TableBytes> source_;
  std::string header_;
  std::string begun_;  // what was read behind the lines that were taken
  std::size_t header_line_ = 0, lines_ = 0;
  std::vector<std::size_t> column_of_cell_;  // schema_.size(): one nobody knows
  bool unended_ = false;                     // the last line has no end
  struct RowComments {
    std::atomic<std::size_t> count{0};
    std::atomic<std::size_t> first_line{std::numeric_limits<std::size_t>::max()};
  };
  mutable RowComments row_comments_;
};

class CsvWriter final : public TableWriter {
 public:
  CsvWriter(const std::filesystem::path& file,
            Schema schema,
            Compression compression,
            std::span<const std::string_view> left_out)
      : TableWriter(schema, left_out), file_(file, compression), name_(file.string()) {
    std::string header;
    for (const std::size_t i : written_) {
      if (!header.empty()) header += ',';
      AppendCsvText(schema[i].name, &header);
    }
    file_.Write(header + '\n');
  }

  void Format(Batch* batch) const override {
    for (const std::size_t i : written_) batch->columns[i].SettleNumbers(name_);
    std::string& text = batch->text;
    text.clear();
    for (std::size_t row = 0; row < batch->rows; ++row) {
      for (const std::size_t i : written_) {
        if (i != written_.front()) text += ',';
        const Column& column = batch->columns[i];
        const double value = column.Number(row);
        if (column.texts != nullptr) {
          AppendCsvText((*column.texts)[column.indices[row]], &text);
        } else if (IsInteger(schema_[i].kind) && !std::isnan(value)) {
          text += std::to_string(static_cast<std::int64_t>(value));
        } else if (!std::isnan(value)) {
          AppendNumber(value, &text);
        }
      }
      text += '\n';
    }
  }
  void Write(Batch* batch) override { file_.Write(batch->text); }
  void Commit() override { file_.Commit(); }

 private:
  AtomicFile file_;
  std::string name_;
};

}  // namespace

std::unique_ptr<TableReader> ReadCsv(const std::filesystem::path& file,
                                     Schema schema,
                                     const std::string& sha256) {
  return std::make_unique<CsvReader>(file.string(), OpenBytes(file, sha256), schema);
}

std::unique_ptr<TableReader> ReadCsvText(std::string name, std::string_view text, Schema schema) {
  return std::make_unique<CsvReader>(std::move(name), std::make_unique<TextInMemory>(text), schema);
}

std::unique_ptr<TableWriter> WriteCsv(const std::filesystem::path& file,
                                      Schema schema,
                                      Compression compression,
                                      std::span<const std::string_view> left_out) {
  return std::make_unique<CsvWriter>(file, schema, compression, left_out);
}

void AppendCsvText(std::string_view text, std::string* row) {
  if (Trimmed(text).size() == text.size() && !text.starts_with(kByteOrderMark) &&
      !text.starts_with('#') && text.find_first_of(",\"\r\n") == std::string_view::npos) {
    *row += text;
    return;
  }
  *row += '"';
  for (const char c : text) {
    if (c == '"') *row += '"';
    *row += c;
  }
  *row += '"';
}

}  // namespace sarblock
