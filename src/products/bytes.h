// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// The bytes of a binary file, read where they are asked for: a cube of gigabytes costs the memory
/// of its label and its tables. Every refusal is an InputError with the file.
class ByteSource {
 public:
  [[nodiscard]] static ByteSource FromFile(const std::string& file);
  /// Reads `bytes`, which must outlive the source; `file` is for messages.
  [[nodiscard]] static ByteSource FromBytes(std::string_view bytes, const std::string& file);

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

/// A number as stored in a file, least significant byte first.
[[nodiscard]] std::uint32_t LittleEndianUint32(const char* bytes);
[[nodiscard]] double LittleEndianDouble(const char* bytes);

/// Bytes; files of a few hundred thousand are usual.
inline constexpr std::uint64_t kLargestSicdText = 64U << 20U;

/// The XML of a SICD image in a NITF file: the first data extension segment of that kind. Only the
/// lengths of the other segments are read. Throws InputError with the file and the field for
/// lengths that are no numbers or lie beyond the end of the file, and if there is no such segment.
[[nodiscard]] std::string SicdTextOfNitf(ByteSource* source);

/// The XML of a SICD image, in a NITF file or alone.
[[nodiscard]] std::string SicdText(ByteSource* source);

/// One field of a message in the wire format of protocol buffers: a key (number and type) and a
/// value. Types: 0 varint, 1 eight bytes, 2 bytes with their length before them, 5 four bytes.
struct WireField {
  std::uint32_t number = 0;
  std::uint32_t type = 0;
  std::uint64_t varint = 0;  ///< type 0
  std::string_view bytes;    ///< of the value; types 1, 2 and 5

  [[nodiscard]] double Double() const;                ///< type 1
  [[nodiscard]] std::vector<double> Doubles() const;  ///< types 1 and 2 (packed)
};

/// Walks the fields of a message; what is cut short or of no known type throws InputError naming
/// `file` and the byte, which is counted from `offset`, the message's place in it.
class WireReader {
 public:
  WireReader(std::string_view message, const std::string& file, std::uint64_t offset)
      : message_(message), file_(&file), offset_(offset) {}

  [[nodiscard]] bool Next(WireField* field);
  /// A single varint, as in a packed list.
  [[nodiscard]] std::uint64_t Varint();
  [[nodiscard]] bool AtEnd() const { return at_ == message_.size(); }
  /// Where the value of the field that was read last begins in the file.
  [[nodiscard]] std::uint64_t ValueOffset(const WireField& field) const {
    return offset_ + static_cast<std::uint64_t>(field.bytes.data() - message_.data());
  }
  [[noreturn]] void Fail(const std::string& problem) const;

 private:
  [[nodiscard]] std::string_view Take(std::uint64_t count);
  std::string_view message_;
  const std::string* file_;
  std::uint64_t offset_;
  std::size_t at_ = 0;
};

}  // namespace sarblock
