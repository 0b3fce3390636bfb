// SPDX-License-Identifier: Apache-2.0
#include "cube_table.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/ranges.h>

namespace sarblock {

const PvlObject* FindCubeTable(const PvlObject& root, std::string_view name) {
  for (const PvlObject& child : root.children()) {
    if (child.name() == "Table" && child.Text("Name") == name) return &child;
  }
  return nullptr;
}

CubeTable ReadCubeTable(ByteSource* source,
                        const PvlObject& label,
                        const std::vector<std::string_view>& fields,
                        const char* remedy) {
  constexpr std::uint64_t kLargest = 64U << 20U;
  std::vector<std::string> names;
  for (const PvlObject& field : label.children()) {
    if (field.name() != "Field") continue;
    if (field.Text("Type") != "Double" || field.Count("Size", 1) != 1) {
      field.Fail("Type", "is not allowed here, a single Double is");
    }
    names.push_back(field.Text("Name"));
  }
  if (!std::equal(names.begin(), names.end(), fields.begin(), fields.end())) {
    label.Fail("Field",
               fmt::format("{} has the fields {}; {} are needed: {}",
                           label.Text("Name"),
                           fmt::join(names, ", "),
                           fmt::join(fields, ", "),
                           remedy));
  }
  const std::string order = label.FindKey("ByteOrder") != nullptr ? label.Text("ByteOrder") : "Lsb";
  if (order != "Lsb" && order != "Msb") label.Fail("ByteOrder", "Lsb or Msb is allowed");
  const std::uint64_t records = label.Count("Records", 1);
  const std::uint64_t row_bytes = sizeof(double) * fields.size();
  const std::uint64_t bytes = label.Count("Bytes", 0);
  if (bytes > kLargest || records > kLargest || bytes != records * row_bytes) {
    label.Fail(
        "Bytes",
        fmt::format(
            "{} do not hold {} records of {} bytes, 64 MiB at most", bytes, records, row_bytes));
  }
  // StartByte counts from 1.
  std::string data = source->Read(label.Count("StartByte", 1) - 1, bytes, "table");
  CubeTable table{&label, {}};
  for (std::uint64_t at = 0; at < bytes; at += sizeof(double)) {
    if (at % row_bytes == 0) table.rows.emplace_back();
    char* const number = data.data() + at;
    if (order == "Msb") std::reverse(number, number + sizeof(double));
    const auto value = LittleEndianDouble(number);
    if (!std::isfinite(value)) {
      label.Fail("Records",
                 fmt::format("record {} holds a number that is not finite", table.rows.size()));
    }
    table.rows.back().push_back(value);
  }
  return table;
}

}  // namespace sarblock
