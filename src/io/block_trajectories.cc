// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <cmath>
#include <utility>

#include "block_reader.h"
#include "core/text.h"

namespace sarblock {
namespace {

enum { kStatePass, kStateTime, kStateX, kStateY, kStateZ, kStateVx, kStateVy, kStateVz };

Eigen::Vector3d Position(const TableReader& reader) {
  Eigen::Vector3d position_m;
  for (std::size_t k = 0; k < 3; ++k) {
    static_cast<void>(reader.RequiredNumber(kStateX + k));
    position_m[static_cast<Eigen::Index>(k)] = LengthNumber(reader, kStateX + k);
  }
  return position_m;
}

Eigen::Vector3d Velocity(const TableReader& reader) {
  Eigen::Vector3d velocity_mps;
  for (std::size_t k = 0; k < 3; ++k) {
    const double value_mps = reader.RequiredNumber(kStateVx + k);
    if (!(std::abs(value_mps) < kSpeedOfLight_mps)) {
      reader.Fail(kStateVx + k,
                  NumberText(value_mps) + " m/s is not allowed, less than the speed of light is");
    }
    velocity_mps[static_cast<Eigen::Index>(k)] = value_mps;
  }
  return velocity_mps;
}

}  // namespace

PathTable ReadPaths(TableReader* reader, const IdTable& pass_ids, const char* holder) {
  PathTable table;
  table.states.resize(pass_ids.size());
  table.lines.resize(pass_ids.size(), 0);
  while (reader->Next()) {
    const std::uint32_t pass = FindPass(*reader, kStatePass, pass_ids, holder);
    std::vector<StateVector>& states = table.states[pass];
    const StateVector state{
        reader->RequiredNumber(kStateTime), Position(*reader), Velocity(*reader)};
    if (!states.empty() && !(state.time_s > states.back().time_s)) {
      const std::string before = "; the state before, on " + reader->NameOfLine(table.lines[pass]) +
                                 ", is at " + NumberText(states.back().time_s) + " s";
      const std::string id = Quoted(pass_ids[pass]);
      reader->Fail(kStateTime,
                   state.time_s == states.back().time_s
                       ? "pass " + id + " has two states at " + NumberText(state.time_s) +
                             " s, one is allowed" + before
                       : "times of pass " + id + " must increase, " + NumberText(state.time_s) +
                             " s does not" + before);
    }
    if (state.velocity_mps.squaredNorm() == 0.0) {
      reader->Fail(kStateVx, "the velocity is zero, the antenna must move");
    }
    states.push_back(state);
    table.lines[pass] = reader->line();
  }
  return table;
}

void ReadTrajectories(BlockReading* reading) {
  const auto reader = reading->source.Require("trajectories", kPathColumns);
  WarnOfUnknownColumns(*reader, &reading->result.warnings);
  PathTable table = ReadPaths(reader.get(), reading->pass_ids);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    Pass& pass = reading->result.block.passes[i];
    if (table.states[i].empty()) {
      throw InputError(
          reading->pass_places[i],
          "pass " + Quoted(pass.id) + " has no states in trajectories.csv, two or more are needed");
    }
    if (table.states[i].size() == 1) {
      throw InputError(reader->PlaceAt(table.lines[i], kStatePass),
                       "pass " + Quoted(pass.id) + " has one state, two or more are needed");
    }
    pass.path = FlightPath(std::move(table.states[i]));
  }
}

}  // namespace sarblock
