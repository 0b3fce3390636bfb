// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// The adjustment of a block (model.md, sections 5 to 7): start values, Levenberg-Marquardt,
/// acceptance, covariance, residuals, check points, global test.
///
/// Weights depend (weakly) on the unknowns where azimuth is given in metres: they are formed at the
/// start, where the solution has come near, and with every finishing Newton step.
/// Under a robust loss the looks whose whitened length exceeds the 99.9 percent point of chi-square
/// with 2 degrees of freedom are dropped after the robust solution; the result is that of least
/// squares with the looks kept.
/// Accepted means: every look has a value at the solution, the reduced matrix is regular, and the
/// Newton step that is left is below kRemainingStepAccepted_1 (under a loss also that of the robust
/// solution below kRemainingRobustStepAccepted_1).
///
/// The result lists points as the block does. The sums over points may be taken in another order,
/// that of the passes that see them (docs/performance.md), the same for the same block.
///
/// `pairs` is used with options.pairs == kList. Throws UndeterminedError where the block as a whole
/// or its corrections are not determined, InputError for options that do not fit the block,
/// Interrupted. A point that is not determined is reported with its reason and left out.
[[nodiscard]] AdjustResult Adjust(const Block& block,
                                  const AdjustOptions& options,
                                  const PointPairs& pairs = {},
                                  ProgressSink* progress = nullptr);

/// The same in less memory for a block of many passes whose points stand in no order of them: they
/// are taken in that order, and with a block that may be changed this needs no copy of it. On
/// return, also by an exception but that of memory which ran out, the block is as it was.
[[nodiscard]] AdjustResult Adjust(Block* block,
                                  const AdjustOptions& options,
                                  const PointPairs& pairs = {},
                                  ProgressSink* progress = nullptr);

}  // namespace sarblock
