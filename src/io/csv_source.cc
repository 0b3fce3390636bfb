// SPDX-License-Identifier: Apache-2.0
#include "csv_source.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

namespace sarblock {
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

}  // namespace sarblock
