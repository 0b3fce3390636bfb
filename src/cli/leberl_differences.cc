// SPDX-License-Identifier: Apache-2.0
// `sarblock leberl differences`: errors of coordinate differences, Leberl (1979), Eq. 16 to 24.
#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"
#include "sarblock/tables/output.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leberl.h"
#include "leberl/rigorous.h"
#include "report/svg_plot.h"
#include "session.h"
#include "tables/csv.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

namespace fs = std::filesystem;
using leberl::Difference;
using leberl::Signs;

constexpr int kTableSteps = 10;  // of a profile on the terminal
constexpr int kPlotSteps = 100;  // in the files

struct DifferencesInput {
  leberl::StereoConfiguration configuration;
  Difference difference;
  leberl::StereoErrors errors;  ///< dB and dH as errors of station ''
  double first_scale_ppm = 0.0;
  double second_scale_ppm = 0.0;
  std::optional<double> far_ground_range_m;
  std::string folder;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

/// The error of one difference by all routes [m].
struct DifferenceRow {
  Difference difference;
  Difference printed;
  Difference derived;
  Difference derivative;
  Difference exact;
  double bow_m = 0.0;  ///< of a profile: d(Dz), exact, above the chord through both ends
};

Difference AcrossAndUp(const leberl::PointError& error) { return {error.dy_m, error.dz_m}; }

DifferenceRow RowAt(const DifferencesInput& input, const Difference& difference) {
  const leberl::StereoConfiguration& c = input.configuration;
  const auto exact = DifferenceErrorExact(c, input.errors, difference);
  if (!exact) {
    throw UndeterminedError(
        fmt::format("with these errors the circles of the point at Dy = {:g} m do not intersect",
                    difference.dy_m),
        {});
  }
  return {.difference = difference,
          .printed = DifferenceErrors(c, input.errors, difference, Signs::kPrinted),
          .derived = DifferenceErrors(c, input.errors, difference, Signs::kDerived),
          .derivative = AcrossAndUp(DifferenceErrorDerivative(c, input.errors, difference)),
          .exact = AcrossAndUp(*exact)};
}

/// Throws InputError unless the point `dy_m` further lies on the same side of both stations.
void CheckPoint(const leberl::StereoConfiguration& c, const char* option, double dy_m) {
  leberl::StereoConfiguration moved = c;
  moved.ground_range_m += dy_m;
  const auto sides = [](const leberl::StereoConfiguration& at) {
    return std::pair{at.ground_range_m > 0.0, at.ground_range_m > at.base_m};
  };
  const bool at_nadir = moved.ground_range_m == 0.0 || moved.ground_range_m == moved.base_m;
  if (std::isfinite(dy_m) && !at_nadir && sides(moved) == sides(c)) return;
  throw InputError(
      option,
      fmt::format("the other point lies at the ground distance {:g} m, on another side "
                  "of a station than --ground-range-m {:g}; the same side of both is "
                  "allowed",
                  moved.ground_range_m,
                  c.ground_range_m));
}

void CheckDifferences(const DifferencesInput& input) {
  const leberl::StereoConfiguration& c = input.configuration;
  Validate(c);
  CheckPoint(c, "--dy-m", input.difference.dy_m);
  if (!(std::isfinite(input.difference.dz_m) && input.difference.dz_m < c.height_m)) {
    throw InputError("--dz-m",
                     fmt::format("{:g} is given, below the flying height {:g} is allowed",
                                 input.difference.dz_m,
                                 c.height_m));
  }
  if (input.far_ground_range_m) {
    CheckPoint(c, "--far-ground-range-m", *input.far_ground_range_m - c.ground_range_m);
    if (*input.far_ground_range_m == c.ground_range_m) {
      throw InputError("--far-ground-range-m", "another distance than --ground-range-m is allowed");
    }
  } else if (!input.folder.empty()) {
    throw InputError("--output", "needs --far-ground-range-m, the far end of the profile");
  }
}

/// Equal steps from Dy = 0 to the far end, all at the height Dz.
std::vector<DifferenceRow> ProfileOf(const DifferencesInput& input, int steps) {
  const double reach_m = *input.far_ground_range_m - input.configuration.ground_range_m;
  std::vector<DifferenceRow> rows;
  for (int i = 0; i <= steps; ++i) {
    rows.push_back(RowAt(input, {.dy_m = reach_m * i / steps, .dz_m = input.difference.dz_m}));
  }
  const double begin_m = rows.front().exact.dz_m, rise_m = rows.back().exact.dz_m - begin_m;
  for (int i = 0; i <= steps; ++i) {
    DifferenceRow& row = rows[static_cast<std::size_t>(i)];
    row.bow_m = row.exact.dz_m - (begin_m + rise_m * i / steps);
  }
  return rows;
}

/// Where the exact profile is farthest off its chord; of the many steps, whatever is printed.
DifferenceRow LargestBow(const DifferencesInput& input) {
  const std::vector<DifferenceRow> rows = ProfileOf(input, kPlotSteps);
  const DifferenceRow* largest = &rows.front();
  for (const DifferenceRow& row : rows) {
    if (std::abs(row.bow_m) > std::abs(largest->bow_m)) largest = &row;
  }
  return *largest;
}

constexpr Columns kProfileColumns{{
    {"dy_m"},
    {"dz_m"},
    {"printed_ddy_m"},
    {"printed_ddz_m"},
    {"derivative_ddy_m"},
    {"derivative_ddz_m"},
    {"exact_ddy_m"},
    {"exact_ddz_m"},
    {"exact_bow_m"},
}};

std::string PlotBow(const DifferencesInput& input, const std::vector<DifferenceRow>& rows) {
  const leberl::StereoConfiguration& c = input.configuration;
  Plot plot;
  plot.title = fmt::format(
      "Error of the height difference to the point at y = {:g} m; B = {:g} m, "
      "H = {:g} m, Dz = {:g} m",
      c.ground_range_m,
      c.base_m,
      c.height_m,
      input.difference.dz_m);
  plot.x.label = "Dy [m]";
  plot.y.label = "d(Dz) [m]";
  const auto add = [&](const char* name, PlotDash dash, Difference DifferenceRow::*route) {
    PlotSeries line;
    line.name = name;
    line.mark = PlotMark::kLine;
    line.dash = dash;
    line.colour = plot.series.size();
    for (const DifferenceRow& row : rows) {
      line.points.push_back({row.difference.dy_m, (row.*route).dz_m});
    }
    plot.series.push_back(line);
  };
  add("exact", PlotDash::kSolid, &DifferenceRow::exact);
  add("derivative", PlotDash::kDashed, &DifferenceRow::derivative);
  add("as printed", PlotDash::kDotted, &DifferenceRow::printed);
  const DifferenceRow largest = LargestBow(input);
  plot.notes = {fmt::format("bow {:.3g} m", largest.bow_m),
                fmt::format("at Dy = {:.4g} m", largest.difference.dy_m)};
  return SvgOf(plot);
}

void WriteProfile(const DifferencesInput& input, const Session& session) {
  const fs::path folder(input.folder);
  MakeFolder(folder);
  const std::vector<DifferenceRow> rows = ProfileOf(input, kPlotSteps);
  const auto table = WriteCsv(folder / "differences.csv", kProfileColumns);
  WriteEach(rows.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const DifferenceRow& row = rows[i];
    NewRow line(batch);
    std::size_t column = 0;
    for (const Difference& pair : {row.difference, row.printed, row.derivative, row.exact}) {
      line.Number(column++, pair.dy_m);
      line.Number(column++, pair.dz_m);
    }
    line.Number(column, row.bow_m);
  });
  table->Commit();
  AtomicFile plot(folder / "bow.svg");
  plot.Write(PlotBow(input, rows));
  plot.Commit();
  session.Warn(fmt::format("{}: differences.csv and bow.svg", folder.string()));
}

