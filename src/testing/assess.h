// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// Fills `assessment` of a result that is complete but for it: the figures of its tests and the
/// verdict. Reasons that stand there already (`Refuse`) make it `not accepted`; so does, in an
/// adjustment whose standard deviations are not scaled by it, a variance factor above 10. A test
/// that fails makes it `converged, tests failed`: the global test and the check points at
/// `test_level`; the tests of observations and of priors where a block without mistakes would fail
/// once in a thousand (docs/theory/quality.md, section "The verdict").
void Assess(const Block& block, const AdjustOptions& options, AdjustResult* result);

}  // namespace sarblock
