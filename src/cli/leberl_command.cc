// SPDX-License-Identifier: Apache-2.0
#include "leberl_command.h"

#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <tuple>
#include <vector>

#include "columns.h"
#include "environment.h"
#include "leberl/rigorous.h"
#include "leberl/table1.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string CellText(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

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

int PrintTable1(bool csv, const Session& session) {
  std::vector<Table1Cell> cells = PaperTable1();
  if (session.json) {
    Json list = Json::array();
    for (const Table1Cell& c : cells) {
      list.push_back({{"configuration", c.configuration},
                      {"position", c.position},
                      {"quantity", c.quantity},
                      {"dy_km", OrNull(c.dy_km)},
                      {"dz_km", OrNull(c.dz_km)},
                      {"source", c.source},
                      {"size_m", c.size_m},
                      {"printed_m", OrNull(c.printed_m)},
                      {"formula_m", c.formula_m},
                      {"derivative_m", c.derivative_m},
                      {"exact_m", c.exact_m},
                      {"verdict", NameOf(c.verdict)},
                      {"note", c.note}});
    }
    fmt::print("{}\n", list.dump(2));
  } else if (csv) {
    fmt::print(
        "configuration,position,quantity,dy_km,dz_km,source,size_m,printed_m,formula_m,"
        "derivative_m,exact_m,verdict,note\n");
    for (const Table1Cell& c : cells) {
      fmt::print("{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                 c.configuration,
                 c.position,
                 c.quantity,
                 CellText(c.dy_km),
                 CellText(c.dz_km),
                 c.source,
                 c.size_m,
                 CellText(c.printed_m),
                 c.formula_m,
                 c.derivative_m,
                 c.exact_m,
                 NameOf(c.verdict),
                 CsvText(c.note));
    }
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
  }
  return kAccepted;
}

int PrintExamples(bool csv, const Session& session) {
  const std::vector<QuotedExample> examples = PaperExamples();
  if (session.json) {
    Json list = Json::array();
    for (const QuotedExample& e : examples) {
      list.push_back({{"name", e.name},
                      {"unit", e.unit},
                      {"printed", e.printed_text},
                      {"formula", e.formula},
                      {"derivative", OrNull(e.derivative)},
                      {"exact", OrNull(e.exact)},
                      {"verdict", NameOf(e.verdict)},
                      {"note", e.note}});
    }
    fmt::print("{}\n", list.dump(2));
    return kAccepted;
  }
  if (csv) fmt::print("name,unit,printed,formula,derivative,exact,verdict,note\n");
  for (const QuotedExample& e : examples) {
    if (csv) {
      fmt::print("{},{},{},{},{},{},{},{}\n",
                 CsvText(e.name),
                 e.unit,
                 e.printed_text,
                 e.formula,
                 CellText(e.derivative),
                 CellText(e.exact),
                 NameOf(e.verdict),
                 CsvText(e.note));
    } else {
      fmt::print("{:<48}{:>8} {:<3}{:>9.4g} {}\n{}",
                 e.name,
                 e.printed_text,
                 e.unit,
                 e.formula,
                 NameOf(e.verdict),
                 LinesOf(e.note));
    }
  }
  return kAccepted;
}

int PrintExaggeration(const leberl::StereoConfiguration& c, const Session& session) {
  Validate(c);
  const leberl::ViewingGuidance view = CheckViewing(c);
  const double from_angles =
      leberl::ExaggerationFromAngles(view.first_look_rad, view.second_look_rad, c.arrangement);
  const double from_base = leberl::Exaggeration(c);
  const double camera = leberl::CameraExaggeration(std::abs(c.base_m), c.height_m);
  if (session.json) {
    const Json json = {
        {"exaggeration", from_base},
        {"exaggeration_from_angles", from_angles},
        {"camera_exaggeration", camera},
        {"first_look_deg", view.first_look_rad * kDegPerRad},
        {"second_look_deg", view.second_look_rad * kDegPerRad},
        {"intersection_deg", view.intersection_rad * kDegPerRad},
        {"looks_within_37_and_67_deg", view.looks_within_37_and_67_deg},
        {"looks_not_below_40_deg", view.looks_not_below_40_deg},
        {"intersection_within_12_and_15_deg", view.intersection_within_12_and_15_deg}};
    fmt::print("{}\n", json.dump(2));
    return kAccepted;
  }
  const auto kept = [](bool yes) { return yes ? "kept" : "not kept"; };
  fmt::print("vertical exaggeration          {:.4f}   (Eq. 11; Eq. 10 gives {:.4f})\n",
             from_base,
             from_angles);
  fmt::print("of a camera with this base     {:.4f}   (Eq. 9)\n", camera);
  fmt::print("look angles {:.3f} and {:.3f} deg, intersection angle {:.3f} deg\n",
             view.first_look_rad * kDegPerRad,
             view.second_look_rad * kDegPerRad,
             view.intersection_rad * kDegPerRad);
  fmt::print(
      "best viewing: look angles of 37 to 67 deg {}, not below 40 deg {};\n"
      "    intersection angle of 12 to 15 deg {}\n",
      kept(view.looks_within_37_and_67_deg),
      kept(view.looks_not_below_40_deg),
      kept(view.intersection_within_12_and_15_deg));
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
                       {"singular_values", proof.singular_1},
                       {"plane_gap_m", proof.plane_gap_m},
                       {"radius_gap_m", proof.radius_gap_m},
                       {"outcome", NameOf(proof.outcome)},
                       {"reason", proof.reason}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("rank {} of 3 (singular values {:.3g}, {:.3g}, {:.3g}); intersection: {}\n",
               proof.rank,
               proof.singular_1[0],
               proof.singular_1[1],
               proof.singular_1[2],
               NameOf(proof.outcome));
  }
  Tell("sarblock: " + proof.reason);
  return kUndetermined;
}

}  // namespace

double OrNaN(const std::optional<double>& value) { return value.value_or(kNaN); }

std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
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
      "leberl", "The closed forms of Leberl (1979) beside the rigorous solution");
  leberl->require_subcommand(1);

  const auto csv = std::make_shared<bool>(false);
  CLI::App* table = leberl->add_subcommand("table1", "Table 1, every cell with a verdict");
  table->add_flag("--csv", *csv, "one row a cell, machine-readable");
  table->callback(
      [session, csv] { session->run = [session, csv] { return PrintTable1(*csv, *session); }; });
  CLI::App* examples = leberl->add_subcommand("examples", "Numbers quoted outside Table 1");
  examples->add_flag("--csv", *csv, "one row an example, machine-readable");
  examples->callback(
      [session, csv] { session->run = [session, csv] { return PrintExamples(*csv, *session); }; });

  AddLeberlErrors(leberl, session);

  const auto configuration = std::make_shared<leberl::StereoConfiguration>();
  CLI::App* exaggeration = leberl->add_subcommand(
      "exaggeration", "Vertical exaggeration (Eq. 9-11) and the viewing guidance");
  AddConfiguration(exaggeration, GroundRange::kRequired, configuration.get());
  exaggeration->callback([session, configuration] {
    session->run = [session, configuration] { return PrintExaggeration(*configuration, *session); };
  });

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

}  // namespace sarblock::cli
