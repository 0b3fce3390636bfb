// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "facts.h"

namespace sarblock {

/// Adds the hypotheses of ids that this block gives reason to try: all of a pass shifted by a row,
void AddShiftedIds(const Facts& facts, Hypotheses* out);
/// and two suspects exchanged in a pass.
void AddExchangedPoints(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
