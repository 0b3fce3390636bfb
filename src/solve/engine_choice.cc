// SPDX-License-Identifier: Apache-2.0
#include "engine_choice.h"

namespace sarblock {

Engine Resolve(Engine asked) { return asked == Engine::kAuto ? Engine::kReduced : asked; }

CovarianceMethod Resolve(CovarianceMethod asked) {
  return asked == CovarianceMethod::kAuto ? CovarianceMethod::kReduced : asked;
}

CeresSolver Resolve(CeresSolver asked, int corrections) {
  /// Above, a sparse reduced matrix is faster.
  constexpr int kMostDense = 600;
  if (asked != CeresSolver::kAuto) return asked;
  return corrections <= kMostDense ? CeresSolver::kDenseSchur : CeresSolver::kSparseSchur;
}

}  // namespace sarblock
