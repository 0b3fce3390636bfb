// SPDX-License-Identifier: Apache-2.0
#include "byte_source.h"

#include "sarblock/core/error.h"

#include <bit>
#include <filesystem>

#include <fmt/core.h>

namespace sarblock {
namespace {

template <typename Bits>
Bits BitsOf(const char* bytes) {
  Bits bits = 0;
  for (std::size_t i = 0; i < sizeof(Bits); ++i) {
    bits |= static_cast<Bits>(static_cast<unsigned char>(bytes[i])) << (8 * i);
  }
  return bits;
}

}  // namespace

ByteSource ByteSource::OfFile(const std::string& file) {
  ByteSource source;
  source.file_ = file;
  source.stream_.open(file, std::ios::binary);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || !source.stream_) {
    throw InputError(FilePlace{file, 0, ""}, "cannot be opened, a file is needed");
  }
  source.size_ = std::filesystem::file_size(file);
  return source;
}

ByteSource ByteSource::OfBytes(std::string_view bytes, const std::string& file) {
  ByteSource source;
  source.file_ = file;
  source.bytes_ = bytes;
  source.size_ = bytes.size();
  return source;
}

std::string ByteSource::Read(std::uint64_t offset, std::uint64_t count, const char* what) {
  if (offset > size_ || count > size_ - offset) {
    throw InputError(FilePlace{file_, 0, what},
                     fmt::format("{} bytes from byte {} are not in the file, which has {}: it is "
                                 "cut short or its sizes are wrong",
                                 count,
                                 offset,
                                 size_));
  }
  if (!stream_.is_open()) return std::string(bytes_.substr(offset, count));
  std::string bytes(count, '\0');
  // Seeking drops the buffer of the stream.
  if (stream_.tellg() != static_cast<std::streamoff>(offset)) {
    stream_.seekg(static_cast<std::streamoff>(offset));
  }
  if (!stream_.read(bytes.data(), static_cast<std::streamsize>(count))) {
    throw InputError(FilePlace{file_, 0, what}, "cannot be read");
  }
  return bytes;
}

std::uint32_t LittleEndianUint32(const char* bytes) { return BitsOf<std::uint32_t>(bytes); }

double LittleEndianDouble(const char* bytes) {
  return std::bit_cast<double>(BitsOf<std::uint64_t>(bytes));
}

}  // namespace sarblock
