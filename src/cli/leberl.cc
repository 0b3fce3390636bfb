// SPDX-License-Identifier: Apache-2.0
#include "leberl.h"

#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "leberl/rigorous.h"
#include "leberl/table1.h"
#include "program.h"
#include "report/svg_plot.h"
#include "session.h"
#include "tables/csv.h"
#include "terminal.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

using Json = nlohmann::ordered_json;

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

/// A note below its row, one statement a line.
std::string LinesOf(std::string_view note) {
  std::string out;
  while (!note.empty()) {
    const std::size_t end = std::min(note.find("; "), note.size());
    out.append("    ").append(note.substr(0, end)).append("\n");
    note.remove_prefix(std::min(end + 2, note.size()));
  }
  return FitColumns(out);
}

template <typename Items>
void PrintCauses(const Items& items) {
  std::vector<std::string> causes;
  for (const auto& item : items) causes.push_back(item.cause);
  fmt::print("\nslips by cause\n");
  for (const SlipCause& c : CountCauses(causes)) {
    fmt::print("{}", FitColumns(fmt::format("{:>4}  {}\n", c.count, c.cause)));
  }
}

constexpr std::array kTable1Columns = std::to_array<ListColumn<Table1Cell>>({
    {"configuration", [](const Table1Cell& c) { return Json(c.configuration); }},
    {"position", [](const Table1Cell& c) { return Json(c.position); }},
    {"quantity", [](const Table1Cell& c) { return Json(c.quantity); }},
    {"dy_km", [](const Table1Cell& c) { return OrNull(c.dy_km); }},
    {"dz_km", [](const Table1Cell& c) { return OrNull(c.dz_km); }},
    {"source", [](const Table1Cell& c) { return Json(c.source); }},
    {"size_m", [](const Table1Cell& c) { return Json(c.size_m); }},
    {"printed_m", [](const Table1Cell& c) { return OrNull(c.printed_m); }},
    {"formula_m", [](const Table1Cell& c) { return Json(c.formula_m); }},
    {"derivative_m", [](const Table1Cell& c) { return Json(c.derivative_m); }},
    {"exact_m", [](const Table1Cell& c) { return Json(c.exact_m); }},
    {"verdict", [](const Table1Cell& c) { return Json(NameOf(c.verdict)); }},
    {"note", [](const Table1Cell& c) { return Json(c.note); }},
    {"cause",
     [](const Table1Cell& c) { return Json(c.cause); },
     ListColumn<Table1Cell>::Form::kJsonAlone},
});

int PrintTable1(bool csv, const Session& session) {
  std::vector<Table1Cell> cells = PaperTable1();
  if (session.json || csv) {
    fmt::print("{}", ListOf(cells, kTable1Columns, session));
  } else {
    // One heading a column of the paper's table: aircraft before VOIR, near before far.
    std::stable_sort(cells.begin(), cells.end(), [](const Table1Cell& a, const Table1Cell& b) {
      return std::tie(a.configuration, b.position) < std::tie(b.configuration, a.position);
    });
    fmt::print("Leberl (1979), Table 1: errors in metres\n");
    std::array<int, 4> count{};
    std::string heading;
    for (const Table1Cell& c : cells) {
      const std::string of = c.configuration + ", " + c.position + " range";
      if (of != heading) {
        heading = of;
        fmt::print("\n{}\n{:<9}{:<7}{:>6}{:>9}{:>11}{:>12}{:>11}  verdict\n",
                   of,
                   "of",
                   "by",
                   "m",
                   "printed",
                   "formula",
                   "derivative",
                   "exact");
      }
      const std::string quantity =
          c.dy_km ? fmt::format("{} {:.0f},{:.0f}", c.quantity, *c.dy_km, *c.dz_km) : c.quantity;
      fmt::print("{:<9}{:<7}{:>6.0f}{:>9}{:>11.3f}{:>12.3f}{:>11.3f}  {}\n{}",
                 quantity,
                 c.source,
                 c.size_m,
                 c.printed_text,
                 c.formula_m,
                 c.derivative_m,
                 c.exact_m,
                 NameOf(c.verdict),
                 LinesOf(c.note));
      ++count[static_cast<std::size_t>(c.verdict)];
    }
    fmt::print("\n{} agree, {} truncation, {} slips, {} illegible\n",
               count[0],
               count[1],
               count[2],
               count[3]);
    PrintCauses(cells);
  }
  return kAccepted;
}

