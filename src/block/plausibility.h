// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/recorded_states.h"

namespace sarblock {

/// Contradictions within a block before the adjustment, one sentence each, at most one per kind
/// and pass. Compared are
///   - the velocities of a path and the differences of its positions;
///   - every second state and the others;
///   - the acceleration of a satellite and the attraction of its body;
///   - the coordinates of a local frame and those of map projections;
///   - the decimals of times, of ranges and (geocentric frames) of each column of known points,
///     and their standard deviations;
///   - the looks and turns of the path;
///   - the height of flight and the ranges (no range is shorter than the height above the ground:
///     the ellipsoid, or in a local frame the known points);
///   - the known points (control and check) of a pass and its looks: side, range, place along the
///     flight;
///   - a known point alone and the others of its passes.
/// Path errors as navigation may have, up to some per cent of the range, are not remarked on;
/// mistakes of units, frames, sides, files and names are. Linear in the looks.
[[nodiscard]] std::vector<std::string> ExaminePlausibility(const Block& block);

/// The evidence that the recorded states of a pass are in inertial axes (FindInertialMotion);
/// nothing in a local frame and about a body without a name.
[[nodiscard]] std::optional<InertialMotion> InertialMotionOf(const Block& block, const Pass& pass);

/// Whether the coordinates of a local frame are like those of a map projection: x from 100 km to
/// 61,000 km (zone numbers before), y from 100 to 10,000 km, both far from 0 beside their extent.
[[nodiscard]] bool HasMapCoordinates(const Block& block);

/// Passes that have the same recorded states, a sentence for each pair: one flight under two names,
/// whose errors are the same, or, if the times differ, the orbit of another date. Straight flights
/// are left out: they are lines of a plan. Passes whose indices `share` joins are known to be one
/// flight.
[[nodiscard]] std::vector<std::string> FindSameFlights(
    const Block& block, const std::function<bool(std::size_t, std::size_t)>& share);

/// Passes of one flight, two or more each, by rising index: pairs of them have half of their
/// recorded states or more in common, at the same times.
[[nodiscard]] std::vector<std::vector<std::size_t>> FindFlights(const Block& block);

/// Throws InputError naming a pass of a geocentric frame whose path runs nearer to the centre than
/// half the smaller axis of the ellipsoid: local coordinates, or another body.
void RequireAboveGround(const Block& block);

/// Throws InputError naming a pass of a geocentric frame whose states are in inertial axes
/// (FindInertialMotion) and whose looks cannot see their known points in these axes: the points are
/// off by more than a third of the turn of the cones by the body's rotation. A block simulated
/// about a body that does not turn agrees with its known points and is a good one.
void RequireBodyFixedStates(const Block& block);

/// Duplicate looks of a block: times and ranges equal within kEqual of their standard deviations,
/// as no two measurements are.
inline constexpr double kEqual = 1e-3;
struct Copies {
  std::vector<std::string> remarks;   ///< a sentence a copied pass, and one of points
  std::vector<std::uint32_t> passes;  ///< copies of an earlier pass
  std::vector<std::size_t> looks;     ///< of these passes, equal to those of the earlier ones
  std::vector<std::uint32_t> points;  ///< copies of an earlier point
  [[nodiscard]] bool any() const { return !remarks.empty(); }
};

/// Passes of which half of the looks or more equal those of an earlier one.
[[nodiscard]] Copies FindCopiedPasses(const Block& block);
/// The same, and points all whose looks are those of another one: n log n in the looks.
[[nodiscard]] Copies FindCopies(const Block& block);

/// Known points under several ids: a sentence where some have the same three coordinates to the
/// last digit. A survey that is counted twice makes what it holds 1.4 times too certain.
[[nodiscard]] std::vector<std::string> FindSameKnownPoints(const Block& block);

/// Rejects the looks that are copies, so that they count once.
void CountOnce(const Copies& copies, Block* block);

}  // namespace sarblock
