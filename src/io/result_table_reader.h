// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"
#include "sarblock/io/result_file.h"

#include "tables/table.h"

namespace sarblock {

/// What the readers of the single files of a result share.
struct ResultReading {
  const TableSource& source;
  const ReadResultOptions& options;
  ResultFile result;
  IdTable pass_ids;
  std::size_t points, looks;  ///< that the summary counts
};

void ReadResultPoints(ResultReading* reading);
void ReadResultParameters(ResultReading* reading);
void ReadResultLooks(ResultReading* reading);
void ReadResultControl(ResultReading* reading);
void ReadResultPairs(ResultReading* reading);
void ReadResultStrips(ResultReading* reading);
/// selection.csv and simplifications.csv.
void ReadResultSelection(ResultReading* reading);
void ReadResultPaths(ResultReading* reading);

}  // namespace sarblock
