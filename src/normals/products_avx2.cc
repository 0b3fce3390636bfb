// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mfma; reached only where the processor has it (kernel_choice.cc).
#include "products_avx2.h"

#include "product_kernels.h"

namespace sarblock {

const ProductKernels& Avx2Kernels() { return kKernelsHere; }

}  // namespace sarblock
