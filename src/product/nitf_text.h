// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "byte_source.h"

namespace sarblock {

/// Bytes; files of a few hundred thousand are usual.
inline constexpr std::uint64_t kLargestSicdText = 64U << 20U;

/// The XML of a SICD image in a NITF file: the first data extension segment of that kind. Of the
/// rest of the file the lengths of its segments are read. Throws InputError with the file and the
/// field for lengths that are no numbers or lie beyond the end of the file, and where there is no
/// such segment.
[[nodiscard]] std::string SicdTextOfNitf(ByteSource* source);

/// The XML of a SICD image, in a NITF file or alone.
[[nodiscard]] std::string SicdText(ByteSource* source);

}  // namespace sarblock