constexpr std::array kExampleColumns = std::to_array<ListColumn<QuotedExample>>({
    {"name", [](const QuotedExample& e) { return Json(e.name); }},
    {"unit", [](const QuotedExample& e) { return Json(e.unit); }},
    {"printed", [](const QuotedExample& e) { return Json(e.printed_text); }},
    {"formula", [](const QuotedExample& e) { return Json(e.formula); }},
    {"derivative", [](const QuotedExample& e) { return OrNull(e.derivative); }},
    {"exact", [](const QuotedExample& e) { return OrNull(e.exact); }},
    {"verdict", [](const QuotedExample& e) { return Json(NameOf(e.verdict)); }},
    {"note", [](const QuotedExample& e) { return Json(e.note); }},
    {"cause",
     [](const QuotedExample& e) { return Json(e.cause); },
     ListColumn<QuotedExample>::Form::kJsonAlone},
});

int PrintExamples(bool csv, const Session& session) {
  const std::vector<QuotedExample> examples = PaperExamples();
  if (session.json || csv) {
    fmt::print("{}", ListOf(examples, kExampleColumns, session));
    return kAccepted;
  }
  int slips = 0;
  for (const QuotedExample& e : examples) {
    slips += e.verdict == PaperVerdict::kSlip ? 1 : 0;
    fmt::print("{:<48}{:>8} {:<3}{:>9.4g} {}\n{}",
               e.name,
               e.printed_text,
               e.unit,
               e.formula,
               NameOf(e.verdict),
               LinesOf(e.note));
  }
  fmt::print("\n{} agree, {} slips\n", examples.size() - static_cast<std::size_t>(slips), slips);
  PrintCauses(examples);
  return kAccepted;
}

struct SquintPair {
  double height_m = 0.0, ground_range_m = 0.0, first_deg = 0.0, second_deg = 0.0;
};

int PrintSingleFlight(const SquintPair& pair, const Session& session) {
  const SingleFlightProof proof =
      ProveSingleFlight({.height_m = pair.height_m,
                         .ground_range_m = pair.ground_range_m,
                         .first_squint_rad = pair.first_deg * kRadPerDeg,
                         .second_squint_rad = pair.second_deg * kRadPerDeg});
  if (session.json) {
    const Json json = {{"rank", proof.rank},
                       {"singular_values", proof.singular},
                       {"plane_gap_m", proof.plane_gap_m},
                       {"radius_gap_m", proof.radius_gap_m},
                       {"outcome", NameOf(proof.outcome)},
                       {"reason", proof.reason}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("rank {} of 3 (singular values {:.3g}, {:.3g}, {:.3g}); intersection: {}\n",
               proof.rank,
               proof.singular[0],
               proof.singular[1],
               proof.singular[2],
               NameOf(proof.outcome));
  }
  PrintError("sarblock: " + proof.reason);
  return kUndetermined;
}

}  // namespace

double OrNaN(const std::optional<double>& value) { return value.value_or(kNaN); }

std::string CsvLine(const std::vector<Json>& cells) {
  std::string line;
  for (const Json& cell : cells) {
    if (&cell != cells.data()) line += ',';
    if (cell.is_number()) line += fmt::format("{}", cell.get<double>());
    if (cell.is_string()) AppendCsvText(cell.get_ref<const std::string&>(), &line);
  }
  return line + '\n';
}

void AddConfiguration(CLI::App* command,
                      GroundRange ground_range,
                      leberl::StereoConfiguration* configuration) {
  command->add_option("--base-m", configuration->base_m, "stereo base B")->required();
  command->add_option("--height-m", configuration->height_m, "flying height H")->required();
  if (ground_range == GroundRange::kRequired) {
    command
        ->add_option("--ground-range-m",
                     configuration->ground_range_m,
                     "ground distance y of the point from the nadir line of station '")
        ->required();
  }
  command->add_flag_callback(
      "--opposite",
      [configuration] { configuration->arrangement = leberl::Arrangement::kOppositeSide; },
      "opposite-side stereo: the point lies between the stations");
}

