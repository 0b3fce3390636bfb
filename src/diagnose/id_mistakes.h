// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "facts.h"

namespace sarblock {

/// Adds the hypotheses of exchanged and shifted ids that this block gives reason to try, with first
/// values of their sizes: those that the sightings suggest, and those that show in a solution
/// alone.
void AddIdMistakes(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
