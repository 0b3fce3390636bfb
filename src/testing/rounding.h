// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include "model/problem.h"

namespace sarblock {

/// Warns of looks that are weighted finer than double precision carries coordinates: one rounding
/// of the largest coordinate behind an equation (point, antenna, range; with a time bias the way
/// flown in one rounding of the time) as a part of its standard deviation. What is above a
/// ten-thousandth may move the point by a thousandth of its sigma. Control may be as tight as it
/// likes: it holds its point to the given coordinates themselves.
void WarnOfRounding(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result);

}  // namespace sarblock