nlohmann::ordered_json ToJson(const Difference& error) {
  return {{"ddy_m", error.dy_m}, {"ddz_m", error.dz_m}};
}

nlohmann::ordered_json RowJson(const DifferenceRow& row) {
  return {{"printed", ToJson(row.printed)},
          {"derivative", ToJson(row.derivative)},
          {"exact", ToJson(row.exact)},
          {"printed_derived_signs", ToJson(row.derived)}};
}

void PrintJson(const DifferencesInput& input,
               const DifferenceRow& row,
               const leberl::PointError& point) {
  nlohmann::ordered_json json = RowJson(row);
  json["point"] = {{"dy_m", point.dy_m}, {"dz_m", point.dz_m}};
  if (input.far_ground_range_m) {
    const std::vector<DifferenceRow> rows = ProfileOf(input, kTableSteps);
    for (const DifferenceRow& at : rows) {
      nlohmann::ordered_json entry = {{"dy_m", at.difference.dy_m}, {"dz_m", at.difference.dz_m}};
      entry.update(RowJson(at));
      entry["exact_bow_m"] = at.bow_m;
      json["profile"].push_back(std::move(entry));
    }
    const DifferenceRow largest = LargestBow(input);
    json["bow"] = {{"dy_m", largest.difference.dy_m}, {"ddz_m", largest.bow_m}};
  }
  fmt::print("{}\n", json.dump(2));
}

