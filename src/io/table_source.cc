// SPDX-License-Identifier: Apache-2.0
#include "table_source.h"

#include "sarblock/core/error.h"

#include <utility>

namespace sarblock {

void TableSource::FailMissing(const std::string& file, const char* what) const {
  throw InputError(
      FilePlace{file, 0, ""},
      std::string("is missing, every ") + sarblock::NameOf(content_) + " has this " + what);
}

std::unique_ptr<TableReader> TableSource::Require(std::string_view table,
                                                  std::span<const TableColumn> columns) const {
  auto reader = Open(table, columns);
  if (!reader) FailMissing(NameOf(table), "table (or it as .csv.gz)");
  return reader;
}

}  // namespace sarblock
