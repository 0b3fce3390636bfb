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
/// Of a joint prior Q with P = Q^-1, C the covariance of its corrections in the result (eq. (18a)):
///     r_i = 1 - (C P)_ii,   w_i = (P c)_i / sqrt(N_ii),   N = P - P C P,   v'Pv: c_i (P c)_i
struct PriorTest {
  /// Part of the redundancy of the block; NaN without a prior or without a standard deviation. Of a
  /// joint prior it may lie outside 0 to 1, the sum over the prior does not.
  double redundancy_1 = kNotGiven;
  /// NaN also where r, of a joint prior N_ii / P_ii, is kLeastRedundancy_1 or less, or nothing is
  /// measured.
  double w_1 = kNotGiven;
  double square_1 = kNotGiven;  ///< part of v'Pv; NaN where w is or nothing is measured
};
/// By parameter of the result.
[[nodiscard]] std::vector<PriorTest> TestsOfPriors(const AdjustResult& result);

/// What is said where a w is larger than chance allows in any of the priors (level 0.001 for all of
/// them together); empty where none is.
[[nodiscard]] std::string ContradictedPriors(const AdjustResult& result);

/// At the level of one observation (ReliabilityOf).
[[nodiscard]] PriorSummary SummarisePriors(const AdjustOptions& options,
                                           const AdjustResult& result);

/// By pass of the block in order, then shared groups; empty without redundancy numbers.
[[nodiscard]] std::vector<PassShare> SharesOf(const Block& block, const AdjustResult& result);

}  // namespace sarblock
