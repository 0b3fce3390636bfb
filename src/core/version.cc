// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/version.h"

namespace sarblock {

const char* Version() { return SARBLOCK_VERSION; }

}  // namespace sarblock
