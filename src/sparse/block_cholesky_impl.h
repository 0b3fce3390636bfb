// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/sparse/block_cholesky.h"

#include <cstddef>
#include <memory>

#include "symbolic.h"

namespace sarblock {

struct BlockCholesky::Impl {
  std::shared_ptr<const BlockPattern> pattern;
  sparse::Symbolic symbolic;
  std::unique_ptr<double[]> factor;  ///< the fronts' panels, column-major, lower part valid
  bool factored = false;

  [[nodiscard]] const double* Panel(const sparse::Front& front) const {
    return factor.get() + front.panel;
  }
  /// CHECKs that the last Factorize succeeded.
  void RequireFactor() const;
};

}  // namespace sarblock
