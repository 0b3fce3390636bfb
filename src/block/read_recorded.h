// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/error.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sarblock {

/// Makes the path of every pass from its recorded states (its present ones, where none are kept) in
/// the way that it asks for, and measures what the recording does to its points. kAuto takes the
/// first of `states`, `orbit`, `positions` and `smooth` whose effect stays below a tenth of the
/// standard deviation of azimuth, or the one of least effect. Paths read through their states stay
/// as they are. The looks and the spans of the strips must be set. Returns warnings: recordings
/// that matter, with the remedy, and smoothed paths that their states do not fit as stated. Throws
/// InputError for a pass whose states give no path, at its place in `places` (by pass, as a reader
/// of files knows them) or else by its id.
[[nodiscard]] std::vector<std::string> ReadRecordedFlights(Block* block,
                                                           std::span<const FilePlace> places = {});

/// The same for these passes alone, without warnings.
void ReadRecordedFlights(const std::vector<std::uint32_t>& passes, Block* block);

/// Times at which states give the path of a pass again: those recorded, and those of the path.
[[nodiscard]] std::vector<double> PathTimes_s(const Pass& pass);

}  // namespace sarblock
