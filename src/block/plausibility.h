// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <string>
#include <vector>

namespace sarblock {

/// What of a block contradicts itself before anything is adjusted, a sentence each, at most one of
/// a kind and pass. Held against each other are
///   - the velocities of a path and the differences of its positions;
///   - the height of flight and the ranges (no range is shorter than the height above the ground:
///     the ellipsoid, or in a local frame the known points);
///   - the known points (control and check) of a pass and its looks: side, range, place along the
///     flight;
///   - a known point alone and the others of its passes.
/// Errors of paths that navigation may have, up to some per cent of the range, draw no remark:
/// mistakes of units, frames, sides, files and names do. Linear in the looks.
[[nodiscard]] std::vector<std::string> ExaminePlausibility(const Block& block);

/// Throws InputError naming a pass of a geocentric frame whose path runs nearer to the centre than
/// half the smaller axis of the ellipsoid: local coordinates, or another body.
void RequireAboveGround(const Block& block);

}  // namespace sarblock
