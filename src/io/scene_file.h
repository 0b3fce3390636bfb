// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sarblock {

/// Every key that a scene may hold, dotted as for `--set` (`flight.0.height_m`), but
/// for those of its [adjust] table. Asked of the readers, so that it cannot differ from what they
/// take.
[[nodiscard]] std::vector<std::string> SceneKeys();

}  // namespace sarblock
