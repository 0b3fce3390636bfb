// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sarblock {

/// A cell of text as CSV, quoted where it has to be, so that CsvReader reads it back unchanged;
/// appended.
void AppendCsvText(std::string_view text, std::string* row);

}  // namespace sarblock
