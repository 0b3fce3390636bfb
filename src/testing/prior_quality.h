// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <string>
#include <vector>

namespace sarblock {

/// What a prior is to its correction (docs/theory/quality.md, eq. (18)): c the correction, which
/// the prior expects to be zero with the standard deviation sigma0, sigma that of the result:
///     r = 1 - sigma^2 / sigma0^2,   w = c / (sigma0 sqrt(r))
struct PriorTest {
  double redundancy_1 = kNotGiven;  ///< NaN without a prior or without a standard deviation
  double w_1 =
      kNotGiven;  ///< NaN also where r is kLeastRedundancy_1 or less, or nothing is measured
};
[[nodiscard]] PriorTest TestOfPrior(const AdjustResult& result, const ParameterResult& parameter);

/// Adds a warning where a w is larger than chance allows in any of the priors (level 0.001 for all
/// of them together).
void WarnOfContradictedPriors(AdjustResult* result);

/// The tests of priors in short, at the level of one observation (ReliabilityOf).
struct PriorSummary {
  std::size_t priors = 0;  ///< with a redundancy number
  std::size_t tested = 0;  ///< with a standardised residual
  std::size_t above = 0;   ///< beyond the critical value of |w| (|tau| where that is the test)
  double expected_above_1 = 0.0;    ///< by chance
  std::size_t worst = 0;            ///< index of the parameter with the largest |w|
  double worst_w_1 = kNotGiven;     ///< NaN where none is tested
  double redundancy_1 = kNotGiven;  ///< of all priors together
};
[[nodiscard]] PriorSummary SummarisePriors(const AdjustOptions& options,
                                           const AdjustResult& result);

/// What a pass (or a group of corrections that passes share) has of v'Pv and of the redundancy of
/// the block. The shares of all, and of the control points, add to both but for observations
/// without redundancy.
struct PassShare {
  std::string owner;                              ///< id of the pass, or name of the group
  std::size_t looks = 0;                          ///< with redundancy numbers
  double square_sum_1 = 0.0, redundancy_1 = 0.0;  ///< of its looks
  double prior_square_sum_1 = 0.0, prior_redundancy_1 = 0.0;  ///< of its priors
  /// v'Pv over redundancy of both together; NaN where there is no redundancy.
  [[nodiscard]] double variance_factor() const;
};
/// By pass of the block in order, then shared groups; empty without redundancy numbers.
[[nodiscard]] std::vector<PassShare> SharesOf(const Block& block, const AdjustResult& result);

}  // namespace sarblock
