// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace sarblock {

/// The bytes of a binary file, read where they are asked for: a cube of gigabytes costs the memory
/// of its label and its tables. Every refusal is an InputError with the file.
class ByteSource {
 public:
  [[nodiscard]] static ByteSource OfFile(const std::string& file);
  /// Of bytes that outlive the source; `file` is for messages.
  [[nodiscard]] static ByteSource OfBytes(std::string_view bytes, const std::string& file);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// `count` bytes from `offset`. `what` names them where they do not lie in the file.
  [[nodiscard]] std::string Read(std::uint64_t offset, std::uint64_t count, const char* what);

 private:
  ByteSource() = default;
  std::string file_;
  std::uint64_t size_ = 0;
  std::string_view bytes_;
  std::ifstream stream_;
};

/// A number as it stands in a file, least significant byte first.
[[nodiscard]] std::uint32_t LittleEndianUint32(const char* bytes);
[[nodiscard]] double LittleEndianDouble(const char* bytes);

}  // namespace sarblock
