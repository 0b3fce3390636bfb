// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace sarblock {

/// A file of src/report/assets, or the chart library, as it stood when the program was built
/// (cmake/embed_files.cmake writes the definition). std::out_of_range for another name.
[[nodiscard]] std::string_view AssetText(std::string_view name);

}  // namespace sarblock
