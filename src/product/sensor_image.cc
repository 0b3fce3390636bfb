// SPDX-License-Identifier: Apache-2.0
#include "product/sensor_image.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <string_view>

#include "byte_source.h"
#include "csm_isd_parts.h"
#include "product/csm_isd.h"
#include "product/isis_cube.h"

namespace sarblock {
namespace {

std::string ReadXml(const std::string& file) {
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 30U;
  ByteSource source = ByteSource::OfFile(file);
  if (source.size() > kLargest) {
    throw InputError(FilePlace{file, 0, ""}, "is larger than 1 GiB, which no such file is");
  }
  return source.Read(0, source.size(), "text");
}

// What stands at the front, without a byte order mark and blanks.
std::string FrontOf(const std::string& file) {
  constexpr std::uint64_t kFront = 256;
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf", kBlanks = " \t\r\n";
  ByteSource source = ByteSource::OfFile(file);
  std::string front = source.Read(0, std::min(kFront, source.size()), "text");
  if (front.starts_with(kByteOrderMark)) front.erase(0, kByteOrderMark.size());
  front.erase(0, std::min(front.size(), front.find_first_not_of(kBlanks)));
  return front;
}

}  // namespace

Sentinel1Product ReadSentinel1(const std::string& file) {
  return ParseSentinel1(ReadXml(file), file);
}

OrbitFile ReadOrbitFile(const std::string& file) { return ParseOrbitFile(ReadXml(file), file); }

SensorImage ReadSensorImage(const std::string& file, NisarFrequency frequency) {
  const std::string front = FrontOf(file);
  if (front.starts_with("\x89HDF")) return ReadNisar(file, frequency);
  if (front.starts_with("NITF") || front.starts_with("NSIF")) return ReadSicd(file);
  if (front.starts_with("<")) {
    if (front.find("<SICD") != std::string::npos) return ReadSicd(file);
    return ReadSentinel1(file);
  }
  if (front.starts_with("{") || front.starts_with(kCsmModelName)) return ReadCsmIsd(file);
  if (front.starts_with("Object")) return ReadIsisCube(file);
  throw InputError(FilePlace{file, 0, ""},
                   "is no image that is read: a Sentinel-1 annotation (XML), an RSLC of NISAR "
                   "(HDF5), a SICD image (NITF, XML), a cube of ISIS or an ISD (JSON) is needed");
}

}  // namespace sarblock
