// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include "geojson.h"
#include "tables/table.h"

namespace sarblock::files {

/// What the writers of the single files of a result share.
struct ResultView {
  const Block& block;
  const IdTable& pass_ids;
  const AdjustOptions& options;
  const AdjustResult& result;
};

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

}  // namespace sarblock::files
