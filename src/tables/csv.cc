// SPDX-License-Identifier: Apache-2.0
#include "csv.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/text.h"
#include "table.h"
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

namespace sarblock {
namespace {

constexpr std::size_t kReadBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxLineBytes = std::size_t{1} << 26;  // more is no table of ours
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool IsBlank(char c) { return c == ' ' || c == '\t'; }

std::string_view Trimmed(const char* begin, const char* end) {
  while (begin != end && IsBlank(*begin)) ++begin;
  while (begin != end && IsBlank(end[-1])) --end;
  return {begin, static_cast<std::size_t>(end - begin)};
}

// First `wanted` in [begin, end), or end.
const char* Find(const char* begin, const char* end, char wanted) {
  const void* found = std::memchr(begin, wanted, static_cast<std::size_t>(end - begin));
  return found == nullptr ? end : static_cast<const char*>(found);
}

std::string Counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& file, std::span<const TableColumn> columns)
    : CsvReader(file.string(), CsvSource::Open(file), kReadBufferBytes, columns) {}

CsvReader::CsvReader(std::string name, std::string_view text, std::span<const TableColumn> columns)
    : CsvReader(std::move(name),
                CsvSource::InMemory(text),
                std::min(text.size() + 1, kReadBufferBytes),
                columns) {}

CsvReader::CsvReader(std::string name,
                     std::unique_ptr<CsvSource> source,
                     std::size_t buffer_bytes,
                     std::span<const TableColumn> columns)
    : TableReader(std::move(name), columns), source_(std::move(source)), buffer_(buffer_bytes) {
  ReadHeader(columns);
}

CsvReader::CsvReader(const CsvReader& whole, std::vector<char> lines, std::size_t line)
    : TableReader(whole),
      header_(whole.header_),
      header_line_(whole.header_line_),
      buffer_(std::move(lines)),
      end_(buffer_.size()),
      source_ended_(true),
      cells_(whole.cells_.size()) {
  line_ = line;
}

std::unique_ptr<TableReader> CsvReader::Part() {
  const auto last_line_end = [this] {
    const auto begin = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_);
    const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(end_);
    const auto stop =
        std::find(std::make_reverse_iterator(end), std::make_reverse_iterator(begin), '\n');
    return static_cast<std::size_t>(stop.base() - buffer_.begin());
  };
  std::size_t stop = last_line_end();
  while (stop == begin_) {  // no whole line: errors come where Next() meets them
    if (!Refill()) {
      stop = end_;
      break;
    }
    stop = last_line_end();
  }
  if (stop == begin_) return nullptr;
  std::vector<char> lines(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
                          buffer_.begin() + static_cast<std::ptrdiff_t>(stop));
  const std::size_t line = line_;
  line_ += static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n'));
  if (lines.back() != '\n') ++line_;
  begin_ = stop;
  return std::unique_ptr<TableReader>(new CsvReader(*this, std::move(lines), line));
}

CsvReader::~CsvReader() = default;
CsvReader::CsvReader(CsvReader&&) noexcept = default;
CsvReader& CsvReader::operator=(CsvReader&&) noexcept = default;