void AddLeberl(CLI::App* app, Session* session) {
  CLI::App* leberl = app->add_subcommand(
      "leberl", "The closed forms of Leberl (1979) compared with the rigorous solution");
  leberl->require_subcommand(1);

  const auto csv = std::make_shared<bool>(false);
  CLI::App* table = leberl->add_subcommand("table1", "Table 1, every cell with a verdict");
  table->add_flag("--csv", *csv, "one row per cell, machine-readable");
  table->callback(
      [session, csv] { session->run = [session, csv] { return PrintTable1(*csv, *session); }; });
  CLI::App* examples = leberl->add_subcommand("examples", "Numbers quoted outside Table 1");
  examples->add_flag("--csv", *csv, "one row per example, machine-readable");
  examples->callback(
      [session, csv] { session->run = [session, csv] { return PrintExamples(*csv, *session); }; });

  AddLeberlErrors(leberl, session);

  AddLeberlDifferences(leberl, session);
  AddLeberlExaggeration(leberl, session);
  AddLeberlFigures(leberl, session);
  AddLeberlParallax(leberl, session);
  AddLeberlValidity(leberl, session);

  const auto pair = std::make_shared<SquintPair>();
  CLI::App* single = leberl->add_subcommand(
      "single-flight", "Shows that one flight squinted forward and backward is no stereo");
  single->add_option("--height-m", pair->height_m, "flying height H")->required();
  single->add_option("--ground-range-m", pair->ground_range_m, "ground distance y")->required();
  single->add_option("--squint-1-deg", pair->first_deg, "squint of look '")->required();
  single->add_option("--squint-2-deg", pair->second_deg, "squint of look ''")->required();
  single->callback([session, pair] {
    session->run = [session, pair] { return PrintSingleFlight(*pair, *session); };
  });
}

namespace {

using Json = nlohmann::ordered_json;
using leberl::Presentation;

struct ParallaxInput {
  leberl::StereoConfiguration configuration;
  Presentation presentation = Presentation::kGroundRange;
  std::string table;
};

constexpr Columns kTargetColumns{{
    {"point", ColumnNeed::kOptional, CellKind::kText},
    {"ground_range_m", ColumnNeed::kRequired},
    {"point_height_m"},
    {"parallax_m"},
}};

/// One answered row; NaN where the exact relation has no answer.
struct ParallaxRow {
  std::string point;
  double ground_range_m = 0.0;
  double height_m = 0.0;
  double parallax_m = 0.0;
  double exact_height_m = 0.0;
  double exact_parallax_m = 0.0;
  double absolute_parallax_m = 0.0;
};

ParallaxRow Answer(const Row& target, const ParallaxInput& input) {
  constexpr std::size_t kHeight = kTargetColumns("point_height_m");
  constexpr std::size_t kParallax = kTargetColumns("parallax_m");
  leberl::StereoConfiguration c = input.configuration;
  c.ground_range_m = target.RequiredNumber(kTargetColumns("ground_range_m"));
  try {
    Validate(c);
  } catch (const InputError& error) {
    if (error.place().field != "ground_range_m") throw;  // of an option
    target.Fail(kTargetColumns("ground_range_m"), error.problem());
  }
  if (target.Given(kHeight) == target.Given(kParallax)) {
    target.Fail(kHeight, "exactly one of point_height_m and parallax_m is allowed in a row");
  }
  ParallaxRow row;
  row.point = target.Text(kTargetColumns("point"));
  row.ground_range_m = c.ground_range_m;
  row.absolute_parallax_m = AbsoluteParallax(c, input.presentation);
  if (target.Given(kHeight)) {
    row.height_m = row.exact_height_m = target.Number(kHeight);
    row.parallax_m = ParallaxFromHeight(c, row.height_m, input.presentation);
    row.exact_parallax_m = OrNaN(ExactParallaxFromHeight(c, row.height_m, input.presentation));
  } else {
    row.parallax_m = row.exact_parallax_m = target.Number(kParallax);
    row.height_m = HeightFromParallax(c, row.parallax_m, input.presentation);
    row.exact_height_m = OrNaN(ExactHeightFromParallax(c, row.parallax_m, input.presentation));
  }
  return row;
}

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

constexpr std::array kParallaxColumns = std::to_array<ListColumn<ParallaxRow>>({
    {"point", [](const ParallaxRow& row) { return Json(row.point); }},
    {"ground_range_m", [](const ParallaxRow& row) { return Json(row.ground_range_m); }},
    {"point_height_m", [](const ParallaxRow& row) { return NumberOrNull(row.height_m); }},
    {"parallax_m", [](const ParallaxRow& row) { return NumberOrNull(row.parallax_m); }},
    {"exact_point_height_m",
     [](const ParallaxRow& row) { return NumberOrNull(row.exact_height_m); }},
    {"exact_parallax_m", [](const ParallaxRow& row) { return NumberOrNull(row.exact_parallax_m); }},
    {"absolute_parallax_m",
     [](const ParallaxRow& row) { return NumberOrNull(row.absolute_parallax_m); }},
});

int PrintParallax(const ParallaxInput& input, const Session& session) {
  const auto table = ReadCsv(input.table, kTargetColumns);
  std::vector<ParallaxRow> rows;  // nothing is printed where a later row is refused
  ForRows(table.get(), [&](const Row& target) { rows.push_back(Answer(target, input)); });
  fmt::print("{}", ListOf(rows, kParallaxColumns, session));
  return kAccepted;
}

}  // namespace

