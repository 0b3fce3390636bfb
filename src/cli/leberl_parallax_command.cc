// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <array>
#include <cmath>
#include <map>

#include "command_line.h"
#include "leberl/rigorous.h"
#include "leberl_command.h"
#include "tables/csv.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

using Json = nlohmann::ordered_json;
using leberl::Presentation;

struct ParallaxInput {
  leberl::StereoConfiguration configuration;
  Presentation presentation = Presentation::kGroundRange;
  std::string table;
};

enum Column : std::size_t { kPoint, kGroundRange, kPointHeight, kParallax };
constexpr std::array<TableColumn, 4> kTargetColumns = {{{"point", ColumnNeed::kOptional},
                                                        {"ground_range_m", ColumnNeed::kRequired},
                                                        {"point_height_m", ColumnNeed::kOptional},
                                                        {"parallax_m", ColumnNeed::kOptional}}};

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

ParallaxRow Answer(const CsvReader& reader, const ParallaxInput& input) {
  leberl::StereoConfiguration c = input.configuration;
  c.ground_range_m = reader.RequiredNumber(kGroundRange);
  try {
    Validate(c);
  } catch (const InputError& error) {
    reader.Fail(kGroundRange, error.what());
  }
  if (reader.Given(kPointHeight) == reader.Given(kParallax)) {
    reader.Fail(kPointHeight, "exactly one of point_height_m and parallax_m is allowed in a row");
  }
  ParallaxRow row;
  row.point = reader.Text(kPoint);
  row.ground_range_m = c.ground_range_m;
  row.absolute_parallax_m = AbsoluteParallax(c);
  if (reader.Given(kPointHeight)) {
    row.height_m = row.exact_height_m = reader.Number(kPointHeight);
    row.parallax_m = ParallaxFromHeight(c, row.height_m, input.presentation);
    row.exact_parallax_m = OrNaN(ExactParallaxFromHeight(c, row.height_m, input.presentation));
  } else {
    row.parallax_m = row.exact_parallax_m = reader.Number(kParallax);
    row.height_m = HeightFromParallax(c, row.parallax_m, input.presentation);
    row.exact_height_m = OrNaN(ExactHeightFromParallax(c, row.parallax_m, input.presentation));
  }
  return row;
}

std::string Number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }
Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

int PrintParallax(const ParallaxInput& input, const Session& session) {
  CsvReader reader(input.table, kTargetColumns);
  Json list = Json::array();
  if (!session.json) {
    fmt::print(
        "point,ground_range_m,point_height_m,parallax_m,exact_point_height_m,exact_parallax_m,"
        "absolute_parallax_m\n");
  }
  while (reader.Next()) {
    const ParallaxRow row = Answer(reader, input);
    if (session.json) {
      list.push_back({{"point", row.point},
                      {"ground_range_m", row.ground_range_m},
                      {"point_height_m", row.height_m},
                      {"parallax_m", row.parallax_m},
                      {"exact_point_height_m", NumberOrNull(row.exact_height_m)},
                      {"exact_parallax_m", NumberOrNull(row.exact_parallax_m)},
                      {"absolute_parallax_m", row.absolute_parallax_m}});
    } else {
      fmt::print("{},{},{},{},{},{},{}\n",
                 CsvText(row.point),
                 Number(row.ground_range_m),
                 Number(row.height_m),
                 Number(row.parallax_m),
                 Number(row.exact_height_m),
                 Number(row.exact_parallax_m),
                 Number(row.absolute_parallax_m));
    }
  }
  if (session.json) fmt::print("{}\n", list.dump(2));
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

}  // namespace sarblock::cli
