// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "facts.h"

namespace sarblock {

/// Adds the hypotheses of known positions that this block gives reason to try, with first values
/// of their sizes: those that the sightings suggest, and those that show in a solution alone.
void AddControlMistakes(const Facts& facts, Hypotheses* out);
/// Of single known points, and of pairs of them, whose rows may explain the block.
void AddKnownPointMistakes(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
