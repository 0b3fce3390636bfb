// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sarblock {

/// "A1, A2, A3 and 5 more", "all passes" where `names` are all of them and more than one.
[[nodiscard]] std::string ListNames(const std::vector<std::string>& names,
                                    std::size_t all = 0,
                                    std::size_t shown = 4);

}  // namespace sarblock