void CsvReader::ReadHeader(std::span<const TableColumn> columns) {
  std::string_view line;
  bool found = false;
  while (!found && NextLine(&line)) {
    ++line_;
    if (line_ == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
    found = !Trimmed(line.data(), line.data() + line.size()).empty() && line.front() != '#';
  }
  if (!found) throw InputError(FilePlace{file_, line_, ""}, "has no header row with column names");
  cells_.resize(1 + static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')));
  cells_.resize(Split(line));
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const auto known = std::find(names_.begin(), names_.end(), cells_[i]);
    if (known == names_.end()) {
      unknown_.emplace_back(cells_[i]);
      continue;
    }
    std::size_t& place = place_[static_cast<std::size_t>(known - names_.begin())];
    if (place != kAbsent) {
      throw InputError(FilePlace{file_, line_, *known}, "the column stands twice in the header");
    }
    place = i;
  }
  header_ = line;
  header_line_ = line_;
  RequireColumns(columns);
}

bool CsvReader::Next() {
  std::string_view line;
  while (NextLine(&line)) {
    ++line_;
    if (line.empty() || line.front() == '#') continue;
    if (IsBlank(line.front()) && Trimmed(line.data(), line.data() + line.size()).empty()) continue;
    const std::size_t count = Split(line);
    if (count != cells_.size()) {
      FailRow("the row has " + Counted(count, "cell") + ", the header has " +
              Counted(cells_.size(), "column"));
    }
    return true;
  }
  return false;
}

bool CsvReader::NextLine(std::string_view* line) {
  std::size_t searched = begin_;
  for (;;) {
    const char* const first = buffer_.data() + begin_;
    const char* const last = buffer_.data() + end_;
    const char* stop = Find(buffer_.data() + searched, last, '\n');
    if (stop == last) {
      const std::size_t rest = end_ - begin_;
      if (Refill()) {  // moves the text to the front of the buffer
        searched = begin_ + rest;
        continue;
      }
      if (rest == 0) return false;
      stop = buffer_.data() + end_;
      *line = {buffer_.data() + begin_, rest};
      begin_ = end_;
    } else {
      *line = {first, static_cast<std::size_t>(stop - first)};
      begin_ += line->size() + 1;
    }
    if (!line->empty() && line->back() == '\r') line->remove_suffix(1);
    return true;
  }
}

bool CsvReader::Refill() {
  if (source_ended_) return false;
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
            buffer_.begin() + static_cast<std::ptrdiff_t>(end_),
            buffer_.begin());
  end_ -= begin_;
  begin_ = 0;
  if (end_ == buffer_.size()) {
    if (buffer_.size() >= kMaxLineBytes) {
      throw InputError(FilePlace{file_, line_ + 1, ""},
                       "the line is longer than " + std::to_string(kMaxLineBytes) + " bytes");
    }
    buffer_.resize(2 * buffer_.size());
  }
  std::string problem;
  const std::size_t got = source_->Read(buffer_.data() + end_, buffer_.size() - end_, &problem);
  if (!problem.empty()) throw InputError(FilePlace{file_, line_ + 1, ""}, problem);
  end_ += got;
  source_ended_ = got == 0;
  return got > 0;
}

std::size_t CsvReader::Split(std::string_view line) {
  const char* at = line.data();
  const char* const end = at + line.size();
  unquoted_.clear();
  std::size_t count = 0;
  for (;;) {
    std::string_view cell;
    if (at != end && *at == '"') {
      if (unquoted_.capacity() < line.size()) unquoted_.reserve(line.size());  // views stay valid
      at = Unquote(at, end, &cell);
    } else {
      const char* const stop = Find(at, end, ',');
      cell = Trimmed(at, stop);
      at = stop;
    }
    if (count < cells_.size()) cells_[count] = cell;
    ++count;
    if (at == end) return count;
    ++at;
  }
}

// The cell that begins with the quote at `begin`; returns the comma or the end after it.
const char* CsvReader::Unquote(const char* begin, const char* end, std::string_view* cell) {
  const std::size_t offset = unquoted_.size();
  const char* at = begin + 1;
  for (;;) {
    const char* const quote = Find(at, end, '"');
    if (quote == end) FailRow("a quoted cell does not end on its line, a closing \" is needed");
    unquoted_.append(at, quote);
    at = quote + 1;
    if (at == end || *at != '"') break;
    unquoted_ += '"';  // a doubled quote
    ++at;
  }
  *cell = std::string_view(unquoted_).substr(offset);
  while (at != end && IsBlank(*at)) ++at;
  if (at != end && *at != ',') FailRow("text follows a closing quote, a comma is needed");
  return at;
}

FilePlace CsvReader::PlaceAt(std::size_t line, std::size_t column) const {
  return {file_, line == 0 ? header_line_ : line, names_[column]};
}

std::string CsvReader::NameOfLine(std::size_t line) const { return "line " + std::to_string(line); }

void CsvReader::FailRow(const std::string& problem) const {
  throw InputError(FilePlace{file_, line_, ""}, problem);
}

