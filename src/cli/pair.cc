// SPDX-License-Identifier: Apache-2.0
// What a stereo pair gives before it is flown: `sarblock plan pair`, its accuracy; `sarblock leberl
// exaggeration`, what it looks like to a person who views it, Leberl (1979), Eq. 9 to 11 and Fig. 2
// and 6; `sarblock leberl figures`, the configurations of Fig. 3 to 5, 8 and 9.
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/leberl/formulas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leberl.h"
#include "leberl/pairs.h"
#include "program.h"
#include "session.h"
#include "simulate/scene.h"
#include "terminal.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {

// ---- a pair on the command line

namespace {

using leberl::Arrangement;
using Json = nlohmann::ordered_json;

/// A body below an orbit and the name of its ellipsoid.
struct OrbitBody {
  const char* name;
  const char* ellipsoid;
};
constexpr std::array<OrbitBody, 4> kBodies = {
    {{"Earth", "WGS84"}, {"Moon", "Moon"}, {"Venus", "Venus"}, {"Mars", "Mars"}}};

/// A stereo pair on the command line: B, H and y, or two look angles, alone, from a height or from
/// an orbit. `plan pair` and `leberl exaggeration` take it.
struct PairInput {
  /// Options of the look angles, for messages.
  std::array<const char*, 2> look_names{"--look-1-deg", "--look-2-deg"};
  std::optional<double> base_m, height_m, ground_range_m;
  std::optional<double> first_look_deg, second_look_deg;
  std::optional<double> orbit_height_km;
  std::optional<int> body;  ///< index of the bodies that --body names
  leberl::Arrangement arrangement = leberl::Arrangement::kSameSide;
};

/// The pair that was given, checked.
struct GivenPair {
  std::array<double, 2> look_rad{};       ///< off nadir, magnitudes
  std::array<double, 2> incidence_rad{};  ///< at the point; from an aircraft the look angles
  leberl::Arrangement arrangement = leberl::Arrangement::kSameSide;
  std::optional<double> height_m;                                  ///< of flight
  double body_radius_m = std::numeric_limits<double>::infinity();  ///< of an orbit's body
  std::optional<leberl::StereoConfiguration> from_base;            ///< where B, H and y are given
};

double CheckedLook(const char* option, double look_deg) {
  if (!(look_deg > 0.0 && look_deg < 90.0)) {
    throw InputError(option, fmt::format("{:g} is given, between 0 and 90 is allowed", look_deg));
  }
  return look_deg * kRadPerDeg;
}

/// `unit` begins with a space; of a number without one it is empty.
double CheckedPositive(const char* option, double value, const char* unit) {
  if (!(std::isfinite(value) && value > 0.0)) {
    throw InputError(option, fmt::format("{:g}{} is given, > 0 is allowed", value, unit));
  }
  return value;
}

double CheckedIncidence(const char* option, double look_rad, double height_m, double radius_m) {
  const double incidence_rad = IncidenceAngle(look_rad, height_m, radius_m);
  if (std::isfinite(incidence_rad)) return incidence_rad;
  throw InputError(option,
                   fmt::format("{:g} deg passes the body by, below {:.3f} deg is allowed",
                               look_rad * kDegPerRad,
                               std::asin(radius_m / (radius_m + height_m)) * kDegPerRad));
}

GivenPair PairOfBase(const PairInput& input) {
  const leberl::StereoConfiguration c{
      *input.base_m, input.height_m.value(), input.ground_range_m.value(), input.arrangement};
  Validate(c);
  GivenPair pair;
  pair.arrangement = input.arrangement;
  pair.from_base = c;
  pair.height_m = c.height_m;
  pair.look_rad = {std::abs(FirstLookAngle(c)), std::abs(SecondLookAngle(c))};
  pair.incidence_rad = pair.look_rad;
  return pair;
}

/// Adds --base-m, --height-m, --ground-range-m, --orbit-height-km, --body and --opposite; the look
/// angles have names of their own in each command.
void AddPairOptions(CLI::App* command, PairInput* input) {
  command->add_option("--base-m", input->base_m, "stereo base B");
  command->add_option("--height-m", input->height_m, "flying height H");
  command->add_option("--ground-range-m",
                      input->ground_range_m,
                      "ground distance y of the point from the nadir line of station '");
  command->add_option("--orbit-height-km", input->orbit_height_km, "height of both orbits");
  std::map<std::string, int> bodies;
  for (std::size_t i = 0; i < kBodies.size(); ++i) bodies[kBodies[i].name] = static_cast<int>(i);
  command->add_option("--body", input->body, "body below the orbits")->transform(ChoiceOf(bodies));
  command->add_flag_callback(
      "--opposite",
      [input] { input->arrangement = Arrangement::kOppositeSide; },
      "opposite-side stereo: the point lies between the stations");
}

/// Whether two look angles alone, without a height, make a pair.
enum class HeightNeed { kOptional, kRequired };
/// Throws CLI::ValidationError unless the options name a pair in one of the ways.
void RequireOnePair(const char* command, HeightNeed height, const PairInput& input) {
  const bool base = input.base_m && input.height_m && input.ground_range_m;
  const bool some_base = input.base_m || input.ground_range_m;
  const bool looks = input.first_look_deg && input.second_look_deg;
  const bool some_look = input.first_look_deg || input.second_look_deg;
  const bool orbit = input.orbit_height_km && input.body;
  const bool some_orbit = input.orbit_height_km || input.body;
  const bool by_base = base && !some_look && !some_orbit;
  const bool from_height = some_orbit
                               ? orbit && !input.height_m
                               : height == HeightNeed::kOptional || input.height_m.has_value();
  if (by_base || (looks && !some_base && from_height)) return;
  const auto [first, second] = input.look_names;
  const std::string both = std::string(first) == second ? std::string(first) + " twice"
                                                        : fmt::format("{} and {}", first, second);
  throw CLI::ValidationError(
      command,
      fmt::format("the pair is given by --base-m, --height-m and --ground-range-m, or by {}, {}"
                  "with --height-m, or with --orbit-height-km and --body",
                  both,
                  height == HeightNeed::kOptional ? "alone, " : ""));
}

/// Throws InputError naming the option whose value no pair has.
GivenPair PairOf(const PairInput& input) {
  if (input.base_m) return PairOfBase(input);
  GivenPair pair;
  pair.arrangement = input.arrangement;
  const std::array looks_deg{input.first_look_deg.value(), input.second_look_deg.value()};
  for (std::size_t k = 0; k < 2; ++k) {
    pair.look_rad[k] = CheckedLook(input.look_names[k], looks_deg[k]);
  }
  if (pair.arrangement == Arrangement::kSameSide && pair.look_rad[0] == pair.look_rad[1]) {
    const auto [first, second] = input.look_names;
    throw InputError(second,
                     std::string(first) == second
                         ? "is the same angle twice: no base, two different ones are allowed"
                         : fmt::format("equals {}: no base, another angle is allowed", first));
  }
  pair.incidence_rad = pair.look_rad;
  if (input.height_m) pair.height_m = CheckedPositive("--height-m", *input.height_m, " m");
  if (!input.orbit_height_km) return pair;
  pair.height_m = 1e3 * CheckedPositive("--orbit-height-km", *input.orbit_height_km, " km");
  pair.body_radius_m =
      NamedEllipsoid(kBodies.at(static_cast<std::size_t>(input.body.value())).ellipsoid).a_m;
  for (std::size_t k = 0; k < 2; ++k) {
    pair.incidence_rad[k] =
        CheckedIncidence(input.look_names[k], pair.look_rad[k], *pair.height_m, pair.body_radius_m);
  }
  return pair;
}
}  // namespace

