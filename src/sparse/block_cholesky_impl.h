// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>

#include "block_cholesky.h"
#include "symbolic.h"
#include "workspace.h"

namespace sarblock {

struct BlockCholesky::Impl {
  std::shared_ptr<const BlockPattern> pattern;
  sparse::Symbolic symbolic;
  std::unique_ptr<sparse::FrontMemory> factor_memory;
  sparse::FrontMemory::Place factor;  ///< the fronts' panels, column-major, lower part valid
  bool factored = false;
  std::mutex least_mutex;
  std::optional<EigenPair> least;  ///< of the present factor, once asked for

  [[nodiscard]] const double* Panel(const sparse::Front& front) const {
    return factor.get() + front.panel;
  }
  /// CHECKs that the last Factorize succeeded.
  void RequireFactor() const;
};

}  // namespace sarblock
