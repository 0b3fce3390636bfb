// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <utility>

#include "block_reader.h"
#include "core/text.h"
#include "tables/csv.h"
#include "tables/open.h"

namespace sarblock {
namespace {

void ReadTruePoints(TableReader* reader, const Block& block, Truth* truth) {
  truth->points_m.assign(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  while (reader->Next()) {
    Eigen::Vector3d& position_m = truth->points_m[FindPoint(*reader, 0, block.points.ids)];
    if (!std::isnan(position_m.x())) {
      reader->Fail(0, Quoted(reader->Text(0)) + " stands twice, one row a point is allowed");
    }
    position_m = {reader->RequiredNumber(1), reader->RequiredNumber(2), reader->RequiredNumber(3)};
  }
}

void ReadTruePaths(TableReader* reader, const Block& block, Truth* truth) {
  IdTable pass_ids;
  for (const Pass& pass : block.passes) pass_ids.Append(pass.id);
  PathTable table = ReadPaths(reader, pass_ids);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    if (table.states[i].size() < 2) {
      throw InputError(reader->PlaceAt(table.lines[i], 0),
                       "pass " + Quoted(block.passes[i].id) + " has " +
                           std::to_string(table.states[i].size()) +
                           " states, two or more are needed");
    }
    truth->paths.emplace_back(std::move(table.states[i]));
  }
}

}  // namespace

Truth ReadTruth(const std::filesystem::path& folder, const Block& block) {
  Truth truth;
  const auto source = TablesAt(folder, FolderContent::kBlock);
  if (const auto reader = source->Open("truth", kTruthColumns)) {
    ReadTruePoints(reader.get(), block, &truth);
  }
  if (const auto reader = source->Open("truth_passes", kPathColumns)) {
    ReadTruePaths(reader.get(), block, &truth);
  }
  return truth;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> ReadPairs(const std::filesystem::path& folder,
                                                               const std::string& file,
                                                               const Block& block) {
  constexpr std::array<TableColumn, 2> columns{
      {{"point_a", ColumnNeed::kRequired}, {"point_b", ColumnNeed::kRequired}}};
  CsvReader reader(FolderOf(folder) / file, columns);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  while (reader.Next()) {
    pairs.emplace_back(FindPoint(reader, 0, block.points.ids),
                       FindPoint(reader, 1, block.points.ids));
    if (pairs.back().first == pairs.back().second) {
      reader.Fail(1, Quoted(reader.Text(1)) + " is point_a too, two different points are needed");
    }
  }
  return pairs;
}

}  // namespace sarblock
