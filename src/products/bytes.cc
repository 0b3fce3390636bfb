// SPDX-License-Identifier: Apache-2.0
#include "bytes.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/text.h"
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

ByteSource ByteSource::FromFile(const std::string& file) {
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

ByteSource ByteSource::FromBytes(std::string_view bytes, const std::string& file) {
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

namespace {

/// Fields of a header, one after the other (MIL-STD-2500C, table A-1).
class Fields {
 public:
  Fields(ByteSource* source, std::uint64_t at) : source_(source), at_(at) {}
  std::uint64_t Number(std::uint64_t digits, const char* field) {
    const std::string text = source_->Read(at_, digits, field);
    at_ += digits;
    std::uint64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end) {
      throw InputError(
          FilePlace{source_->file(), 0, field},
          Quoted(text) + " is no number, " + std::to_string(digits) + " digits are needed");
    }
    return value;
  }

 private:
  ByteSource* source_;
  std::uint64_t at_;
};

/// Lengths of the subheader and the data of a segment.
struct Segment {
  std::uint64_t head = 0, data = 0;
};
struct SegmentKind {
  const char* count;
  const char* head;
  const char* data;
  std::uint64_t head_digits, data_digits;
};
std::vector<Segment> ReadSegments(Fields* fields, const SegmentKind& kind) {
  std::vector<Segment> segments(fields->Number(3, kind.count));
  for (Segment& segment : segments) {
    segment.head = fields->Number(kind.head_digits, kind.head);
    segment.data = fields->Number(kind.data_digits, kind.data);
  }
  return segments;
}

bool IsSicd(const std::string& subheader) {
  constexpr std::size_t kIdAt = 2, kIdBytes = 25;
  if (subheader.size() < kIdAt + kIdBytes) return false;
  std::string id = subheader.substr(kIdAt, kIdBytes);
  while (id.ends_with(' ')) id.pop_back();
  return id == "XML_DATA_CONTENT" || id == "SICD_XML";  // the latter of versions before 1.0
}

}  // namespace

std::string SicdTextOfNitf(ByteSource* source) {
  constexpr std::uint64_t kHeaderLengthAt = 354, kHeaderLengthDigits = 6;
  Fields fields(source, kHeaderLengthAt);
  std::uint64_t at = fields.Number(kHeaderLengthDigits, "HL");
  const auto skip = [&](const SegmentKind& kind) {
    for (const Segment& segment : ReadSegments(&fields, kind)) at += segment.head + segment.data;
  };
  skip({"NUMI", "LISH", "LI", 6, 10});
  skip({"NUMS", "LSSH", "LS", 4, 6});
  static_cast<void>(fields.Number(3, "NUMX"));
  skip({"NUMT", "LTSH", "LT", 4, 5});
  for (const Segment& segment : ReadSegments(&fields, {"NUMDES", "LDSH", "LD", 4, 9})) {
    if (IsSicd(source->Read(at, segment.head, "data extension subheader"))) {
      if (segment.data > kLargestSicdText) {
        throw InputError(FilePlace{source->file(), 0, "LD"},
                         "the XML is larger than 64 MiB, which no metadata are");
      }
      std::string text = source->Read(at + segment.head, segment.data, "XML_DATA_CONTENT");
      if (text.find("<SICD") != std::string::npos) return text;
    }
    at += segment.head + segment.data;
  }
  throw InputError(FilePlace{source->file(), 0, "XML_DATA_CONTENT"},
                   "is in no data extension segment: the NITF file of a SICD image is needed");
}

std::string SicdText(ByteSource* source) {
  constexpr std::uint64_t kMagicBytes = 9;
  const std::string magic = source->Read(0, std::min(kMagicBytes, source->size()), "file header");
  if (magic == "NITF02.10" || magic == "NSIF01.00") return SicdTextOfNitf(source);
  if (source->size() > kLargestSicdText) {
    throw InputError(FilePlace{source->file(), 0, ""}, "is larger than 64 MiB, which no XML is");
  }
  return source->Read(0, source->size(), "text");
}

double WireField::Double() const { return LittleEndianDouble(bytes.data()); }

std::vector<double> WireField::Doubles() const {
  std::vector<double> numbers;
  for (std::size_t i = 0; i + sizeof(double) <= bytes.size(); i += sizeof(double)) {
    numbers.push_back(LittleEndianDouble(bytes.data() + i));
  }
  return numbers;
}

void WireReader::Fail(const std::string& problem) const {
  throw InputError(FilePlace{*file_, 0, fmt::format("byte {}", offset_ + at_)}, problem);
}

std::string_view WireReader::Take(std::uint64_t count) {
  if (count > message_.size() - at_) {
    Fail(fmt::format(
        "a field of {} bytes in a message that has {} left", count, message_.size() - at_));
  }
  const std::string_view taken = message_.substr(at_, count);
  at_ += count;
  return taken;
}

std::uint64_t WireReader::Varint() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const auto byte = static_cast<unsigned char>(Take(1).front());
    value |= static_cast<std::uint64_t>(byte & 0x7fU) << shift;
    if ((byte & 0x80U) == 0) return value;
  }
  Fail("a number of more than ten bytes");
}

bool WireReader::Next(WireField* field) {
  if (AtEnd()) return false;
  const std::uint64_t key = Varint();
  field->number = static_cast<std::uint32_t>(key >> 3U);
  field->type = static_cast<std::uint32_t>(key & 7U);
  field->bytes = {};
  switch (field->type) {
    case 0:
      field->varint = Varint();
      return true;
    case 1:
      field->bytes = Take(8);
      return true;
    case 2:
      field->bytes = Take(Varint());
      return true;
    case 5:
      field->bytes = Take(4);
      return true;
    default:
      Fail(fmt::format("a field of type {}, which no network has", field->type));
  }
}

}  // namespace sarblock
