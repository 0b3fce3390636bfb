// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "study/study_table.h"
#include "study/tradeoff.h"

namespace sarblock {

/// Columns of tradeoff.csv (docs/studies.md).
[[nodiscard]] std::vector<StudyColumn> TradeoffColumns();

/// A row as cells, without `pareto`: that needs the other rows.
[[nodiscard]] StudyRow CellsOf(const TradeoffRow& row);

/// The rows of a table with these columns, every number to the bit. Throws std::logic_error for a
/// stage or clock that is none.
[[nodiscard]] std::vector<TradeoffRow> TradeoffRowsOf(const StudyTable& table);

/// The table of all rows, with `pareto` as the rows have it.
[[nodiscard]] StudyTable TradeoffTable(const std::vector<TradeoffRow>& rows);

}  // namespace sarblock
