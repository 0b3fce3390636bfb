// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sarblock {

/// Something in the make of a block that its adjustment will suffer from.
struct Finding {
  std::string text;                ///< what, of which passes or points, and what would mend it
  std::vector<std::string> names;  ///< of the passes or points concerned
};

}  // namespace sarblock
