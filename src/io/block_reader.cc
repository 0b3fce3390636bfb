// SPDX-License-Identifier: Apache-2.0
#include "block_reader.h"

#include <cmath>
#include <utility>

#include "block/plausibility.h"
#include "block/read_recorded.h"
#include "core/text.h"
#include "tables/open.h"
#include "tables/toml.h"

namespace sarblock {

BlockFile ReadBlockFrom(const TableSource& source, const ReadOptions& options) {
  BlockReading reading{source, options, {}, {}, {}, {}, {}};
  ReadBlockToml(&reading);
  ReadTrajectories(&reading);
  ReadPoints(&reading);
  ReadLooks(&reading);
  SetStripSpans(reading.strip_spans_s, &reading.result.block);
  if (options.contradictions == Contradictions::kRefuse) RequireAboveGround(reading.result.block);
  for (std::string& warning : ReadRecordedFlights(&reading.result.block)) {
    reading.result.warnings.push_back(std::move(warning));
  }
  for (std::string& remark : ExaminePlausibility(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  const Copies copies = FindCopiedPasses(reading.result.block);
  CountOnce(copies, &reading.result.block);
  for (const std::string& remark : copies.remarks) reading.result.warnings.push_back(remark);
  reading.result.block.points.ids.DropIndex();
  return std::move(reading.result);
}

BlockFile ReadBlock(const std::filesystem::path& folder, const ReadOptions& options) {
  return ReadBlockFrom(*TablesAt(folder, FolderContent::kBlock), options);
}

BlockFile ReadBlockTexts(const BlockTexts& texts, const ReadOptions& options) {
  return ReadBlockFrom(*TablesOfTexts({{"block.toml", texts.block_toml},
                                       {"trajectories.csv", texts.trajectories_csv},
                                       {"observations.csv", texts.observations_csv},
                                       {"points.csv", texts.points_csv}},
                                      FolderContent::kBlock),
                       options);
}

std::uint32_t FindPass(const TableReader& reader,
                       std::size_t column,
                       const IdTable& pass_ids,
                       const char* holder) {
  return reader.Lookup(column, [&] {
    const std::string_view id = reader.Id(column);
    const std::uint32_t pass = pass_ids.Find(id);
    if (pass == IdTable::kNone) {
      reader.Fail(
          column,
          std::string(holder) + " has no pass " + Quoted(id) + DidYouMean(pass_ids.Nearest(id)));
    }
    return pass;
  });
}

std::uint32_t FindPoint(const TableReader& reader,
                        std::size_t column,
                        const IdTable& ids,
                        const char* holder) {
  return reader.Lookup(column, [&] {
    const std::string_view id = reader.Id(column);
    const std::uint32_t point = ids.Find(id);
    if (point == IdTable::kNone) {
      reader.Fail(
          column,
          std::string(holder) + " has no point " + Quoted(id) + DidYouMean(ids.Nearest(id)));
    }
    return point;
  });
}

double LengthNumber(const TableReader& reader, std::size_t column) {
  const double value_m = reader.Number(column);
  if (std::abs(value_m) > kLargestLength_m) {
    reader.Fail(column,
                NumberText(value_m) + " m is not allowed, at most " + NumberText(kLargestLength_m) +
                    " m is");
  }
  return value_m;
}

}  // namespace sarblock
