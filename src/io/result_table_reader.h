// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"
#include "sarblock/io/result_file.h"

#include "table_source.h"

namespace sarblock {

/// What the readers of the single files of a result share.
struct ResultReading {
  const TableSource& source;
  const ReadResultOptions& options;
  ResultFile result;
  IdTable pass_ids;
};

void ReadResultPoints(ResultReading* reading);
void ReadResultParameters(ResultReading* reading);
void ReadResultLooks(ResultReading* reading);
void ReadResultControl(ResultReading* reading);
void ReadResultPairs(ResultReading* reading);
void ReadResultPaths(ResultReading* reading);

}  // namespace sarblock
