// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sarblock {

/// Memory and work of a block Cholesky factor and its selected inverse, in doubles and operations
/// (a product and its sum). Known from the pattern alone, for fronts that one thread works on;
/// further threads keep more fronts waiting, each at most a branch of the elimination tree.
struct FactorNeeds {
  std::size_t factor = 0;          ///< L
  std::size_t waiting = 0;         ///< update matrices while it is formed, the most at once
  std::size_t inverse_fronts = 0;  ///< fronts of the inverse, the most at once
  double operations = 0.0;         ///< of the factor, half of sum h^2 over its columns
  bool dissected = false;          ///< the order is METIS's, else AMD's
};

}  // namespace sarblock
