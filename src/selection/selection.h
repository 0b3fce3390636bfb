// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <functional>

#include "model/problem.h"

namespace sarblock {

/// Called with the problem and its state at the last solution, before they are destroyed.
using AtSelection =
    std::function<void(const AdjustmentProblem&, const BlockState&, SelectionReport*)>;

/// Chooses the corrections that the observations of a block ask for (model.md, section 10;
/// docs/theory/selection.md). Starts from the measured values without any correction and adds
/// terms and degrees, each with
///
///     T = g' M^-1 g           Rao's score statistic: the decrease of v'Pv,
///                             M = S_kk - S_k0 S_00^-1 S_0k, g = b_k - S_k0 S_00^-1 b_0
///     F = (T/k) / (v'Pv/f)    against the solution with it
///     delta BIC = f ln(v'Pv with / v'Pv without) + penalty
///
/// keeping one that is determinable, significant and lowers the criterion; drops by Wald's test
/// what later ones made superfluous. One linearisation has all candidates, so that a round costs
/// one pass over the points; the chosen model is then solved and the round repeated until nothing
/// changes.
///
/// Candidates are `options.groups` with their priors, else the standard ones of
/// `options.selection` without priors. A robust adjustment chooses under Huber's loss. Throws what
/// Adjust() throws, and InputError for more than kMaxCandidateColumns candidate parameters.
inline constexpr int kMaxCandidateColumns = 4000;
[[nodiscard]] SelectionReport SelectCorrections(const Block& block,
                                                const AdjustOptions& options,
                                                const AtSelection& at_selection = nullptr,
                                                ProgressSink* progress = nullptr);

}  // namespace sarblock