void AddLeberlParallax(CLI::App* leberl, Session* session) {
  const auto input = std::make_shared<ParallaxInput>();
  CLI::App* command = leberl->add_subcommand(
      "parallax",
      "Height from parallax or parallax from height for a table of points (Eq. 6-8), CSV to "
      "standard output");
  AddConfiguration(command, GroundRange::kFromTable, &input->configuration);
  const std::map<std::string, Presentation> presentations = {{"ground", Presentation::kGroundRange},
                                                             {"slant", Presentation::kSlantRange}};
  command->add_option("--presentation", input->presentation, "range in the images: ground or slant")
      ->transform(ChoiceOf(presentations))
      ->required();
  command
      ->add_option("TABLE",
                   input->table,
                   "CSV with ground_range_m and in each row point_height_m or parallax_m; point "
                   "is copied")
      ->required();
  command->callback([session, input] {
    session->run = [session, input] { return PrintParallax(*input, *session); };
  });
}

namespace {

using Json = nlohmann::ordered_json;
using leberl::PointError;
using leberl::Signs;
using leberl::StationErrors;

struct ErrorsInput {
  leberl::StereoConfiguration configuration;
  double along_m = 0.0;
  leberl::StereoErrors errors;
  std::optional<double> range_sigma_m;
};

Json ToJson(const PointError& error) {
  return {{"dx_m", error.dx_m}, {"dy_m", error.dy_m}, {"dz_m", error.dz_m}};
}

int PrintErrors(const ErrorsInput& input, const Session& session) {
  const leberl::StereoConfiguration& c = input.configuration;
  Validate(c);
  const PointError formula = PointErrors(c, input.errors, Signs::kPrinted);
  const PointError derived = PointErrors(c, input.errors, Signs::kDerived);
  const PointError derivative = StereoErrorDerivative(c, input.errors);
  const auto exact = StereoErrorExact(c, input.errors);
  if (!exact) {
    throw UndeterminedError("with these errors the two circles do not intersect", {});
  }
  std::optional<leberl::RangeNoise> noise, rigorous_noise;
  if (input.range_sigma_m) {
    if (!(*input.range_sigma_m > 0.0)) {
      throw InputError("--sigma-range-m",
                       fmt::format("{} is given, > 0 is allowed", *input.range_sigma_m));
    }
    noise = leberl::NoiseOfRange(c, *input.range_sigma_m);
    rigorous_noise = StereoRangeNoise(c, *input.range_sigma_m);
  }
  if (session.json) {
    Json json = {{"formula", ToJson(formula)},
                 {"derivative", ToJson(derivative)},
                 {"exact", ToJson(*exact)},
                 {"formula_derived_signs", ToJson(derived)}};
    if (noise) {
      json["sigma_y_m"] = noise->sigma_y_m;
      json["sigma_z_m"] = noise->sigma_z_m;
      json["rigorous_sigma_y_m"] = rigorous_noise->sigma_y_m;
      json["rigorous_sigma_z_m"] = rigorous_noise->sigma_z_m;
    }
    fmt::print("{}\n", json.dump(2));
    return kAccepted;
  }
  fmt::print("{:<40}{:>13}{:>13}{:>13}\n", "error of the point [m]", "dx", "dy", "dz");
  const auto line = [](const char* name, const PointError& e) {
    fmt::print("{:<40}{:>13.6f}{:>13.6f}{:>13.6f}\n", name, e.dx_m, e.dy_m, e.dz_m);
  };
  line("formula (Eq. 13-15)", formula);
  line("formula with the derived sign of dydot0", derived);
  line("derivative of the intersection", derivative);
  line("exact intersection", *exact);
  if (noise) {
    fmt::print("{:<53}{:>13.6f}{:>13.6f}\n",
               "sigma_y, sigma_z by range noise (Eq. 25)",
               noise->sigma_y_m,
               noise->sigma_z_m);
    fmt::print("{:<53}{:>13.6f}{:>13.6f}\n",
               "covariance of the intersection",
               rigorous_noise->sigma_y_m,
               rigorous_noise->sigma_z_m);
  }
  return kAccepted;
}

void AddStation(CLI::App* command, const std::string& suffix, StationErrors* errors) {
  const std::string station = suffix == "-1" ? " of station '" : " of station ''";
  command->add_option("--dx0" + suffix, errors->dx0_m, "along-track position error [m]" + station);
  command->add_option("--dy0" + suffix, errors->dy0_m, "across-track position error [m]" + station);
  command->add_option("--dz0" + suffix, errors->dz0_m, "height error [m]" + station);
  command->add_option("--dr" + suffix, errors->dr_m, "slant range error [m]" + station);
  command->add_option(
      "--dydot" + suffix, errors->dydot0, "velocity direction error across [1]" + station);
  command->add_option(
      "--dzdot" + suffix, errors->dzdot0, "velocity direction error up [1]" + station);
}

}  // namespace

