// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "table_reader.h"

namespace sarblock {

/// Adds the one warning about columns nobody knows.
void WarnOfUnknownColumns(const TableReader& reader, std::vector<std::string>* warnings);

/// A number above 0, or NaN for an empty cell.
[[nodiscard]] double PositiveNumber(const TableReader& reader, std::size_t column);

}  // namespace sarblock
