// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include "facts.h"

namespace sarblock {

/// Constants of time, range and squint, of one pass or of all, that Rao's score test (selection)
/// finds at the fit as it is: what they would take off v'Pv in one linearisation, the most first.
/// Nothing where the fit is none.
[[nodiscard]] Hypotheses ScoredMistakes(const Facts& facts, ProgressSink* progress);

}  // namespace sarblock
