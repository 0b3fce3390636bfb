// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace sarblock {

/// One key of the `[adjust]` table (docs/adjust_options.md is made of these).
struct AdjustOption {
  std::string_view key;       ///< dotted, below `adjust`
  std::string_view type;      ///< "text", "number", "integer", "flag", "list", ...
  std::string_view allowed;   ///< names or bounds
  std::string_view standard;  ///< what holds where the key is left out
  std::string_view help;      ///< one sentence
};

}  // namespace sarblock
