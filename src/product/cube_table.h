// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "byte_source.h"
#include "pvl_reader.h"

namespace sarblock {

/// A table of a cube whose fields are doubles, row by row.
struct CubeTable {
  const PvlObject* label = nullptr;
  std::vector<std::vector<double>> rows;
};

/// The object `Table` of this name, or null.
[[nodiscard]] const PvlObject* FindCubeTable(const PvlObject& root, std::string_view name);

/// Reads a table that holds exactly `fields`, in this order, 64 MiB at most. `remedy` ends the
/// message where it does not.
[[nodiscard]] CubeTable ReadCubeTable(ByteSource* source,
                                      const PvlObject& label,
                                      const std::vector<std::string_view>& fields,
                                      const char* remedy);

}  // namespace sarblock
