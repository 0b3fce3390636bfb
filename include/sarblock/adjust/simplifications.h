// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/result.h"
#include "sarblock/block/block.h"

#include <vector>

namespace sarblock {

/// Bounds of what four simplifications of the model would do to the points of an adjusted block
/// (docs/theory/selection.md, eqs. 9 to 13), flight paths held. An error delta_i of the equations
/// of look i, in metres, moves no direction u of a point by more than
///
///     |u'dp| <= sigma_u sqrt( sum over looks |W_i delta_i|^2 ),      W_i the whitening
///
/// because dp = A^+ W delta and the rows of A^+ have the length of the standard deviations
/// (Cauchy and Schwarz); standard deviations of the whole adjustment are not smaller.
/// `limit_1` is the part of a standard deviation below which one is allowed. Points without
/// covariance are passed over; nothing where no point has one.
[[nodiscard]] std::vector<SimplificationBound> BoundSimplifications(const Block& block,
                                                                    const AdjustResult& result,
                                                                    double limit_1);

}  // namespace sarblock
