// SPDX-License-Identifier: Apache-2.0
#include "kernels.h"

#include "kernels_inline.h"

namespace sarblock {

const ProductKernels& BaselineKernels() { return kKernelsHere; }

const ProductKernels& KernelsOfThisMachine() {
#ifdef SARBLOCK_AVX2
  static const bool has = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  if (has) return Avx2Kernels();
#endif
  return BaselineKernels();
}

}  // namespace sarblock
