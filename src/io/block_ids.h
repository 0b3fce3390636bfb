// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"

namespace sarblock {

/// Ids that tables hold the index of, where they stand once; null where they do not.
struct BlockIds {
  const IdTable* passes = nullptr;
  const IdTable* points = nullptr;
};

}  // namespace sarblock
