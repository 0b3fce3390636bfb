// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <utility>

#include "block_reader.h"
#include "number.h"

namespace sarblock {
namespace {

void ReadTruePoints(const std::filesystem::path& file, const Block& block, Truth* truth) {
  constexpr std::array<CsvColumn, 4> columns{{{"point", CsvNeed::kRequired},
                                              {"x_m", CsvNeed::kRequired},
                                              {"y_m", CsvNeed::kRequired},
                                              {"z_m", CsvNeed::kRequired}}};
  CsvReader reader(file, columns);
  truth->points_m.assign(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  while (reader.Next()) {
    Eigen::Vector3d& position_m = truth->points_m[FindPoint(reader, 0, block.points.ids)];
    if (!std::isnan(position_m.x())) {
      reader.Fail(0, Quoted(reader.Text(0)) + " stands twice, one row a point is allowed");
    }
    position_m = {reader.RequiredNumber(1), reader.RequiredNumber(2), reader.RequiredNumber(3)};
  }
}

void ReadTruePaths(const std::filesystem::path& file, const Block& block, Truth* truth) {
  IdTable pass_ids;
  for (const Pass& pass : block.passes) pass_ids.Append(pass.id);
  CsvReader reader(file, kPathColumns);
  PathTable table = ReadPaths(&reader, pass_ids);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    if (table.states[i].size() < 2) {
      throw InputError(FilePlace{reader.file(), table.lines[i], "pass"},
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
  if (const auto file = FindTable(folder, "truth")) ReadTruePoints(*file, block, &truth);
  if (const auto file = FindTable(folder, "truth_passes")) ReadTruePaths(*file, block, &truth);
  return truth;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> ReadPairs(const std::filesystem::path& folder,
                                                               const std::string& file,
                                                               const Block& block) {
  constexpr std::array<CsvColumn, 2> columns{
      {{"point_a", CsvNeed::kRequired}, {"point_b", CsvNeed::kRequired}}};
  CsvReader reader(folder / file, columns);
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