void AddLeberlErrors(CLI::App* leberl, Session* session) {
  const auto input = std::make_shared<ErrorsInput>();
  CLI::App* command = leberl->add_subcommand(
      "errors", "Error of a point by errors of the stations: Eq. 13-15 and 25, and rigorous");
  AddConfiguration(command, GroundRange::kRequired, &input->configuration);
  command->add_option(
      "--along-m", input->along_m, "x of point and stations; no error depends on it");
  AddStation(command, "-1", &input->errors.first);
  AddStation(command, "-2", &input->errors.second);
  command->add_option("--sigma-range-m",
                      input->range_sigma_m,
                      "standard deviation of both slant ranges: adds sigma_y and sigma_z");
  command->callback([session, input] {
    session->run = [session, input] { return PrintErrors(*input, *session); };
  });
}

namespace {

namespace fs = std::filesystem;

constexpr Columns kMapColumns{{
    {"source", ColumnNeed::kOptional, CellKind::kText},
    {"arrangement", ColumnNeed::kOptional, CellKind::kText},
    {"look_deg"},
    {"base_ratio"},
    {"terrain_ratio"},
    {"error_ratio"},
    {"relative_difference"},
}};
constexpr Columns kLineColumns{{
    {"source", ColumnNeed::kOptional, CellKind::kText},
    {"arrangement", ColumnNeed::kOptional, CellKind::kText},
    {"look_deg"},
    {"base_ratio"},
    {"terrain_ratio"},
    {"error_ratio_1_percent"},
    {"error_ratio_5_percent"},
    {"error_ratio_20_percent"},
}};

/// A row of one of these two tables, without its last columns.
template <const auto& kColumns>
NewRow CaseRow(const ValidityCase& of, Batch* batch) {
  const bool same = of.arrangement == leberl::Arrangement::kSameSide;
  NewRow row(batch);
  row.Text(kColumns("source"), NameOf(of.source));
  row.Text(kColumns("arrangement"), same ? "same-side" : "opposite-side");
  // 30, not 29.999999999999996
  row.Number(kColumns("look_deg"), std::round(of.look_rad * kDegPerRad * 1e9) / 1e9);
  row.Number(kColumns("base_ratio"), of.base_ratio);
  row.Number(kColumns("terrain_ratio"), of.terrain_ratio);
  return row;
}

int WriteValidity(const fs::path& folder, ForeignFiles foreign, const Session& session) {
  RequireFilesFor(
      folder, {"source,arrangement,look_deg,", "<!-- written by sarblock -->"}, foreign);
  const ValidityOptions options;
  MakeFolder(folder);
  const std::vector<ValidityRow> rows = ValidityMap(options);
  const auto map = WriteCsv(folder / "validity_map.csv", kMapColumns);
  WriteEach(rows.size(), map.get(), [&](std::size_t i, Batch* batch) {
    CaseRow<kMapColumns>(rows[i].of, batch)
        .Number(kMapColumns("error_ratio"), rows[i].error_ratio)
        .Number(kMapColumns("relative_difference"), OrNaN(rows[i].relative_difference));
  });
  map->Commit();
  const std::vector<ValidityLine> found = ValidityLines(options);
  const auto lines = WriteCsv(folder / "validity_lines.csv", kLineColumns);
  WriteEach(found.size(), lines.get(), [&](std::size_t i, Batch* batch) {
    CaseRow<kLineColumns>(found[i].of, batch)
        .Number(kLineColumns("error_ratio_1_percent"), OrNaN(found[i].error_ratio_1_percent))
        .Number(kLineColumns("error_ratio_5_percent"), OrNaN(found[i].error_ratio_5_percent))
        .Number(kLineColumns("error_ratio_20_percent"), OrNaN(found[i].error_ratio_20_percent));
  });
  lines->Commit();
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
  session.Warn(
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

namespace {

constexpr double kLowest = 1e-4, kHighest = 1.0;  // error/H

struct Level {
  std::optional<double> ValidityLine::*ratio;
  PlotDash dash;
  const char* name;
};
constexpr std::array<Level, 3> kLevels = {
    {{&ValidityLine::error_ratio_1_percent, PlotDash::kDotted, "1 %"},
     {&ValidityLine::error_ratio_5_percent, PlotDash::kDashed, "5 %"},
     {&ValidityLine::error_ratio_20_percent, PlotDash::kSolid, "20 %"}}};

PlotSeries EmptySeries(std::size_t colour, PlotDash dash) {
  PlotSeries line;
  line.mark = PlotMark::kLine;
  line.colour = colour;
  line.dash = dash;
  return line;
}

}  // namespace

std::string PlotValidity(const std::vector<ValidityLine>& lines,
                         ValiditySource source,
                         double terrain_ratio) {
  std::vector<const ValidityLine*> chosen;
  std::vector<double> bases;
  for (const ValidityLine& line : lines) {
    if (line.of.source != source || line.of.terrain_ratio != terrain_ratio) continue;
    chosen.push_back(&line);
    if (std::find(bases.begin(), bases.end(), line.of.base_ratio) == bases.end()) {
      bases.push_back(line.of.base_ratio);
    }
  }
  Plot plot;
  plot.title =
      fmt::format("Size of {} at which the first order is off by 1, 5 and 20 %; point at z/H = {}",
                  NameOf(source),
                  terrain_ratio);
  plot.x.label = "look angle of station ' [deg]";
  plot.y = {.label = "error / H", .scale = PlotScale::kLog, .range = {{kLowest, kHighest}}};
  constexpr std::array<double, 2> kGap = {std::numeric_limits<double>::quiet_NaN(),
                                          std::numeric_limits<double>::quiet_NaN()};
  bool terrain_exceeds = false;
  for (std::size_t b = 0; b < bases.size(); ++b) {
    for (const Level& level : kLevels) {
      PlotSeries series = EmptySeries(b, level.dash);
      leberl::Arrangement side = leberl::Arrangement::kSameSide;
      for (const ValidityLine* line : chosen) {
        if (line->of.base_ratio != bases[b]) continue;
        const std::optional<double>& ratio = line->*level.ratio;
        // The line breaks where terrain alone exceeds the level (0), outside the plot, and where
        // the point passes from between the stations to one side of them.
        if (!ratio || *ratio < kLowest || *ratio > kHighest) {
          series.points.push_back(kGap);
          terrain_exceeds = terrain_exceeds || (ratio && *ratio == 0.0);
          continue;
        }
        if (line->of.arrangement != side) series.points.push_back(kGap);
        side = line->of.arrangement;
        series.points.push_back({line->of.look_rad * kDegPerRad, *ratio});
      }
      plot.series.push_back(series);
    }
    PlotSeries name = EmptySeries(b, PlotDash::kSolid);
    name.name = fmt::format("B/H = {}", bases[b]);
    name.in_its_colour = true;
    plot.series.push_back(name);
  }
  for (const Level& level : kLevels) {
    PlotSeries name = EmptySeries(PlotSeries::kBlack, level.dash);
    name.name = level.name;
    plot.series.push_back(name);
  }
  plot.notes = {"Left of a gap:", "opposite-side,", "right: same-side."};
  if (terrain_exceeds) {
    plot.notes.insert(plot.notes.end(), {"", "No line: terrain", "alone exceeds it."});
  }
  return SvgOf(plot);
}

}  // namespace sarblock::cli
