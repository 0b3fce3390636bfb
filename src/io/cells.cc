// SPDX-License-Identifier: Apache-2.0
#include "cells.h"

#include "sarblock/core/error.h"

#include <cmath>

#include "core/text.h"

namespace sarblock {

void WarnOfUnknownColumns(const TableReader& reader, std::vector<std::string>* warnings) {
  if (reader.unknown_columns().empty()) return;
  std::string names;
  for (const std::string& name : reader.unknown_columns()) {
    names += (names.empty() ? "" : ", ") + Quoted(name);
  }
  warnings->push_back(reader.file() + ": columns not known and ignored: " + names);
}

double PositiveNumber(const TableReader& reader, std::size_t column) {
  const double value = reader.Number(column);
  if (std::isnan(value)) return value;
  if (const char* problem = ProblemOfPositive(value)) {
    reader.Fail(column, NumberText(value) + problem);
  }
  return value;
}

}  // namespace sarblock
