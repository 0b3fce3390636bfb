// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <array>
#include <cmath>
#include <optional>

#include "leberl/rigorous.h"
#include "leberl_command.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
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

void CheckFinite(const StationErrors& errors, const char* station) {
  const std::array values = {
      errors.dx0_m, errors.dy0_m, errors.dz0_m, errors.dr_m, errors.dydot0_1, errors.dzdot0_1};
  for (const double value : values) {
    if (!std::isfinite(value)) {
      throw InputError(fmt::format("errors of station {}", station), "a finite number is allowed");
    }
  }
}

int PrintErrors(const ErrorsInput& input, const Session& session) {
  const leberl::StereoConfiguration& c = input.configuration;
  Validate(c);
  CheckFinite(input.errors.first, "'");
  CheckFinite(input.errors.second, "''");
  const PointError formula = PointErrors(c, input.errors, Signs::kPrinted);
  const PointError derived = PointErrors(c, input.errors, Signs::kDerived);
  const PointError derivative = StereoErrorDerivative(c, input.errors);
  const auto exact = StereoErrorExact(c, input.errors);
  if (!exact) {
    throw UndeterminedError("with these errors the two circles do not intersect", {});
  }
  std::optional<leberl::RangeNoise> noise, rigorous_noise;
  if (input.range_sigma_m) {
    if (!(std::isfinite(*input.range_sigma_m) && *input.range_sigma_m > 0.0)) {
      throw InputError("sigma_range_m", "> 0 is allowed");
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
      "--dydot" + suffix, errors->dydot0_1, "velocity direction error across [1]" + station);
  command->add_option(
      "--dzdot" + suffix, errors->dzdot0_1, "velocity direction error up [1]" + station);
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

}  // namespace sarblock::cli
