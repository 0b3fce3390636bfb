// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sarblock::cli {

/// Columns of a terminal that text for people is fitted to.
inline constexpr std::size_t kColumns = 80;

/// Breaks lines longer than kColumns (of UTF-8 characters) at spaces; what follows is indented by
/// four more than the line. Rows of tables (cells parted by three spaces or more) stay as they are,
/// and so does a word that is longer than a line.
[[nodiscard]] std::string FitColumns(std::string_view text);

/// The same for the text of --help: what follows a broken line begins below its description.
[[nodiscard]] std::string FitHelp(std::string_view text);

}  // namespace sarblock::cli
