// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geojson.h"
#include "result_view.h"
#include "tables/table.h"

namespace sarblock {

/// "score", "wald" or nothing.
[[nodiscard]] const char* NameOf(SelectionTest test);

void WritePointTable(TableSink* sink, const ResultView& view);
void WriteParameterTable(TableSink* sink, const ResultView& view);
void WriteParameterCovariance(TableSink* sink, const ResultView& view);
void WriteSelectionTable(TableSink* sink, const ResultView& view);
void WriteSimplificationTable(TableSink* sink, const ResultView& view);
void WriteResidualTable(TableSink* sink, const ResultView& view);
void WriteControlTable(TableSink* sink, const ResultView& view);
void WritePairTable(TableSink* sink, const ResultView& view);
void WriteStripTable(TableSink* sink, const ResultView& view);

}  // namespace sarblock
