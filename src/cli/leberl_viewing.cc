// SPDX-License-Identifier: Apache-2.0
// `sarblock leberl exaggeration` and `figures`: what a pair looks like to a person who views it,
// Leberl (1979), Eq. 9 to 11 and Fig. 2 and 6, and the configurations of Fig. 3 to 5, 8 and 9.
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/leberl/formulas.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "leberl.h"
#include "leberl/pairs.h"
#include "program.h"
#include "session.h"
#include "terminal.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

using Json = nlohmann::ordered_json;
using leberl::Arrangement;

constexpr double kShownSlope_deg = 10.0;
constexpr double kRadPerArcminute = kRadPerDeg / 60.0;
constexpr double kRadPerArcsecond = kRadPerDeg / 3600.0;

struct ExaggerationInput {
  PairInput pair;
  std::optional<double> viewing_scale;
  double eye_base_mm = 65.0;
  double acuity_arcsec = 20.0;
  double fusion_arcmin = 70.0;
};

/// What a person sees of a model: with the limits of the eyes.
struct Relief {
  double least_m = 0.0;    ///< height difference that is just seen
  double largest_m = 0.0;  ///< height difference that still fuses
};

Relief ReliefOf(double exaggeration, const leberl::StereoViewing& viewing) {
  return {HeightOfDisparity(exaggeration, viewing.acuity_rad, viewing),
          HeightOfDisparity(exaggeration, viewing.fusion_rad, viewing)};
}

std::optional<leberl::StereoViewing> ViewingOf(const ExaggerationInput& input) {
  if (!input.viewing_scale) return std::nullopt;
  const leberl::StereoViewing viewing{.scale = *input.viewing_scale,
                                      .eye_base_m = 1e-3 * input.eye_base_mm,
                                      .acuity_rad = input.acuity_arcsec * kRadPerArcsecond,
                                      .fusion_rad = input.fusion_arcmin * kRadPerArcminute};
  Validate(viewing);
  return viewing;
}

Json ExaggerationJson(const GivenPair& pair,
                      const leberl::ViewingGuidance& view,
                      double q,
                      double q_opposite,
                      const std::optional<leberl::StereoViewing>& viewing) {
  Json json = {{"exaggeration", pair.from_base ? leberl::Exaggeration(*pair.from_base) : q},
               {"exaggeration_from_angles", q}};
  if (pair.from_base) {
    json["camera_exaggeration"] =
        leberl::CameraExaggeration(std::abs(pair.from_base->base_m), *pair.height_m);
  }
  json["equivalent_base_ratio"] = leberl::EquivalentBase(q, 1.0);
  if (pair.height_m) json["equivalent_base_m"] = leberl::EquivalentBase(q, *pair.height_m);
  json["first_look_deg"] = view.first_look_rad * kDegPerRad;
  json["second_look_deg"] = view.second_look_rad * kDegPerRad;
  json["intersection_deg"] = view.intersection_rad * kDegPerRad;
  json["looks_within_37_and_67_deg"] = view.looks_within_37_and_67_deg;
  json["looks_not_below_40_deg"] = view.looks_not_below_40_deg;
  json["intersection_within_12_and_15_deg"] = view.intersection_within_12_and_15_deg;
  json["opposite_side_exaggeration"] = q_opposite;
  if (viewing) {
    const Relief relief = ReliefOf(q, *viewing), opposite = ReliefOf(q_opposite, *viewing);
    json["least_height_m"] = relief.least_m;
    json["largest_relief_m"] = relief.largest_m;
    json["opposite_side_largest_relief_m"] = opposite.largest_m;
  }
  return json;
}

void PrintBase(const GivenPair& pair, double q) {
  fmt::print("vertical exaggeration            about {:.2g}  ", q);
  if (pair.from_base) {
    fmt::print(" (Eq. 11 {:.4f}, Eq. 10 {:.4f})\n", leberl::Exaggeration(*pair.from_base), q);
  } else {
    fmt::print(" (Eq. 10: {:.4f})\n", q);
  }
  const double ratio = leberl::EquivalentBase(q, 1.0);
  if (pair.height_m) {
    fmt::print("equivalent base Bc of a camera   {:.6g} m, {:.4f} of H (Eq. 9)\n",
               leberl::EquivalentBase(q, *pair.height_m),
               ratio);
  } else {
    fmt::print("equivalent base Bc of a camera   {:.4f} of H (Eq. 9)\n", ratio);
  }
  if (pair.from_base) {
    fmt::print("a camera with this base          about {:.2g}   (Eq. 9)\n",
               leberl::CameraExaggeration(std::abs(pair.from_base->base_m), *pair.height_m));
  }
}