// ---- plan pair

namespace {

struct PlanPairInput {
  PairInput pair;
  std::vector<double> looks_deg;
  std::optional<double> range_sigma_m, azimuth_sigma_m, path_sigma_m, goal_up_m;
  /// In place of the first two: images, and the options that describe them.
  SceneImage image;
  std::optional<double> bandwidth_mhz, snr_incidence_deg;
  std::vector<const CLI::Option*> image_options;

  [[nodiscard]] bool images() const {
    return std::any_of(image_options.begin(), image_options.end(), [](const CLI::Option* option) {
      return option->count() > 0;
    });
  }
  /// The wanted standard deviation of heights, checked.
  [[nodiscard]] std::optional<double> GoalUp_m() const {
    if (!goal_up_m) return std::nullopt;
    return CheckedPositive("--goal-up-m", *goal_up_m, " m");
  }
};

/// What is printed of a pair.
struct PlannedPair {
  GivenPair given;
  PairAccuracy accuracy;
  bool along = false;  ///< whether the standard deviation along track is known
  leberl::ViewingGuidance viewing;
  double exaggeration = 0.0;
  SlopeLimits slopes;
  PairSigmas sigmas;
  std::optional<SecondLooks> second;  ///< that reach a goal which the pair misses
  std::optional<BestLook> best;       ///< of images
};

/// Standard deviations of two images of level ground that are matched.
PairSigmas SigmasOfImages(const SceneImage& image, double path_m, const StereoPair& pair) {
  std::array<ImageView, 2> views;
  for (std::size_t k = 0; k < 2; ++k) {
    const bool opposite = k == 1 && pair.arrangement == Arrangement::kOppositeSide;
    views[k].local_incidence_rad =
        IncidenceAngle(pair.look_rad[k], pair.height_m, pair.body_radius_m);
    views[k].parallax[0] = (opposite ? -1.0 : 1.0) / std::tan(views[k].local_incidence_rad);
  }
  PairSigmas out;
  out.path_m = path_m;
  for (std::size_t k = 0; k < 2; ++k) {
    const ImageSigma sigma = SigmaOfMatch(image, views[k], views[1 - k]);
    out.range_m[k] = sigma.range_m;
    out.azimuth_m[k] = sigma.azimuth_m;
  }
  return out;
}

/// What the options say of the sigmas, which for images depend on the pair.
std::function<PairSigmas(const StereoPair&)> SigmasGiven(const PlanPairInput& input) {
  const double path_m =
      input.path_sigma_m ? CheckedPositive("--path-sigma-m", *input.path_sigma_m, " m") : 0.0;
  if (input.images()) {
    SceneImage image = input.image;
    if (input.bandwidth_mhz) image.bandwidth_hz = 1e6 * *input.bandwidth_mhz;
    if (input.snr_incidence_deg) image.snr_incidence_rad = *input.snr_incidence_deg * kRadPerDeg;
    if (const auto problem = FindImageProblem(image)) {
      std::string option = "--" + problem->field;
      std::replace(option.begin(), option.end(), '_', '-');
      throw InputError(option, problem->problem);
    }
    return [image, path_m](const StereoPair& pair) { return SigmasOfImages(image, path_m, pair); };
  }
  const double range_m = CheckedPositive("--range-sigma-m", input.range_sigma_m.value(), " m");
  // Azimuth decides the position along the parallel tracks alone, which is then not printed.
  const double azimuth_m = input.azimuth_sigma_m
                               ? CheckedPositive("--azimuth-sigma-m", *input.azimuth_sigma_m, " m")
                               : range_m;
  return [=](const StereoPair&) {
    return PairSigmas{{range_m, range_m}, {azimuth_m, azimuth_m}, path_m};
  };
}

PlannedPair PlanOf(const PlanPairInput& input) {
  PlannedPair plan;
  plan.given = PairOf(input.pair);
  const std::optional<double> goal_up_m = input.GoalUp_m();
  plan.along = input.images() || input.azimuth_sigma_m.has_value();
  const auto sigmas_of = SigmasGiven(input);
  const StereoPair pair{plan.given.look_rad,
                        plan.given.height_m.value(),
                        plan.given.body_radius_m,
                        plan.given.arrangement};
  plan.sigmas = sigmas_of(pair);
  const auto accuracy = AccuracyOf(pair, plan.sigmas);
  if (!accuracy) {
    throw UndeterminedError("the two looks do not determine a point: their circles touch", {});
  }
  plan.accuracy = *accuracy;
  const auto [first_rad, second_rad] = plan.given.incidence_rad;
  plan.viewing = leberl::CheckViewing(first_rad, second_rad, pair.arrangement);
  plan.exaggeration = leberl::ExaggerationFromAngles(first_rad, second_rad, pair.arrangement);
  plan.slopes = SlopesShown(plan.given.incidence_rad, pair.arrangement);
  // Reflectors are seen alike at any angle: a wider one is always better.
  if (input.images() && !std::isnan(input.image.window_m)) {
    plan.best = BestSecondLook(pair, sigmas_of);
  }
  if (goal_up_m && !input.images() && accuracy->all.up_m > *goal_up_m &&
      pair.arrangement == Arrangement::kSameSide) {
    plan.second = SecondLooksFor(pair, plan.sigmas, *goal_up_m);
  }
  return plan;
}

Json SigmasJson(const PointSigmas& sigmas, bool along) {
  return {{"along_m", along ? Json(sigmas.along_m) : Json()},
          {"across_m", sigmas.across_m},
          {"up_m", sigmas.up_m}};
}

Json AnglesJson(const std::array<double, 2>& angles_rad) {
  return {angles_rad[0] * kDegPerRad, angles_rad[1] * kDegPerRad};
}

Json PlanJson(const PlanPairInput& input, const PlannedPair& plan) {
  const auto degrees = [](const std::optional<double>& angle_rad) {
    return angle_rad ? Json(*angle_rad * kDegPerRad) : Json();
  };
  Json json = {
      {"format", "sarblock-pair 1"},
      {"height_m", *plan.given.height_m},
      {"look_deg", AnglesJson(plan.given.look_rad)},
      {"incidence_deg", AnglesJson(plan.given.incidence_rad)},
      {"range_m", plan.accuracy.range_m},
      {"intersection_deg", plan.accuracy.intersection_rad * kDegPerRad},
      {"range_sigma_m", plan.sigmas.range_m},
      {"azimuth_sigma_m", plan.along ? Json(plan.sigmas.azimuth_m) : Json()},
      {"sigma", SigmasJson(plan.accuracy.all, plan.along)},
      {"sigma_measured", SigmasJson(plan.accuracy.measured, plan.along)},
      {"sigma_paths", input.path_sigma_m ? SigmasJson(plan.accuracy.paths, true) : Json()},
      {"exaggeration", plan.exaggeration},
      {"looks_within_37_and_67_deg", plan.viewing.looks_within_37_and_67_deg},
      {"looks_not_below_40_deg", plan.viewing.looks_not_below_40_deg},
      {"intersection_within_12_and_15_deg", plan.viewing.intersection_within_12_and_15_deg},
      {"slope_facing_first_deg", plan.slopes.facing_first_rad * kDegPerRad},
      {"slope_facing_away_deg", plan.slopes.facing_away_rad * kDegPerRad}};
  if (input.goal_up_m) {
    json["goal_up_m"] = *input.goal_up_m;
    json["goal_reached"] = plan.accuracy.all.up_m <= *input.goal_up_m;
  }
  if (plan.best) {
    json["best_second_look_deg"] = plan.best->look_rad * kDegPerRad;
    json["best_sigma_up_m"] = plan.best->sigma_up_m;
  }
  if (plan.second) {
    json["second_look_below_deg"] = degrees(plan.second->below);
    json["second_look_above_deg"] = degrees(plan.second->above);
  }
  return json;
}

std::string SigmaRow(const char* name, const PointSigmas& sigmas, bool along) {
  return fmt::format("{:<26}{:>12}{:>12.4g}{:>12.4g}\n",
                     name,
                     along ? fmt::format("{:.4g}", sigmas.along_m) : "-",
                     sigmas.across_m,
                     sigmas.up_m);
}

/// What the goal of the height asks for.
std::string GoalText(const PlanPairInput& input, const PlannedPair& plan) {
  const double up_m = plan.accuracy.all.up_m;
  if (up_m <= *input.goal_up_m) {
    return fmt::format("sigma up {:.4g} m, goal {:g} m: reached\n", up_m, *input.goal_up_m);
  }
  std::string text = fmt::format("sigma up {:.4g} m, goal {:g} m: missed", up_m, *input.goal_up_m);
  if (plan.best) {
    const bool reaches = plan.best->sigma_up_m <= *input.goal_up_m;
    return text +
           (reaches ? "; the best second look reaches it\n" : "; no second look reaches it\n");
  }
  if (!plan.second) return text + "\n";
  const auto& [below, above] = *plan.second;
  if (!below && !above) return text + "; no second look reaches it\n";
  text += "; reached by a second look";
  if (below) text += fmt::format(" of {:.2f} deg or less", *below * kDegPerRad);
  if (below && above) text += ", or";
  if (above) text += fmt::format(" of {:.2f} deg or more", *above * kDegPerRad);
  return text + "\n";
}

std::string PlanText(const PlanPairInput& input, const PlannedPair& plan) {
  const bool same = plan.given.arrangement == Arrangement::kSameSide;
  const auto [look_1, look_2] = plan.given.look_rad;
  const auto [incidence_1, incidence_2] = plan.given.incidence_rad;
  const auto deg = [](double angle_rad) { return angle_rad * kDegPerRad; };
  std::string text =
      fmt::format("{}, looks of {:.4g} and {:.4g} deg {}\n",
                  input.pair.orbit_height_km
                      ? fmt::format("orbits {:g} km above {}",
                                    *input.pair.orbit_height_km,
                                    kBodies.at(static_cast<std::size_t>(*input.pair.body)).name)
                      : fmt::format("flights {:g} m above the ground", *plan.given.height_m),
                  deg(look_1),
                  deg(look_2),
                  same ? "on one side" : "from opposite sides");
  text += fmt::format("{:<26}{:>12.2f} deg   incidence {:.2f} and {:.2f} deg\n",
                      "angle of intersection",
                      deg(plan.accuracy.intersection_rad),
                      deg(incidence_1),
                      deg(incidence_2));
  text += fmt::format("{:<26}{:>12.5g} and {:.5g} km\n",
                      "slant ranges",
                      1e-3 * plan.accuracy.range_m[0],
                      1e-3 * plan.accuracy.range_m[1]);
  if (input.images()) {
    text += fmt::format("{:<26}{:>12.3g} and {:.3g} m, azimuths {:.3g} and {:.3g} m\n",
                        "sigma of the ranges",
                        plan.sigmas.range_m[0],
                        plan.sigmas.range_m[1],
                        plan.sigmas.azimuth_m[0],
                        plan.sigmas.azimuth_m[1]);
  }
  text +=
      fmt::format("{:<26}{:>12}{:>12}{:>12}\n", "sigma of the point [m]", "along", "across", "up");
  if (input.path_sigma_m) {
    text += SigmaRow("  by range and azimuth", plan.accuracy.measured, plan.along);
    text += SigmaRow("  by the flight paths", plan.accuracy.paths, true);
  }
  text += SigmaRow(
      input.path_sigma_m ? "  all" : "  paths known exactly", plan.accuracy.all, plan.along);
  if (plan.best) {
    text += fmt::format("{:<26}{:>12.2f} deg: sigma up {:.4g} m\n",
                        "best second look",
                        deg(plan.best->look_rad),
                        plan.best->sigma_up_m);
  }
  if (input.goal_up_m) text += GoalText(input, plan);
  const auto kept = [](bool yes) { return yes ? "kept" : "not kept"; };
  text += fmt::format("vertical exaggeration q         about {:.2g} (Leberl (1979), Eq. 10)\n",
                      plan.exaggeration);
  text += fmt::format(
      "viewing: angles of 37 to 67 deg {}, not below 40 deg {},\n"
      "    intersection of about 12 to 15 deg {}\n",
      kept(plan.viewing.looks_within_37_and_67_deg),
      kept(plan.viewing.looks_not_below_40_deg),
      kept(plan.viewing.intersection_within_12_and_15_deg));
  text += fmt::format(
      "slopes that both images show: facing {} up to {:.1f} deg, facing away\n"
      "    up to {:.1f} deg; steeper ones are lost to layover or shadow\n",
      same ? "the antennas" : "the first antenna",
      deg(plan.slopes.facing_first_rad),
      deg(plan.slopes.facing_away_rad));
  return text;
}

int RunPlanPair(const PlanPairInput& input, const Session& session) {
  const PlannedPair plan = PlanOf(input);
  if (session.json) {
    fmt::print("{}\n", PlanJson(input, plan).dump(2));
  } else {
    session.Print(PlanText(input, plan));
  }
  return kAccepted;
}

/// Images in place of standard deviations.
void AddImageOptions(CLI::App* command, PlanPairInput* input) {
  const auto add = [&](const char* name, auto* value, const char* help) {
    input->image_options.push_back(
        command->add_option(name, *value, std::string("images: ") + help));
  };
  SceneImage* image = &input->image;
  add("--bandwidth-mhz",
      &input->bandwidth_mhz,
      "bandwidth of the pulse, for images in place of standard deviations");
  add("--azimuth-resolution-m", &image->azimuth_resolution_m, "resolution along track");
  add("--snr-db",
      &image->snr_db,
      "signal over noise of the ground at --snr-incidence-deg; without --window-m signal over "
      "clutter of reflectors");
  add("--snr-incidence-deg", &input->snr_incidence_deg, "incidence of that ratio (default 35)");
  add("--backscatter-exponent",
      &image->backscatter_exponent,
      "backscatter falls as cos^n of the incidence (default 2)");
  add("--window-m",
      &image->window_m,
      "side of a matched window on the ground (default: reflectors)");
  add("--correlation", &image->correlation, "of windows seen alike, without noise (default 0.15)");
  add("--slope-rms", &image->slope_rms, "slope of the relief within a window (default 0)");
}

void RequireSigmasOrImages(const PlanPairInput& input) {
  const bool sigmas = input.range_sigma_m || input.azimuth_sigma_m;
  if (input.images() ? !sigmas : input.range_sigma_m.has_value()) return;
  throw CLI::ValidationError("pair",
                             "accuracies are given by --range-sigma-m (and --azimuth-sigma-m), "
                             "or by --bandwidth-mhz, --azimuth-resolution-m and --snr-db");
}

}  // namespace