void PrintProfile(const DifferencesInput& input) {
  const std::vector<DifferenceRow> rows = ProfileOf(input, kTableSteps);
  fmt::print("\nagainst distance, Dz = {:g} m [m]\n", input.difference.dz_m);
  fmt::print("{:>9}{:>33}{:>36}\n", "", "d(Dy)", "d(Dz)");
  fmt::print("{:>9}", "Dy");
  for (int k = 0; k < 2; ++k) fmt::print("{:>11}{:>12}{:>12}", "printed", "derivative", "exact");
  fmt::print("\n");
  for (const DifferenceRow& row : rows) {
    fmt::print("{:>9.7g}{:>11.3f}{:>12.3f}{:>12.3f}{:>11.3f}{:>12.3f}{:>12.3f}\n",
               row.difference.dy_m,
               row.printed.dy_m,
               row.derivative.dy_m,
               row.exact.dy_m,
               row.printed.dz_m,
               row.derivative.dz_m,
               row.exact.dz_m);
  }
  const DifferenceRow largest = LargestBow(input);
  fmt::print("bow of the model: exact d(Dz) is {:.3f} m off the chord at Dy = {:g} m\n",
             largest.bow_m,
             largest.difference.dy_m);
}

int PrintDifferences(DifferencesInput input, const Session& session) {
  CheckDifferences(input);
  if (!input.folder.empty()) {
    RequireFilesFor(
        input.folder, {"dy_m,dz_m,printed_ddy_m,", "<!-- written by sarblock -->"}, input.foreign);
  }
  constexpr double kPerPpm = 1e-6;
  input.errors.first.range_scale = kPerPpm * input.first_scale_ppm;
  input.errors.second.range_scale = kPerPpm * input.second_scale_ppm;
  const leberl::StereoConfiguration& c = input.configuration;
  const DifferenceRow row = RowAt(input, input.difference);
  const leberl::PointError point = PointErrors(c, input.errors, Signs::kDerived);
  if (session.json) {
    PrintJson(input, row, point);
  } else {
    fmt::print("B = {:g} m, H = {:g} m, y = {:g} m, {}; Dy = {:g} m, Dz = {:g} m\n",
               c.base_m,
               c.height_m,
               c.ground_range_m,
               c.arrangement == leberl::Arrangement::kSameSide ? "same side" : "opposite side",
               row.difference.dy_m,
               row.difference.dz_m);
    fmt::print("{:<46}{:>16}{:>16}\n", "error of the difference [m]", "d(Dy)", "d(Dz)");
    const auto line = [](const char* name, const Difference& error) {
      fmt::print("{:<46}{:>16.6f}{:>16.6f}\n", name, error.dy_m, error.dz_m);
    };
    line("as printed (Eq. 18, 19, 22 to 24)", row.printed);
    line("with the derived signs", row.derived);
    line("derivative of the intersection", row.derivative);
    line("exact intersection", row.exact);
    line("for comparison: the point itself (Eq. 14, 15)", AcrossAndUp(point));
    if (input.first_scale_ppm != 0.0 || input.second_scale_ppm != 0.0) {
      fmt::print("The paper has no scale error: as printed it counts as the constant dr of y.\n");
    }
    if (input.far_ground_range_m) PrintProfile(input);
  }
  if (!input.folder.empty()) WriteProfile(input, session);
  return kAccepted;
}

}  // namespace

void AddLeberlDifferences(CLI::App* leberl, Session* session) {
  const auto input = std::make_shared<DifferencesInput>();
  CLI::App* command = leberl->add_subcommand(
      "differences",
      "Error of a coordinate difference by errors of the stations: Eq. 16-24, and rigorous");
  AddConfiguration(command, GroundRange::kRequired, &input->configuration);
  command->add_option("--dy-m", input->difference.dy_m, "difference Dy across")->required();
  command->add_option("--dz-m", input->difference.dz_m, "difference Dz up")->required();
  leberl::StationErrors* const second = &input->errors.second;
  command->add_option("--db", second->dy0_m, "error dB of the base, of station '' [m]");
  command->add_option("--dh", second->dz0_m, "error dH of the height difference, of '' [m]");
  command->add_option("--dr-1", input->errors.first.dr_m, "slant range error of station ' [m]");
  command->add_option("--dr-2", second->dr_m, "slant range error of station '' [m]");
  command->add_option(
      "--range-scale-1-ppm", input->first_scale_ppm, "scale error of the ranges of station '");
  command->add_option(
      "--range-scale-2-ppm", input->second_scale_ppm, "scale error of the ranges of station ''");
  command->add_option("--far-ground-range-m",
                      input->far_ground_range_m,
                      "adds a table against distance, from --ground-range-m to here");
  command->add_option(
      "-o,--output", input->folder, "folder for the table against distance and a plot of the bow");
  AddForce(command, &input->foreign);
  command->callback([session, input] {
    session->run = [session, input] { return PrintDifferences(*input, *session); };
  });
}

}  // namespace sarblock::cli
