// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "result_table_reader.h"

namespace sarblock {

/// summary.json: the summary, the frame and the passes. The others need it to have been read.
void ReadResultSummary(ResultReading* reading);

}  // namespace sarblock
