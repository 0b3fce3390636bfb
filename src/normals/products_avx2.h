// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "products.h"

namespace sarblock {

/// For x86-64 processors with vectors of four doubles and fused products.
[[nodiscard]] const ProductKernels& Avx2Kernels();

}  // namespace sarblock
