// SPDX-License-Identifier: Apache-2.0
#include "plants_edit.h"

#include <utility>

#include "block/read_recorded.h"

namespace sarblock::test {
namespace {

/// Looks in the order of a list of points and of old looks with a new pass.
struct Row {
  std::uint32_t point = 0, pass = 0;
  std::size_t look = 0;
};

void Rebuild(const std::vector<Row>& rows, Block* block) {
  const Looks from = block->looks;
  Looks to;
  std::vector<std::uint32_t> point_of_look;
  const auto copy = [](const auto& source, std::size_t i, auto* target) {
    if (!source.empty()) target->push_back(source[i]);
  };
  for (const Row& row : rows) {
    point_of_look.push_back(row.point);
    to.pass.push_back(row.pass);
    to.flags.push_back(from.flags[row.look]);
    to.time_s.push_back(from.time_s[row.look]);
    to.range_m.push_back(from.range_m[row.look]);
    copy(from.cone, row.look, &to.cone);
    copy(from.range_sigma_m, row.look, &to.range_sigma_m);
    copy(from.azimuth_sigma, row.look, &to.azimuth_sigma);
  }
  static_cast<void>(SortLooksByPoint(point_of_look, block->points.size(), &to));
  block->looks = std::move(to);
}

std::vector<Row> RowsOf(const Block& block) {
  std::vector<Row> rows;
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      rows.push_back({point, block.looks.pass[i], i});
    }
  }
  return rows;
}

}  // namespace

void ReplaceStates(std::vector<StateVector> states, std::uint32_t pass, Block* block) {
  Pass& edited = block->passes[pass];
  edited.path = FlightPath(states);
  if (edited.recorded.asked.through == PathThrough::kStates) {
    edited.recorded.states.clear();
    return;
  }
  edited.recorded.states = std::move(states);
  static_cast<void>(ReadRecordedFlights(block));
}

void AppendPassCopy(std::uint32_t pass, Block* block) {
  std::vector<Row> rows = RowsOf(*block);
  const auto copy = static_cast<std::uint32_t>(block->passes.size());
  block->passes.push_back(block->passes[pass]);
  block->passes.back().id = "COPY";
  const std::size_t count = rows.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (rows[k].pass == pass) rows.push_back({rows[k].point, copy, rows[k].look});
  }
  Rebuild(rows, block);
}

void AppendPointCopy(std::uint32_t point, Block* block) {
  std::vector<Row> rows = RowsOf(*block);
  const std::uint32_t copy = block->points.ids.Append("copy");
  block->points.role.push_back(PointRole::kTie);
  block->points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
  const std::size_t count = rows.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (rows[k].point == point) rows.push_back({copy, rows[k].pass, rows[k].look});
  }
  Rebuild(rows, block);
}

}  // namespace sarblock::test
