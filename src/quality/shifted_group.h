// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "consensus_search.h"

namespace sarblock {

/// Finds the pass with a group of wrong looks, where many looks were left out: a matcher that takes
/// one repeated pattern for the next puts a group of looks of one pass off by one common shift, and
/// at points of three looks each single look explains the contradiction as well as the others.
///
/// Hypothesis p: looks of pass p are right or off by one shift s in range and time, each point as
/// fits it better. The block is solved under each hypothesis with the looks of the group corrected
/// by s, s estimated with them; their likelihoods are compared with each other and with that of no
/// group (docs/theory/quality.md, eq. (19b)). A group is taken as a whole where
/// it is better than none and than that of any other pass by more than chance (1e-4) explains: its
/// looks are left out, what was left out before takes part again, and the search for blunders goes
/// on from there. Else everything stays as it was.
///
/// `lost`: the looks that the search, the loss or the consensus left out. Returns what is now left
/// out instead.
[[nodiscard]] std::optional<SnoopingReport> SearchShiftedGroup(
    const AdjustOptions& options,
    const std::vector<std::uint64_t>& lost,
    const Solution& solution,
    ProgressSink* progress);

/// The note of a finding of the group.
inline constexpr const char* kOffLikeOthers = "off like others of its pass";

/// The looks of a report that are left out.
[[nodiscard]] std::vector<std::uint64_t> LooksLeftOut(const SnoopingReport& report);

}  // namespace sarblock
