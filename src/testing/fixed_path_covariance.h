// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <vector>

namespace sarblock {

/// Covariance that every point would have if the corrections were known exactly: what the noise of
/// its own looks (and its control) leaves, R^-1 R^-T of docs/theory/covariance.md, eq. (22), at the
/// solution of `result`. What the point's covariance holds beyond it comes from the flight paths.
/// East, north, up; NaN where a point is not solved. Not scaled by the posterior factor.
///
/// Empty where that split has no meaning or no use: without corrections, without a covariance of
/// the whole adjustment and with estimated variance components (the weights of `block` are not
/// those of the result). It has none either with an inner datum, which takes out motions that
/// points and paths share. `groups` are the correction groups that the result was made with.
[[nodiscard]] std::vector<SymmetricEnu> FixedPathCovariances(
    const Block& block, const std::vector<CorrectionGroup>& groups, const AdjustResult& result);

}  // namespace sarblock
