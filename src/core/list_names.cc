// SPDX-License-Identifier: Apache-2.0
#include "list_names.h"

#include <algorithm>

namespace sarblock {

std::string ListNames(const std::vector<std::string>& names, std::size_t all, std::size_t shown) {
  if (names.size() > 1 && names.size() == all) return "all passes";
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), shown); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > shown) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

}  // namespace sarblock
