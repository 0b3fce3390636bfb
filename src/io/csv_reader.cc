// SPDX-License-Identifier: Apache-2.0
#include "csv_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "core/text.h"
#include "csv_source.h"

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

}  // namespace sarblock
