// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "facts.h"

namespace sarblock {

/// Adds the hypotheses that the ids of a pass are shifted by a row or by a time.
void AddShiftedIds(const Facts& facts, Hypotheses* out);
/// Adds the hypotheses that two suspects are exchanged in a pass, where both agree better then.
void AddExchangedPoints(const Facts& facts, Hypotheses* out);

}  // namespace sarblock
