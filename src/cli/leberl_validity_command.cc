// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <cmath>
#include <filesystem>

#include "leberl_command.h"
#include "tables/csv.h"
#include "validity_plot.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

namespace fs = std::filesystem;

void WriteCase(const ValidityCase& of, CsvWriter* csv) {
  csv->Text(NameOf(of.source))
      .Text(of.arrangement == leberl::Arrangement::kSameSide ? "same-side" : "opposite-side")
      .Number(std::round(of.look_rad * kDegPerRad * 1e9) / 1e9)  // 30, not 29.999999999999996
      .Number(of.base_ratio_1)
      .Number(of.terrain_ratio_1);
}

int WriteValidity(const fs::path& folder, ForeignFiles foreign, const Session& session) {
  RequireFilesFor(
      folder, {"source,arrangement,look_deg,", "<!-- written by sarblock -->"}, foreign);
  const ValidityOptions options;
  MakeFolder(folder);
  CsvWriter map(folder / "validity_map.csv",
                {"source",
                 "arrangement",
                 "look_deg",
                 "base_ratio",
                 "terrain_ratio",
                 "error_ratio",
                 "relative_difference"});
  for (const ValidityRow& row : ValidityMap(options)) {
    WriteCase(row.of, &map);
    map.Number(row.error_ratio_1).Number(OrNaN(row.relative_difference)).EndRow();
  }
  map.Commit();
  CsvWriter csv(folder / "validity_lines.csv",
                {"source",
                 "arrangement",
                 "look_deg",
                 "base_ratio",
                 "terrain_ratio",
                 "error_ratio_1_percent",
                 "error_ratio_5_percent",
                 "error_ratio_20_percent"});
  for (const ValidityLine& line : ValidityLines(options)) {
    WriteCase(line.of, &csv);
    csv.Number(OrNaN(line.error_ratio_1_percent))
        .Number(OrNaN(line.error_ratio_5_percent))
        .Number(OrNaN(line.error_ratio_20_percent))
        .EndRow();
  }
  csv.Commit();
  ValidityOptions fine = options;
  fine.look_deg.clear();
  for (int look_deg = 20; look_deg <= 70; ++look_deg) fine.look_deg.push_back(look_deg);
  const std::vector<ValidityLine> curves = ValidityLines(fine);
  for (const auto& [source, name] : {std::pair{ValiditySource::kAcrossPosition, "dy0"},
                                     std::pair{ValiditySource::kUpPosition, "dz0"},
                                     std::pair{ValiditySource::kRange, "dr"}}) {
    for (const double terrain_ratio : options.terrain_ratio) {
      AtomicFile file(folder / fmt::format("validity_{}_z{:g}.svg", name, terrain_ratio));
      file.Write(PlotValidity(curves, source, terrain_ratio));
      file.Commit();
    }
  }
  session.Say(
      fmt::format("{}: validity_map.csv, validity_lines.csv and nine plots", folder.string()));
  return kAccepted;
}

}  // namespace

void AddLeberlValidity(CLI::App* leberl, Session* session) {
  const auto folder = std::make_shared<std::string>();
  const auto foreign = std::make_shared<ForeignFiles>(ForeignFiles::kRefuse);
  CLI::App* command = leberl->add_subcommand(
      "validity", "Maps of the difference between the formulas and the exact intersection");
  command->add_option("-o,--output", *folder, "folder to write to")->required();
  AddForce(command, foreign.get());
  command->callback(
      [=] { session->run = [=] { return WriteValidity(*folder, *foreign, *session); }; });
}

}  // namespace sarblock::cli
