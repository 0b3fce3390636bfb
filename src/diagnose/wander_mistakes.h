// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "facts.h"

namespace sarblock {

/// Errors that are correlated in time: residuals of a pass that wander along its strip, of its
/// ranges or of its times, and of all such passes together. docs/theory/diagnosis.md, eq. (9).
void AddWanderMistakes(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
