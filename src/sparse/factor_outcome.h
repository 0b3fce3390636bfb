// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock {

/// What a Cholesky factorisation met.
struct FactorOutcome {
  bool positive_definite = false;
  int failed_row = -1;                ///< row of S (original order) whose pivot was not positive
  double smallest_pivot_ratio = 0.0;  ///< least pivot / diagonal element, 1 for a diagonal S
  int smallest_pivot_row = -1;
};

}  // namespace sarblock
