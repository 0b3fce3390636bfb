// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "product/sicd_errors.h"
#include "xml_reader.h"

namespace sarblock {

/// Reads SICD.ErrorStatistics; nothing where it does not stand. Throws InputError with file, line
/// and element for standard deviations below 0 and correlations beyond 1.
[[nodiscard]] std::optional<SicdErrorStatistics> ReadErrorStatistics(const XmlElement& root);

}  // namespace sarblock