/// Fig. 6: what the other arrangement of the same two looks does to viewing.
void PrintFusion(const GivenPair& pair, double q_opposite) {
  const double first_deg = pair.incidence_rad[0] * kDegPerRad,
               second_deg = pair.incidence_rad[1] * kDegPerRad;
  fmt::print("the same looks from opposite sides: exaggeration about {:.2g}\n", q_opposite);
  fmt::print(
      "{}",
      FitColumns(fmt::format(
          "    A slope of {:g} deg that faces station ' has local incidence angles of {:.1f} and "
          "{:.1f} deg on the same side, {:.1f} and {:.1f} deg from opposite sides: the slopes that "
          "are bright in one image are dark in the other, and the images hardly fuse.\n",
          kShownSlope_deg,
          first_deg - kShownSlope_deg,
          second_deg - kShownSlope_deg,
          first_deg - kShownSlope_deg,
          second_deg + kShownSlope_deg)));
}

void PrintRelief(const ExaggerationInput& input,
                 const leberl::StereoViewing& viewing,
                 double q,
                 double q_opposite) {
  const Relief relief = ReliefOf(q, viewing);
  fmt::print("images at 1:{:.10g}, eye base {:g} mm, {:g} eye bases away:\n",
             viewing.scale,
             input.eye_base_mm,
             leberl::kViewingRatio);
  fmt::print("    least height seen            {:.3g} m   ({:g} arc seconds)\n",
             relief.least_m,
             input.acuity_arcsec);
  fmt::print("    largest relief that fuses    {:.3g} m   ({:g} arc minutes)\n",
             relief.largest_m,
             input.fusion_arcmin);
  fmt::print("    from opposite sides          {:.3g} m\n",
             ReliefOf(q_opposite, viewing).largest_m);
}

int PrintExaggeration(const ExaggerationInput& input, const Session& session) {
  const GivenPair pair = PairOf(input.pair);
  const auto viewing = ViewingOf(input);
  const leberl::ViewingGuidance view =
      leberl::CheckViewing(pair.incidence_rad[0], pair.incidence_rad[1], pair.arrangement);
  const double q = leberl::ExaggerationFromAngles(
      pair.incidence_rad[0], pair.incidence_rad[1], pair.arrangement);
  const double q_opposite = leberl::ExaggerationFromAngles(
      pair.incidence_rad[0], pair.incidence_rad[1], Arrangement::kOppositeSide);
  if (session.json) {
    fmt::print("{}\n", ExaggerationJson(pair, view, q, q_opposite, viewing).dump(2));
    return kAccepted;
  }
  PrintBase(pair, q);
  fmt::print("{} {:.3f} and {:.3f} deg, intersection angle {:.3f} deg\n",
             input.pair.orbit_height_km ? "angles of incidence" : "look angles",
             view.first_look_rad * kDegPerRad,
             view.second_look_rad * kDegPerRad,
             view.intersection_rad * kDegPerRad);
  const auto kept = [](bool yes) { return yes ? "kept" : "not kept"; };
  fmt::print(
      "best viewing: look angles of 37 to 67 deg {}, not below 40 deg {};\n"
      "    intersection angle of about 12 to 15 deg {}\n",
      kept(view.looks_within_37_and_67_deg),
      kept(view.looks_not_below_40_deg),
      kept(view.intersection_within_12_and_15_deg));
  PrintFusion(pair, q_opposite);
  if (viewing) PrintRelief(input, *viewing, q, q_opposite);
  return kAccepted;
}

}  // namespace

void AddLeberlExaggeration(CLI::App* leberl, Session* session) {
  const auto input = std::make_shared<ExaggerationInput>();
  CLI::App* command = leberl->add_subcommand(
      "exaggeration", "Vertical exaggeration (Eq. 9-11), viewing guidance, what the eye sees");
  command->add_option(
      "--look-1-deg", input->pair.first_look_deg, "look angle of station ' off nadir");
  command->add_option("--look-2-deg", input->pair.second_look_deg, "look angle of station ''");
  AddPairOptions(command, &input->pair);
  command->add_option("--viewing-scale",
                      input->viewing_scale,
                      "M of images viewed at 1:M: adds what is seen and what fuses");
  command->add_option("--eye-base-mm", input->eye_base_mm, "distance of the eyes")
      ->capture_default_str();
  command->add_option("--acuity-arcsec", input->acuity_arcsec, "least retinal disparity seen")
      ->capture_default_str();
  command->add_option("--fusion-arcmin", input->fusion_arcmin, "largest one that fuses")
      ->capture_default_str();
  command->callback([session, input] {
    RequireOnePair("exaggeration", HeightNeed::kOptional, input->pair);
    session->run = [session, input] { return PrintExaggeration(*input, *session); };
  });
}

