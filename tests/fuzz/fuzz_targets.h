// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"
#include "sarblock/io/adjust_table.h"
#include "sarblock/io/block_files.h"
#include "sarblock/io/csv_reader.h"
#include "sarblock/io/scene_file.h"

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

// What the fuzzers run and the unit tests replay on the corpus. A file may be refused by
// InputError and by nothing else; what is accepted has to keep its promises.
namespace sarblock::fuzz {

inline constexpr std::string_view kToml =
    "format = \"sarblock-block 1\"\n[frame]\nkind = \"geocentric\"\nellipsoid = \"Moon\"\n"
    "[sigma]\nrange_m = 1.5\nazimuth_m = 2.5\n[[pass]]\nid = \"A\"\nlook = \"left\"\n"
    "wavelength_m = 0.03\n[[pass]]\nid = \"B\"\nlook = \"right\"\n";
inline constexpr std::string_view kPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\nA,0,2e6,0,0,0,1500,0\nA,40,2e6,6e4,0,0,1500,0\n"
    "B,0,2e6,0,9000,0,1500,0\nB,40,2e6,6e4,9000,0,1500,0\n";
inline constexpr std::string_view kLooks =
    "pass,point,time_s,range_m\nA,P,12.5,300000\nB,P,12.75,300100\n";

inline void Check(bool holds) {
  if (!holds) std::abort();
}

template <typename Run>
void AllowInputError(const Run& run) {
  try {
    run();
  } catch (const InputError&) {
  }
}

// Offsets and indices of an accepted block stay inside its arrays.
inline void CheckBlock(const Block& block) {
  Check(block.looks.offsets.size() == block.points.size() + 1);
  Check(block.looks.offsets.back() == block.looks.size());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    Check(block.looks.pass[i] < block.passes.size());
    const LookSigma sigma = block.SigmaOf(i);
    Check(sigma.range_m > 0.0 && sigma.azimuth > 0.0 && block.looks.range_m[i] > 0.0);
  }
  for (const Pass& pass : block.passes) Check(pass.start_s < pass.end_s);
}

/// The text as any table, and as each table of a block.
inline void Csv(std::string_view text) {
  constexpr std::array<CsvColumn, 3> columns{{{"pass"}, {"point"}, {"x_m"}}};
  AllowInputError([&] {
    CsvReader reader("t.csv", text, columns);
    while (reader.Next()) {
      static_cast<void>(reader.Text(0));
      static_cast<void>(reader.Id(1));
      static_cast<void>(reader.Number(2));
    }
  });
  AllowInputError([&] { CheckBlock(ReadBlockTexts({kToml, text, kLooks, {}}).block); });
  AllowInputError([&] { CheckBlock(ReadBlockTexts({kToml, kPaths, text, {}}).block); });
  AllowInputError([&] { CheckBlock(ReadBlockTexts({kToml, kPaths, kLooks, text}).block); });
}

/// The text as block.toml; options that are read are dumped and read back to the same.
inline void BlockToml(std::string_view text) {
  AllowInputError([&] {
    const BlockFile file = ReadBlockTexts({text, kPaths, kLooks, {}});
    CheckBlock(file.block);
    std::vector<std::string> ids;
    for (const Pass& pass : file.block.passes) ids.push_back(pass.id);
    const std::string dumped = DumpAdjustTable(file.adjust);
    try {
      Check(DumpAdjustTable(ReadAdjustTable(dumped, "dump", ids)) == dumped);
    } catch (const InputError&) {
      std::abort();
    }
  });
}

/// The text as a scene; what is accepted has the numbers that a simulation relies on, and its
/// [adjust] reaches the block as TOML that parses.
inline void SceneToml(std::string_view text) {
  AllowInputError([&] {
    const Scene scene = ParseScene(text, "scene.toml");
    Check(!scene.flights.empty());
    for (const SceneFlight& flight : scene.flights) {
      Check(flight.count > 0 && flight.height_m > 0.0 && flight.length_m > 0.0);
      Check(flight.swath.limits[0] < flight.swath.limits[1]);
    }
    Check(scene.points.east_m[0] <= scene.points.east_m[1]);
    static_cast<void>(ReadAdjustTable(scene.adjust_toml, "adjust", {}));
  });
}

}  // namespace sarblock::fuzz
