// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock {

/// Version of this build, "0.1.0".
[[nodiscard]] const char* Version();

}  // namespace sarblock
