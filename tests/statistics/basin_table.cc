// SPDX-License-Identifier: Apache-2.0
// The basin of the adjustment (docs/validation.md): from how far path errors and under how many
// gross errors a block comes home. Prints one row per draw (--draws) and the table.
//
//     SARBLOCK_DRAWS=4 basin_table [--scenes a,b] [--paths 0,0.5,1,2,5,10,20 (km)]
//         [--fractions 0,5,10,20 (percent)] [--kinds range,azimuth,match] [--ways none,huber,...]
//         [--points 150] [--seed 1] [--rows]
//         [--without]: no consensus
#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "statistics/basin.h"
#include "statistics/scene_statistics.h"

namespace {

using sarblock::test::BasinCell;
using sarblock::test::BasinOutcome;
using sarblock::test::BasinScene;
using sarblock::test::BasinWay;
using sarblock::test::GrossError;

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

struct Tally {
  int draws = 0, recovered = 0, wrong = 0, mirror = 0;
  double wall_s = 0.0;
  void Add(const BasinOutcome& outcome) {
    ++draws;
    recovered += outcome.recovered ? 1 : 0;
    wrong += outcome.wrong ? 1 : 0;
    mirror += outcome.mirror ? 1 : 0;
    wall_s += outcome.wall_s;
  }
  [[nodiscard]] std::string Text() const {
    std::string text = std::to_string(recovered) + "/" + std::to_string(draws);
    if (wrong > 0) text += " (" + std::to_string(wrong) + " wrong)";
    return text;
  }
};

template <typename Key>
void Print(const char* title,
           const std::map<std::tuple<Key, std::string>, Tally>& tallies,
           const std::vector<Key>& rows,
           const std::vector<std::string>& columns,
           std::string (*name)(const Key&)) {
  std::printf("\n| %s |", title);
  for (const std::string& column : columns) std::printf(" %s |", column.c_str());
  std::printf("\n| --- |");
  for (std::size_t i = 0; i < columns.size(); ++i) std::printf(" --- |");
  for (const Key& row : rows) {
    std::printf("\n| %s |", name(row).c_str());
    for (const std::string& column : columns) {
      const auto found = tallies.find({row, column});
      std::printf(" %s |", found == tallies.end() ? "" : found->second.Text().c_str());
    }
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> scenes = {"block-12-strips",
                                     "convergent-squint",
                                     "cross-wise",
                                     "different-altitudes",
                                     "earth-asc-desc",
                                     "earth-same-side",
                                     "leberl-aircraft",
                                     "leberl-voir",
                                     "moon-alse",
                                     "opposite-side",
                                     "venus-magellan"};
  std::vector<std::string> paths = {"0", "0.5", "1", "2", "5", "10", "20"};
  std::vector<std::string> fractions = {"0", "5", "10", "20"};
  std::vector<std::string> kinds = {"range", "azimuth", "match"};
  std::vector<std::string> ways;
  for (const BasinWay& way : sarblock::test::BasinWays()) ways.push_back(way.name);
  std::size_t points = 150;
  std::uint64_t seed = 1;
  bool rows = false, without = false;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (key == "--rows") {
      rows = true;
      continue;
    }
    if (key == "--without") {
      without = true;
      continue;
    }
    if (++i >= argc) return 2;
    const std::string value = argv[i];
    if (key == "--scenes")
      scenes = Split(value);
    else if (key == "--paths")
      paths = Split(value);
    else if (key == "--fractions")
      fractions = Split(value);
    else if (key == "--kinds")
      kinds = Split(value);
    else if (key == "--ways")
      ways = Split(value);
    else if (key == "--points")
      points = std::stoul(value);
    else if (key == "--seed")
      seed = std::stoul(value);
    else
      return 2;
  }
  const std::size_t draws = sarblock::test::DrawsAsked();
  std::map<std::tuple<std::string, std::string>, Tally> by_scene, by_path, by_way;
  std::vector<std::string> columns, way_columns;
  for (const std::string& f : fractions) columns.push_back(f + " %");
  for (const std::string& name : scenes) {
    BasinScene scene(name, points);
    if (without) scene.LeaveConsensusAway();
    for (const std::string& path : paths) {
      for (const std::string& fraction : fractions) {
        for (std::size_t k = 0; k < kinds.size(); ++k) {
          BasinCell cell{1e3 * std::stod(path), 0.01 * std::stod(fraction), GrossError::kRange};
          for (const GrossError kind :
               {GrossError::kRange, GrossError::kAzimuth, GrossError::kMatch}) {
            if (kinds[k] == sarblock::test::NameOf(kind)) cell.kind = kind;
          }
          if (cell.fraction == 0.0 && k > 0) continue;
          for (const BasinWay& way : sarblock::test::BasinWays()) {
            if (std::find(ways.begin(), ways.end(), way.name) == ways.end()) continue;
            for (std::size_t draw = 0; draw < draws; ++draw) {
              const BasinOutcome outcome = scene.Run(cell, way, seed + draw);
              const std::string column = fraction + " %";
              by_scene[{name, column}].Add(outcome);
              by_path[{path, column}].Add(outcome);
              by_way[{way.name, column}].Add(outcome);
              if (!rows) continue;
              std::printf(
                  "%s %s km %s %% %s %s %zu: %s%s%s lost %.3f worst %.3g s0^2 %.4g, %d it, %.2f s"
                  " %s\n",
                  name.c_str(),
                  path.c_str(),
                  fraction.c_str(),
                  cell.fraction == 0.0 ? "-" : kinds[k].c_str(),
                  way.name.c_str(),
                  draw,
                  outcome.recovered  ? "ok"
                  : outcome.accepted ? "accepted"
                                     : "no",
                  outcome.wrong ? " WRONG" : "",
                  outcome.mirror ? " MIRROR" : "",
                  outcome.lost_share,
                  outcome.worst_sigma,
                  outcome.sigma0_squared,
                  outcome.iterations,
                  outcome.wall_s,
                  outcome.recovered ? "" : outcome.words.substr(0, 150).c_str());
              std::fflush(stdout);
            }
          }
        }
      }
    }
  }
  const auto same = [](const std::string& name) { return name; };
  const auto km = [](const std::string& name) { return name + " km"; };
  Print<std::string>("scene", by_scene, scenes, columns, +same);
  Print<std::string>("path error", by_path, paths, columns, +km);
  Print<std::string>("way", by_way, ways, columns, +same);
  int wrong = 0, mirror = 0, count = 0;
  double wall_s = 0.0;
  for (const auto& [key, tally] : by_scene) {
    wrong += tally.wrong;
    mirror += tally.mirror;
    count += tally.draws;
    wall_s += tally.wall_s;
  }
  std::printf(
      "\n%d adjustments, %d wrong, %d mirror solutions, %.0f s\n", count, wrong, mirror, wall_s);
  return 0;
}
