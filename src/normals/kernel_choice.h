// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "products.h"

namespace sarblock {

/// For every processor.
[[nodiscard]] const ProductKernels& BaselineKernels();
/// The fastest that this processor runs.
[[nodiscard]] const ProductKernels& KernelsOfThisMachine();

}  // namespace sarblock
