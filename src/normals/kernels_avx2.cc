// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mfma; reached only where the processor has it (kernels.cc).
#include "kernels.h"
#include "kernels_inline.h"

namespace sarblock {

const ProductKernels& Avx2Kernels() { return kKernelsHere; }

}  // namespace sarblock
