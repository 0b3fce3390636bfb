// SPDX-License-Identifier: Apache-2.0
#include "nitf_text.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/text.h"

namespace sarblock {
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

}  // namespace sarblock
