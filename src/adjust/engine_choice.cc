// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/engine_choice.h"

namespace sarblock {

Engine Resolve(Engine asked) { return asked == Engine::kAuto ? Engine::kReduced : asked; }

CovarianceMethod Resolve(CovarianceMethod asked) {
  return asked == CovarianceMethod::kAuto ? CovarianceMethod::kReduced : asked;
}

}  // namespace sarblock