void AddPlan(CLI::App* app, Session* session) {
  CLI::App* plan = app->add_subcommand("plan", "What a planned stereo pair will give");
  plan->require_subcommand(1);
  const auto input = std::make_shared<PlanPairInput>();
  input->pair.look_names = {"--look", "--look"};
  CLI::App* command = plan->add_subcommand(
      "pair", "Accuracy, viewing and lost slopes of a stereo pair, in one command");
  command->add_option("--look", input->looks_deg, "look angle off nadir [deg]; twice")
      ->allow_extra_args(false);
  AddPairOptions(command, &input->pair);
  command->add_option(
      "--range-sigma-m", input->range_sigma_m, "standard deviation of each slant range");
  command->add_option("--azimuth-sigma-m",
                      input->azimuth_sigma_m,
                      "standard deviation of each azimuth, along track at the target");
  AddImageOptions(command, input.get());
  command->add_option("--path-sigma-m",
                      input->path_sigma_m,
                      "standard deviation of each flight path along, across and up");
  command->add_option("--goal-up-m",
                      input->goal_up_m,
                      "wanted standard deviation of heights; names the looks that reach it");
  command->callback([session, input] {
    if (input->looks_deg.size() > 2) {
      throw CLI::ValidationError("--look", "two look angles are allowed");
    }
    if (!input->looks_deg.empty()) input->pair.first_look_deg = input->looks_deg.front();
    if (input->looks_deg.size() == 2) input->pair.second_look_deg = input->looks_deg.back();
    RequireOnePair("pair", HeightNeed::kRequired, input->pair);
    RequireSigmasOrImages(*input);
    session->run = [session, input] { return RunPlanPair(*input, *session); };
  });
}

// ---- leberl exaggeration and figures

namespace {

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

/// What Validate() refuses by field is said by option and in its unit.
std::optional<leberl::StereoViewing> ViewingOf(const ExaggerationInput& input) {
  if (!input.viewing_scale) return std::nullopt;
  leberl::StereoViewing viewing;
  viewing.scale = CheckedPositive("--viewing-scale", *input.viewing_scale, "");
  viewing.eye_base_m = 1e-3 * CheckedPositive("--eye-base-mm", input.eye_base_mm, " mm");
  viewing.acuity_rad =
      kRadPerArcsecond * CheckedPositive("--acuity-arcsec", input.acuity_arcsec, " arcsec");
  viewing.fusion_rad = kRadPerArcminute * input.fusion_arcmin;
  if (!(viewing.fusion_rad > viewing.acuity_rad && viewing.fusion_rad < leberl::kMaxFusion_rad)) {
    throw InputError("--fusion-arcmin",
                     fmt::format("{:g} arcmin is given, more than --acuity-arcsec ({:g} arcmin) "
                                 "and less than {:g} arcmin is allowed",
                                 input.fusion_arcmin,
                                 input.acuity_arcsec / 60.0,
                                 leberl::kMaxFusion_rad / kRadPerArcminute));
  }
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