namespace {

int PrintFigures(const FigureOptions& options, const Session& session) {
  const std::vector<FigureRow> rows = PaperFigures(options);
  const auto or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json();
  };
  if (session.json) {
    Json list = Json::array();
    for (const FigureRow& row : rows) {
      Json entry = {{"figure", row.figure},
                    {"configuration", row.name},
                    {"base_m", or_null(row.base_m)},
                    {"first_look_deg", row.first_look_rad * kDegPerRad},
                    {"second_look_deg", row.second_look_rad * kDegPerRad},
                    {"intersection_deg", row.intersection_rad * kDegPerRad},
                    {"sigma_x_m", Json()},
                    {"sigma_y_m", Json()},
                    {"sigma_z_m", Json()},
                    {"exaggeration", or_null(row.exaggeration)},
                    {"outcome", NameOf(row.outcome)}};
      if (row.sigmas) {
        entry["sigma_x_m"] = row.sigmas->along_m;
        entry["sigma_y_m"] = row.sigmas->across_m;
        entry["sigma_z_m"] = row.sigmas->up_m;
      }
      list.push_back(std::move(entry));
    }
    fmt::print("{}\n", list.dump(2));
    return kAccepted;
  }
  const leberl::StereoConfiguration& c = options.ground;
  fmt::print("B = {:g} m, H = {:g} m, y = {:g} m; sigma of range {:g} m, of azimuth {:g} m\n",
             c.base_m,
             c.height_m,
             c.ground_range_m,
             options.sigma_range_m,
             options.sigma_azimuth_m);
  fmt::print("{:<5}{:<21}{:>7}{:>7}{:>6}{:>7}{:>7}{:>7}{:>7}{:>6}\n",
             "Fig.",
             "configuration",
             "B [m]",
             "look'",
             "''",
             "dtheta",
             "sx [m]",
             "sy",
             "sz",
             "q");
  for (const FigureRow& row : rows) {
    fmt::print("{:<5}{:<21}{:>7}{:>7.1f}{:>6.1f}{:>7.2f}",
               row.figure,
               row.name,
               row.base_m ? fmt::format("{:.6g}", *row.base_m) : "-",
               row.first_look_rad * kDegPerRad,
               row.second_look_rad * kDegPerRad,
               row.intersection_rad * kDegPerRad);
    if (row.sigmas) {
      fmt::print(
          "{:>7.3g}{:>7.3g}{:>7.3g}", row.sigmas->along_m, row.sigmas->across_m, row.sigmas->up_m);
    } else {
      fmt::print("{:>21}", NameOf(row.outcome));
    }
    fmt::print("{:>6}\n", row.exaggeration ? fmt::format("{:.2g}", *row.exaggeration) : "-");
  }
  fmt::print(
      "Each point by its two looks alone, paths held fixed. The first six are over one\n"
      "ground, the orbit is 700 km above the Earth, the Apollo radar 116 km above the\n"
      "Moon; both take the sigmas above. One straight flight is no stereo; one curved\n"
      "orbit is a weak one. Outside: real apertures and tilted antennas, whose beams\n"
      "are cones about other axes than the flight.\n");
  return kAccepted;
}

}  // namespace

void AddLeberlFigures(CLI::App* leberl, Session* session) {
  const auto options = std::make_shared<FigureOptions>();
  CLI::App* command = leberl->add_subcommand(
      "figures", "The configurations of Fig. 3-5, 8 and 9 beside each other: angles, accuracy, q");
  leberl::StereoConfiguration* const ground = &options->ground;
  command->add_option("--base-m", ground->base_m, "stereo base B")->capture_default_str();
  command->add_option("--height-m", ground->height_m, "flying height H")->capture_default_str();
  command
      ->add_option("--ground-range-m",
                   ground->ground_range_m,
                   "ground distance y of the point from the nadir line of station '")
      ->capture_default_str();
  command
      ->add_option(
          "--sigma-range-m", options->sigma_range_m, "standard deviation of each slant range")
      ->capture_default_str();
  command
      ->add_option("--sigma-azimuth-m",
                   options->sigma_azimuth_m,
                   "standard deviation of each azimuth, along track at the target")
      ->capture_default_str();
  command->callback([session, options] {
    session->run = [session, options] { return PrintFigures(*options, *session); };
  });
}

}  // namespace sarblock::cli