namespace {

class PlainSource final : public CsvSource {
 public:
  explicit PlainSource(int descriptor) : descriptor_(descriptor) {}
  ~PlainSource() override { ::close(descriptor_); }
  PlainSource(const PlainSource&) = delete;
  PlainSource& operator=(const PlainSource&) = delete;

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

class GzipSource final : public CsvSource {
 public:
  explicit GzipSource(gzFile file) : file_(file) {}
  ~GzipSource() override { gzclose_r(file_); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;

  std::size_t Read(char* to, std::size_t size, std::string* problem) override {
    const int got = gzread(file_, to, static_cast<unsigned>(std::min<std::size_t>(size, 1u << 30)));
    if (got > 0) {
      if (gzdirect(file_) != 0) {
        *problem = "is not gzip data, which the name's ending .gz promises";
        return 0;
      }
      return static_cast<std::size_t>(got);
    }
    int code = Z_OK;
    const char* text = gzerror(file_, &code);
    if (code == Z_BUF_ERROR) {
      *problem = "the gzip data end too early; the file was cut off";
    } else if (got < 0) {
      *problem = std::string("the gzip data are damaged (") + text + ")";
    }
    return 0;
  }

 private:
  gzFile file_;
};

class MemorySource final : public CsvSource {
 public:
  explicit MemorySource(std::string_view text) : text_(text) {}
  std::size_t Read(char* to, std::size_t size, std::string* /*problem*/) override {
    const std::size_t count = text_.copy(to, size);
    text_.remove_prefix(count);
    return count;
  }

 private:
  std::string_view text_;
};

}  // namespace

std::unique_ptr<CsvSource> CsvSource::Open(const std::filesystem::path& file) {
  const FilePlace place{file.string(), 0, ""};
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    throw InputError(place, std::string("cannot be opened: ") + std::strerror(errno));
  }
  if (file.extension() != ".gz") return std::make_unique<PlainSource>(descriptor);
  gzFile gzip = gzdopen(descriptor, "rb");
  if (gzip == nullptr) {
    ::close(descriptor);
    throw InputError(place, "cannot be opened: out of memory");
  }
  gzbuffer(gzip, 1u << 18);
  return std::make_unique<GzipSource>(gzip);
}

std::unique_ptr<CsvSource> CsvSource::InMemory(std::string_view text) {
  return std::make_unique<MemorySource>(text);
}

void AppendCsvText(std::string_view text, std::string* row) {
  const bool blank_end = !text.empty() && (text.front() == ' ' || text.front() == '\t' ||
                                           text.back() == ' ' || text.back() == '\t');
  const bool byte_order_mark = text.starts_with("\xEF\xBB\xBF");
  if (!blank_end && !byte_order_mark && !text.starts_with('#') &&
      text.find_first_of(",\"\r\n") == std::string_view::npos) {
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

CsvWriter::CsvWriter(const std::filesystem::path& file,
                     const std::vector<std::string_view>& columns,
                     Compression compression)
    : file_(std::in_place, file, compression), name_(file.string()), columns_(columns.size()) {
  for (const std::string_view column : columns) Text(column);
  EndRow();
}

CsvWriter::CsvWriter(std::string name, std::size_t columns)
    : name_(std::move(name)), columns_(columns) {}

void CsvWriter::Separate() {
  if (cells_++ > 0) row_ += ',';
}

CsvWriter& CsvWriter::Text(std::string_view text) {
  Separate();
  AppendCsvText(text, &row_);
  return *this;
}

void CsvWriter::PutNumber(double value) {
  RefuseInfinity(value, name_);
  Separate();
  if (!std::isnan(value)) AppendNumber(value, &row_);
}

void CsvWriter::PutInteger(std::int64_t value) {
  Separate();
  row_ += std::to_string(value);
}

CsvWriter& CsvWriter::Empty(std::size_t cells) {
  for (std::size_t i = 0; i < cells; ++i) Separate();
  return *this;
}

void CsvWriter::EndRow() {
  if (cells_ != columns_)
    throw std::logic_error("a row was about to be written with cells missing");
  row_ += '\n';
  cells_ = 0;
  if (!file_) return;
  file_->Write(row_);
  row_.clear();
}

void CsvWriter::Commit() { file_.value().Commit(); }

std::unique_ptr<TableWriter> CsvWriter::Part() {
  return std::unique_ptr<TableWriter>(new CsvWriter(name_, columns_));
}

std::size_t CsvWriter::rows_of_part() const { return kRowsPerPiece; }

void CsvWriter::Append(TableWriter* part) {
  std::string& rows = dynamic_cast<CsvWriter&>(*part).row_;
  file_.value().Write(rows);
  rows.clear();
}

}  // namespace sarblock
