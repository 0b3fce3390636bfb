// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "study/tradeoff.h"

namespace sarblock {

/// The rows as a Markdown page: a recommendation and a table for every size, rows of the Pareto set
/// in bold. Sizes ascending, stages in their order, rows as given.
[[nodiscard]] std::string TradeoffPage(const std::vector<TradeoffRow>& rows,
                                       const TradeoffGoal& goal);

/// Sizes of the rows, ascending, each once.
[[nodiscard]] std::vector<std::size_t> SizesOf(const std::vector<TradeoffRow>& rows);

}  // namespace sarblock
