// SPDX-License-Identifier: Apache-2.0
#include "wire_reader.h"

#include "sarblock/core/error.h"

#include "byte_source.h"
#include <fmt/core.h>

namespace sarblock {

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
