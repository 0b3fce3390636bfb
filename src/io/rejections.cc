// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "block_reader.h"
#include "core/text.h"
#include "tables/csv.h"
#include "tables/open.h"

namespace sarblock {

std::size_t ApplyRejections(const std::filesystem::path& folder,
                            const std::string& file,
                            Block* block) {
  constexpr std::array<TableColumn, 3> columns{{{"pass", ColumnNeed::kRequired},
                                                {"point", ColumnNeed::kRequired},
                                                {"rejected", ColumnNeed::kRequired}}};
  IdTable pass_ids;
  for (const Pass& pass : block->passes) pass_ids.Append(pass.id);
  CsvReader reader(FolderOf(folder) / file, columns);
  Looks& looks = block->looks;
  std::size_t rejected = 0;
  while (reader.Next()) {
    if (!reader.Flag(2)) continue;
    const std::uint32_t pass = FindPass(reader, 0, pass_ids);
    const std::uint32_t point = FindPoint(reader, 1, block->points.ids);
    const auto begin = looks.pass.begin() + static_cast<std::ptrdiff_t>(looks.offsets[point]);
    const auto end = looks.pass.begin() + static_cast<std::ptrdiff_t>(looks.offsets[point + 1]);
    const auto at = std::find(begin, end, pass);
    if (at == end) {
      reader.Fail(1,
                  "pass " + Quoted(reader.Text(0)) + " has no look of point " +
                      Quoted(reader.Text(1)) + " in this block");
    }
    std::uint8_t& flags = looks.flags[static_cast<std::size_t>(at - looks.pass.begin())];
    if ((flags & Looks::kRejected) == 0) ++rejected;
    flags = static_cast<std::uint8_t>(flags | Looks::kRejected);
  }
  block->points.ids.DropIndex();
  return rejected;
}

}  // namespace sarblock
