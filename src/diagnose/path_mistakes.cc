// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "block/plausibility.h"
#include "core/text.h"
#include "geometry/recorded_states.h"
#include "mistakes.h"
#include "sample.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

using Names = std::vector<std::string>;

constexpr double kSecondsOfDay = 86400.0;
constexpr double kTurn_rad = 2.0 * std::numbers::pi;

/// Sidereal rotation of the named bodies, rad/s.
const std::vector<KnownNumber>& Rotations() {
  static const std::vector<KnownNumber> rates{
      {7.2921159e-5, "the rotation of the Earth"},
      {kTurn_rad / (27.321661 * kSecondsOfDay), "the rotation of the Moon"},
      {7.0882181e-5, "the rotation of Mars"},
      {-kTurn_rad / (243.0185 * kSecondsOfDay), "the rotation of Venus"}};
  return rates;
}

/// That of the body whose radius is the nearest to the frame's.
double RotationOf(const Frame& frame) {
  static constexpr std::array<double, 4> kRadii_m{6378137.0, 1737400.0, 3396190.0, 6051800.0};
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < kRadii_m.size(); ++i) {
    const double a_m = frame.ellipsoid().a_m;
    if (std::abs(a_m - kRadii_m[i]) < std::abs(a_m - kRadii_m[nearest])) nearest = i;
  }
  return Rotations()[nearest].value;
}

using Edit = std::function<void(StateVector*, double value)>;

Hypothesis EditedStates(const Names& passes, std::string cause, Edit edit) {
  Hypothesis out;
  out.kind = MistakeKind::kPath;
  out.cause = std::move(cause);
  out.passes = passes;
  out.undo = [passes, edit = std::move(edit)](Block* block, double value) {
    for (const std::uint32_t p : PassesOf(*block, passes)) {
      EditStates([&](StateVector* state) { edit(state, value); }, p, block);
    }
  };
  return out;
}

Hypothesis ScaledStates(const Names& passes, bool positions, bool velocities, double factor) {
  Hypothesis out = EditedStates(passes, "path.unit", [=](StateVector* state, double value) {
    if (positions) state->position_m /= value;
    if (velocities) state->velocity_mps /= value;
  });
  const std::string what = positions && velocities ? "positions and velocities"
                           : positions             ? "positions"
                                                   : "velocities";
  const std::string unit = factor == 1e-3  ? (positions ? "kilometres" : "kilometres per second")
                           : factor == 1e3 ? (positions ? "millimetres" : "millimetres per second")
                                           : "of the wrong sign";
  if (factor < 0.0) out.cause = "path.velocity_sign";
  out.value = factor;
  out.parameters = 0;
  out.unit = "1";
  out.says = [=](const Size&) {
    return "the " + what + " of " + PassWords(passes) + " are " +
           (factor < 0.0 ? unit : "in " + unit);
  };
  out.change = [=](const Size&) {
    return "trajectories.csv: " + what + " " + PassesPhrase(passes) + " divided by " +
           InFiles(factor);
  };
  return out;
}

/// Estimates how fast the axes turn, from `rate` on.
void EstimateTurning(double rate, Hypothesis* out) {
  out->free = true;
  out->value = rate;
  out->step = 1e-3 * std::abs(rate);
  out->unit = "rad/s";
  out->numbers = Rotations();
}

/// From axes that do not turn, aligned with the body's at `aligned_s`, to the body's.
void ToBodyFixed(double rate, double aligned_s, StateVector* state) {
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  const Eigen::AngleAxisd back(-rate * (state->time_s - aligned_s), axis);
  state->position_m = back * state->position_m;
  state->velocity_mps = back * state->velocity_mps - rate * axis.cross(state->position_m);
}

/// What ToBodyFixed() does, for readers.
std::string BodyFixedWords(const Names& passes, const std::string& rate, const std::string& at_s) {
  return "trajectories.csv: body-fixed positions and velocities " + PassesPhrase(passes) +
         ": both turned about z by -w * (time_s - " + at_s +
         ") rad, then velocities minus w * (-y_m, x_m, 0), w = " + rate + " rad/s";
}

/// Inertial axes that are aligned with the body's at time 0; how fast the body turns is estimated.
Hypothesis InertialStates(const Names& passes, double rate) {
  Hypothesis out = EditedStates(passes, "path.inertial", [](StateVector* state, double value) {
    ToBodyFixed(value, 0.0, state);
  });
  EstimateTurning(rate, &out);
  out.says = [passes](const Size& size) {
    return "the states of " + PassWords(passes) +
           " are in inertial axes, not in those of the turning body: rate " + size.text;
  };
  out.change = [passes](const Size& size) {
    return BodyFixedWords(passes, InFiles(size.value, size.sigma), "0");
  };
  return out;
}

/// The time, within half a turn of time 0, at which inertial axes have to be those of the body for
/// a look of a pass alone to see a known point: its range leaves two, its cone chooses. NaN where
/// the range does not reach.
double AlignedTimeOf(const Block& of_pass,
                     const PredictedLook& look,
                     double rate,
                     const Eigen::Vector3d& p_m) {
  Motion at;
  if (!of_pass.passes[0].path.Evaluate(look.time_s, &at)) return kNotGiven;
  const Eigen::Vector3d& x_m = at.position_m;
  const double squares = x_m.squaredNorm() + p_m.squaredNorm() - look.range_m * look.range_m;
  const double radii = std::hypot(x_m.x(), x_m.y()) * std::hypot(p_m.x(), p_m.y());
  const double cosine = (0.5 * squares - x_m.z() * p_m.z()) / radii;
  if (!(std::abs(cosine) < 1.0)) return kNotGiven;
  double best_s = kNotGiven, least = std::numeric_limits<double>::infinity();
  for (const double apart_rad : {std::acos(cosine), -std::acos(cosine)}) {
    // From the longitude that the antenna had to the one in inertial axes.
    const double turned_rad =
        std::atan2(x_m.y(), x_m.x()) - std::atan2(p_m.y(), p_m.x()) - apart_rad;
    const double aligned_s = std::remainder(rate * look.time_s - turned_rad, kTurn_rad) / rate;
    StateVector state;
    state.time_s = look.time_s;
    state.position_m = x_m;
    state.velocity_mps = at.velocity_mps;
    ToBodyFixed(rate, aligned_s, &state);
    const Eigen::Vector3d los_m = p_m - state.position_m;
    const double speed_mps = state.velocity_mps.norm();
    const double ahead = std::abs(state.velocity_mps.dot(los_m) / (speed_mps * los_m.norm()) -
                                  of_pass.ConeOf(look.look).Sine(speed_mps));
    if (ahead < least) std::tie(least, best_s) = std::pair(ahead, aligned_s);
  }
  return best_s;
}

/// Inertial axes that the motion shows, aligned with the body's at a time that known points tell.
Hypothesis InertialAxes(const Facts& facts,
                        const Names& passes,
                        double rate,
                        const InertialMotion& motion) {
  Hypothesis out = EditedStates(passes, "path.inertial", [rate](StateVector* state, double value) {
    ToBodyFixed(rate, value, state);
  });
  std::vector<double> aligned_s;
  for (const std::uint32_t pass : PassesOf(facts.sample.block, passes)) {
    const PassPredictions& known = facts.passes[pass];
    std::uint32_t point = 0;
    for (const PredictedLook& look : known.predictions) {
      while (known.part.looks.offsets[point + 1] <= look.look) ++point;
      const double time_s = AlignedTimeOf(known.part, look, rate, known.part.points.given_m[point]);
      if (!std::isnan(time_s)) aligned_s.push_back(time_s);
    }
  }
  // Times near half a turn may come out on either end of it.
  for (double& time_s : aligned_s) {
    const double turn_s = kTurn_rad / std::abs(rate);
    time_s = aligned_s.front() + std::remainder(time_s - aligned_s.front(), turn_s);
  }
  out.unit = "s";
  out.free = !aligned_s.empty();
  out.parameters = out.free ? 1 : 0;
  if (out.free) {
    out.value = Median(std::move(aligned_s));
    out.step =
        1.0 / (std::abs(rate) * facts.sample.block.frame.ellipsoid().a_m);  // 1 m on the ground
  }
  out.says = [passes, motion, free = out.free](const Size& size) {
    return "the states of " + PassWords(passes) +
           " are in inertial axes, not in those of the turning body (gravity leaves " +
           Digits(motion.in_fixed_axes_mps2, 2) +
           " m/s^2 of their acceleration unexplained there, " +
           Digits(motion.in_turning_axes_mps2, 2) + " m/s^2 in turning axes)" +
           (free ? ": both axes are the same at " + size.text : "");
  };
  out.change = [passes, rate, free = out.free](const Size& size) {
    return BodyFixedWords(
        passes, InFiles(rate), free ? InFiles(size.value, size.sigma) : "time of equal axes");
  };
  out.screened = true;
  out.order = Hypothesis::kCertain;
  return out;
}

Hypothesis InertialVelocities(const Names& passes, double rate) {
  Hypothesis out =
      EditedStates(passes, "path.inertial_velocity", [](StateVector* state, double value) {
        state->velocity_mps -= value * Eigen::Vector3d::UnitZ().cross(state->position_m);
      });
  EstimateTurning(rate, &out);
  out.says = [passes](const Size& size) {
    return "the velocities of " + PassWords(passes) +
           " are inertial, the positions body-fixed: rate " + size.text;
  };
  out.change = [passes](const Size& size) {
    return "trajectories.csv: velocities " + PassesPhrase(passes) +
           " minus w * (-y_m, x_m, 0), w = " + InFiles(size.value, size.sigma) +
           " rad/s, or through = \"positions\" in [trajectory]";
  };
  return out;
}

/// Velocities given over velocities of the positions, and the turning that would explain them.
struct VelocityFacts {
  double ratio = 1.0;           ///< median of the projection on the motion
  double rate_rad_per_s = 0.0;  ///< of given less moved, about the axis of the body
};

VelocityFacts VelocitiesOf(const Pass& pass) {
  const std::vector<StateVector>& states = pass.RecordedStates();
  std::vector<double> ratio, rate;
  // From end to end of pieces: between dense states noise of the positions is a speed of its own.
  const std::size_t stride = 1 + states.size() / 200;
  for (std::size_t i = stride; i < states.size(); i += stride) {
    const StateVector &a = states[i - stride], &b = states[i];
    const Eigen::Vector3d moved = (b.position_m - a.position_m) / (b.time_s - a.time_s);
    Eigen::Vector3d said = Eigen::Vector3d::Zero();
    for (std::size_t k = i - stride; k < i; ++k) {
      const double part = (states[k + 1].time_s - states[k].time_s) / (b.time_s - a.time_s);
      said += 0.5 * part * (states[k].velocity_mps + states[k + 1].velocity_mps);
    }
    const Eigen::Vector3d turned = Eigen::Vector3d::UnitZ().cross(a.position_m);
    if (moved.squaredNorm() > 0.0) ratio.push_back(said.dot(moved) / moved.squaredNorm());
    if (turned.squaredNorm() > 0.0) {
      rate.push_back((said - moved).dot(turned) / turned.squaredNorm());
    }
  }
  if (ratio.empty()) return {};
  return {Median(std::move(ratio)), rate.empty() ? 0.0 : Median(std::move(rate))};
}

Hypothesis ExchangedPasses(const std::string& a, const std::string& b) {
  Hypothesis out;
  out.kind = MistakeKind::kPath;
  out.cause = "path.exchanged";
  out.passes = {a, b};
  out.parameters = 0;
  out.undo = [a, b](Block* block, double) {
    const auto i = FindPass(*block, a), j = FindPass(*block, b);
    if (!i || !j) return;
    std::swap(block->passes[*i].path, block->passes[*j].path);
    std::swap(block->passes[*i].recorded, block->passes[*j].recorded);
  };
  out.says = [a, b](const Size&) {
    return "the flight paths of passes " + a + " and " + b + " have each other's names";
  };
  out.change = [a, b](const Size&) {
    return "trajectories.csv: exchange the names " + a + " and " + b;
  };
  out.screened = true;
  return out;
}

/// Pairs that see the known points much better with each other's paths.
void AddExchangedPaths(const Facts& facts, Hypotheses* out) {
  const std::size_t count = facts.passes.size();
  for (std::size_t i = 0; i < count; ++i) {
    const PassPredictions& a = facts.passes[i];
    for (std::size_t j = i + 1; j < count; ++j) {
      const PassPredictions& b = facts.passes[j];
      const Pass &pass_a = facts.sample.block.passes[i], &pass_b = facts.sample.block.passes[j];
      const auto with = [](const PassPredictions& sees, const Pass& path) {
        Block part = sees.part;
        part.passes[0].path = path.path;
        return MisfitOf(part);
      };
      if (a.predictions.empty() || b.predictions.empty()) {
        if (count <= 6) out->push_back(ExchangedPasses(pass_a.id, pass_b.id));
        continue;
      }
      const double kept_part = std::max(with(a, pass_b) / a.misfit_m, with(b, pass_a) / b.misfit_m);
      if (kept_part < 0.3) {
        out->push_back(ExchangedPasses(pass_a.id, pass_b.id));
        out->back().order = Hypothesis::kReported * kept_part;
      }
    }
  }
}

Hypothesis OtherReading(const Names& passes, const std::string& why, const char* cause) {
  Hypothesis out;
  out.kind = MistakeKind::kPath;
  out.cause = cause;
  out.passes = passes;
  out.parameters = 0;
  out.undo = [passes](Block* block, double) { ReadWithAuto(passes, block); };
  out.says = [passes, why](const Size&) {
    return "the states of " + PassWords(passes) + " " + why;
  };
  out.change = [passes](const Size&) {
    return "block.toml: [trajectory] through = \"auto\", or other states " + PassesPhrase(passes) +
           " in trajectories.csv";
  };
  out.screened = true;
  return out;
}

/// What velocities and positions show without a solution: for all passes if it shows in all, else
/// for those in which it does.
void AddVelocities(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  std::vector<VelocityFacts> velocities;
  for (const Pass& pass : block.passes) velocities.push_back(VelocitiesOf(pass));
  const auto add = [&](const auto& shows, const auto& hypothesis) {
    std::vector<Names> scopes;
    for (std::size_t p = 0; p < velocities.size(); ++p) {
      if (shows(velocities[p])) scopes.push_back({block.passes[p].id});
    }
    if (scopes.size() > 1 && scopes.size() == velocities.size()) scopes = {{}};
    for (const Names& passes : scopes) {
      out->push_back(hypothesis(passes));
      out->back().screened = true;
      out->back().order = Hypothesis::kReported;
    }
  };
  for (const double factor : {-1.0, 1e-3, 1e3}) {
    const auto shows = [factor](const VelocityFacts& velocity) {
      return std::abs(velocity.ratio / factor - 1.0) < 0.1;
    };
    add(shows, [&](const Names& passes) { return ScaledStates(passes, false, true, factor); });
    if (factor != 1e3) continue;
    add(shows, [](const Names& passes) { return ScaledStates(passes, true, false, 1e-3); });
  }
  if (block.frame.kind() != FrameKind::kGeocentric) return;
  const double rate = RotationOf(block.frame);
  const auto turns = [rate](const VelocityFacts& velocity) {
    return std::abs(velocity.rate_rad_per_s / rate - 1.0) < 0.5;
  };
  add(turns, [rate](const Names& passes) { return InertialVelocities(passes, rate); });
}

/// Satellites whose motion shows that their axes do not turn: all passes together where it is that
/// of all. Returns the passes.
Names AddInertialMotions(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  Names found;
  InertialMotion worst{0.0, std::numeric_limits<double>::infinity()};
  for (const Pass& pass : block.passes) {
    const auto motion = InertialMotionOf(block, pass);
    if (!motion) continue;
    found.push_back(pass.id);
    worst.in_fixed_axes_mps2 = std::max(worst.in_fixed_axes_mps2, motion->in_fixed_axes_mps2);
    worst.in_turning_axes_mps2 = std::min(worst.in_turning_axes_mps2, motion->in_turning_axes_mps2);
  }
  if (found.empty()) return found;
  const bool all = found.size() == block.passes.size();
  const double rate = FindBody(block.frame.ellipsoid().name)->rotation;
  out->push_back(InertialAxes(facts, all ? Names{} : found, rate, worst));
  return found;
}

/// Mistakes of positions and velocities alike, which known points show.
void AddWholeStates(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  const Names inertial = AddInertialMotions(facts, out);
  std::vector<Names> scopes{{}};
  for (const Pass& pass : block.passes) scopes.push_back({pass.id});
  for (const Names& passes : scopes) {
    out->push_back(ScaledStates(passes, true, true, 1e-3));
    if (block.frame.kind() != FrameKind::kGeocentric || !inertial.empty()) continue;
    out->push_back(InertialStates(passes, RotationOf(block.frame)));
  }
}

/// Mean radius of the Earth.
constexpr double kEarth_m = 6371000.0;

/// Plan coordinates of a conformal map about a place, and heights above its curved ground.
struct MapPlane {
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  double scale = 1.0;  ///< lengths on the map over those on the ground

  /// The place in straight axes that touch the ground in the middle.
  [[nodiscard]] Eigen::Vector3d Straight(const Eigen::Vector3d& map_m) const {
    const Eigen::Vector2d plan_m = (map_m.head<2>() - middle_m) / scale;
    const double distance_m = plan_m.norm(), angle_rad = distance_m / kEarth_m;
    const double radius_m = kEarth_m + map_m.z();
    const double stretch =
        distance_m > 0.0 ? radius_m * std::sin(angle_rad) / distance_m : radius_m / kEarth_m;
    Eigen::Vector3d out;
    out << middle_m + stretch * plan_m, radius_m * std::cos(angle_rad) - kEarth_m;
    return out;
  }
  void Straighten(StateVector* state) const {
    constexpr double kStep_s = 0.1;
    const Eigen::Vector3d step_m = kStep_s * state->velocity_mps;
    const Eigen::Vector3d before_m = Straight(state->position_m - step_m);
    const Eigen::Vector3d after_m = Straight(state->position_m + step_m);
    state->velocity_mps = (after_m - before_m) / (2.0 * kStep_s);
    state->position_m = Straight(state->position_m);
  }
};

/// Scales of maps that coordinates near `x_m` may have.
std::vector<KnownNumber> MapScales(double x_m) {
  // Scale of a transverse cylinder, to second order (Snyder 1987, eq. 8-11).
  const double east = (x_m - 500000.0) / (0.9996 * kEarth_m);
  std::vector<KnownNumber> scales{{1.0, "true lengths: only the curved ground is left out"}};
  if (x_m > 100e3 && x_m < 900e3) {
    scales.insert(scales.begin(), {0.9996 * (1.0 + 0.5 * east * east), "UTM at this easting"});
  }
  return scales;
}

/// Coordinates of a map projection in a frame whose axes are straight.
void AddMapProjection(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  if (!HasMapCoordinates(block) || block.points.known.empty()) return;
  MapPlane plane;
  double count = 0.0, ground_m = 0.0, farthest_m = 0.0;
  double least_sigma_m = std::numeric_limits<double>::infinity();
  for (const KnownPosition& known : block.points.known) {
    const Eigen::Vector3d& p_m = block.points.given_m[known.point];
    if (!p_m.allFinite()) continue;
    plane.middle_m += p_m.head<2>();
    ground_m += p_m.z();
    count += 1.0;
  }
  if (count == 0.0) return;
  plane.middle_m /= count;
  ground_m /= count;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const FlightPath& path = block.passes[block.looks.pass[i]].path;
    const double height_m = path.states().front().position_m.z() - ground_m;
    const double square_m2 = std::pow(block.looks.range_m[i], 2) - height_m * height_m;
    farthest_m = std::fmax(farthest_m, std::sqrt(square_m2));
  }
  for (const Pass& pass : block.passes) {
    if (pass.sigma.range_m > 0.0) least_sigma_m = std::min(least_sigma_m, pass.sigma.range_m);
  }
  const double curved_m = farthest_m * farthest_m / (2.0 * kEarth_m);
  if (!(curved_m > least_sigma_m)) return;
  Hypothesis hypothesis;
  hypothesis.kind = MistakeKind::kPath;
  hypothesis.cause = "frame.projection";
  hypothesis.undo = [plane](Block* edited, double scale) {
    MapPlane map = plane;
    map.scale = scale;
    for (std::size_t p = 0; p < edited->passes.size(); ++p) {
      EditPathAsRead([&](StateVector* state) { map.Straighten(state); }, p, edited);
    }
    for (const KnownPosition& known : edited->points.known) {
      Eigen::Vector3d& p_m = edited->points.given_m[known.point];
      if (p_m.allFinite()) p_m = map.Straight(p_m);
    }
  };
  hypothesis.free = true;
  hypothesis.value = 1.0;
  hypothesis.step = 1e-5;
  hypothesis.unit = "1";
  hypothesis.numbers = MapScales(plane.middle_m.x());
  hypothesis.says = [curved_m](const Size& size) {
    return "the coordinates of paths and known points are those of a map projection of scale " +
           size.text + ", not of straight axes (the ground curves by " + Short(curved_m) +
           " m out to the farthest look)";
  };
  hypothesis.change = [](const Size&) {
    return std::string(
        "block.toml: kind = \"geocentric\" in [frame], with paths and known points of such "
        "coordinates or of latitude, longitude and height");
  };
  hypothesis.screened = true;
  hypothesis.order = Hypothesis::kScored;
  out->push_back(std::move(hypothesis));
}

/// Recordings that matter (RecordedFlight::effect) and are read as they are.
void AddRecordings(const Facts& facts, Hypotheses* out) {
  Names sparse, rough;
  for (const Pass& pass : facts.sample.block.passes) {
    const RecordingEffect& effect = pass.recorded.effect;
    if (!effect.Matters() || pass.recorded.asked.through == PathThrough::kAuto) continue;
    const double rough_m = std::hypot(effect.noise_m, effect.contradiction_m);
    (effect.interpolation_m > rough_m ? sparse : rough).push_back(pass.id);
  }
  if (!sparse.empty()) {
    out->push_back(
        OtherReading(sparse, "lie too far apart for the cubics between them", "path.sparse"));
    out->back().order = Hypothesis::kReported;
  }
  if (!rough.empty()) {
    out->push_back(OtherReading(
        rough, "are noisy: velocities and positions contradict each other", "path.rough"));
    out->back().order = Hypothesis::kReported;
  }
}

}  // namespace

void AddPathMistakes(const Facts& facts, Hypotheses* out) {
  const std::size_t first = out->size();
  AddVelocities(facts, out);
  AddWholeStates(facts, out);
  AddExchangedPaths(facts, out);
  AddRecordings(facts, out);
  const Block& block = facts.sample.block;
  for (std::size_t k = first; k < out->size(); ++k) {
    Hypothesis& hypothesis = (*out)[k];
    if (hypothesis.cause == "path.exchanged") continue;
    for (const std::uint32_t p : PassesOf(block, hypothesis.passes)) {
      const bool smooths = block.passes[p].recorded.asked.through != PathThrough::kStates;
      if (smooths || hypothesis.cause == "path.sparse" || hypothesis.cause == "path.rough") {
        hypothesis.smoothed_states += block.passes[p].RecordedStates().size();
      }
    }
  }
  AddMapProjection(facts, out);  // reads no states anew
}

namespace {

using Names = std::vector<std::string>;

enum class Coordinate { kRange, kTime };

/// Measurement error estimated as v/r, in metres or seconds, and its weight.
struct Sign {
  double time_s = 0.0, error = 0.0, weight = 0.0;
};

/// A curve along a strip: its values at the ends of pieces of equal length, straight between them
/// and constant beyond.
struct Curve {
  double start_s = 0.0, step_s = 1.0;
  std::vector<double> values;

  [[nodiscard]] double At(double time_s) const {
    const double last = static_cast<double>(values.size() - 1);
    const double place = std::clamp((time_s - start_s) / step_s, 0.0, last);
    const auto piece = static_cast<std::size_t>(std::min(place, last - 1.0));
    return std::lerp(values[piece], values[piece + 1], place - static_cast<double>(piece));
  }
};

/// Curves of passes by their ids, of root mean square 1 over all their values.
struct TrajectoryError {
  Names passes;
  std::map<std::string, Curve> curves;
  double rms = 0.0;  ///< of the curves
  int pieces = 0;    ///< of all curves
  double piece_s = 0.0;
};

/// Seconds of a standard deviation in azimuth.
double TimeSigma_s(const Block& block, std::size_t look) {
  const LookSigma sigma = block.SigmaOf(look);
  if (sigma.azimuth_unit == AzimuthUnit::kSeconds) return sigma.azimuth;
  const auto motion = block.passes[block.looks.pass[look]].path.At(block.looks.time_s[look]);
  return motion ? sigma.azimuth / motion->velocity_mps.norm() : kNotGiven;
}

/// In the order of their times.
std::vector<Sign> SignsOf(const Block& block,
                          const SampleResiduals& residuals,
                          const std::string& pass,
                          Coordinate measured) {
  constexpr double kMinRedundancy = 0.02;
  const Eigen::Index component = measured == Coordinate::kRange ? 0 : 1;
  std::vector<Sign> out;
  ForLooks(block, {pass}, [&](std::size_t i) {
    if (measured == Coordinate::kTime && block.MeasuresDoppler(i)) return;
    const double whitened_errors =
        residuals.whitened_errors(static_cast<Eigen::Index>(i), component);
    const double redundancy = residuals.redundancy(static_cast<Eigen::Index>(i), component);
    const double sigma =
        measured == Coordinate::kRange ? block.SigmaOf(i).range_m : TimeSigma_s(block, i);
    if (!std::isfinite(whitened_errors) || !std::isfinite(sigma)) return;
    if (!(redundancy > kMinRedundancy)) return;
    out.push_back({block.looks.time_s[i],
                   sigma * whitened_errors / redundancy,
                   redundancy / (sigma * sigma)});
  });
  std::sort(
      out.begin(), out.end(), [](const Sign& a, const Sign& b) { return a.time_s < b.time_s; });
  return out;
}

/// Least squares of a curve with `pieces` pieces: the square sum that is left, NaN where an end of
/// a piece has no looks beside it. The normal equations are tridiagonal: elimination downwards.
double FitCurve(const std::vector<Sign>& signs, std::size_t pieces, Curve* curve) {
  const std::size_t n = pieces + 1;
  std::vector<double> diagonal(n), beside(n), right(n);
  double square = 0.0;
  for (const Sign& sign : signs) {
    const double place = (sign.time_s - curve->start_s) / curve->step_s;
    const std::size_t k = std::min(pieces - 1, static_cast<std::size_t>(place));
    const double part = place - static_cast<double>(k);
    diagonal[k] += sign.weight * (1.0 - part) * (1.0 - part);
    beside[k] += sign.weight * (1.0 - part) * part;
    diagonal[k + 1] += sign.weight * part * part;
    right[k] += sign.weight * (1.0 - part) * sign.error;
    right[k + 1] += sign.weight * part * sign.error;
    square += sign.weight * sign.error * sign.error;
  }
  constexpr double kMinPivot = 1e-6;
  std::vector<double> pivots = diagonal;
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0) {
      const double factor = beside[k - 1] / pivots[k - 1];
      pivots[k] -= factor * beside[k - 1];
      right[k] -= factor * right[k - 1];
    }
    if (!(pivots[k] > kMinPivot * diagonal[k])) return kNotGiven;
    square -= right[k] * right[k] / pivots[k];
  }
  curve->values.assign(n, 0.0);
  for (std::size_t k = n; k-- > 0;) {
    const double known = k + 1 < n ? beside[k] * curve->values[k + 1] : 0.0;
    curve->values[k] = (right[k] - known) / pivots[k];
  }
  return square;
}

/// The curve of the number of pieces that Schwarz's criterion takes; nothing where a straight line
/// is as good.
std::optional<Curve> FindCurve(const std::vector<Sign>& signs) {
  constexpr std::size_t kMaxPieces = 24, kLooksAPiece = 2;
  /// Least decrease of -2 log L; noise reaches it with probability 1e-5.
  constexpr double kMinGain = 20.0;
  if (signs.size() < 12) return std::nullopt;
  const auto n = static_cast<double>(signs.size());
  const double span_s = signs.back().time_s - signs.front().time_s;
  if (!(span_s > 0.0)) return std::nullopt;
  std::optional<Curve> best;
  double straight_cost = 0.0, least_cost = 0.0;
  const std::size_t most = std::min(kMaxPieces, signs.size() / kLooksAPiece);
  for (std::size_t pieces = 1; pieces <= most; ++pieces) {
    Curve curve{signs.front().time_s, span_s / static_cast<double>(pieces), {}};
    const double rest = FitCurve(signs, pieces, &curve);
    if (!(rest > 0.0)) continue;
    const double cost = n * std::log(rest) + static_cast<double>(pieces + 1) * std::log(n);
    if (pieces == 1) {
      straight_cost = least_cost = cost;
    } else if (cost < least_cost) {
      least_cost = cost;
      best = std::move(curve);
    }
  }
  return straight_cost - least_cost > kMinGain ? best : std::nullopt;
}

/// The curves of some passes together, scaled to root mean square 1.
TrajectoryError Together(const std::vector<std::pair<std::string, Curve>>& curves) {
  TrajectoryError out;
  double square = 0.0, span_s = 0.0;
  for (const auto& [pass, curve] : curves) {
    out.passes.push_back(pass);
    out.pieces += static_cast<int>(curve.values.size());
    out.piece_s += curve.step_s / static_cast<double>(curves.size());
    for (std::size_t k = 1; k < curve.values.size(); ++k) {
      const double a = curve.values[k - 1], b = curve.values[k];
      square += curve.step_s * (a * a + a * b + b * b) / 3.0;
      span_s += curve.step_s;
    }
  }
  out.rms = std::sqrt(square / span_s);
  for (const auto& [pass, curve] : curves) {
    Curve scaled = curve;
    for (double& value : scaled.values) value /= out.rms;
    out.curves.emplace(pass, std::move(scaled));
  }
  return out;
}

/// With an error along the track of these passes that changes with time: what errors of their times
/// are, so that a solution takes all of them and no other axis or pass is in doubt.
CorrectionModel WithErrorAlongTrack(CorrectionModel model,
                                    const TrajectoryError& error,
                                    double prior_m) {
  PositionCorrection along;
  along.basis = PositionCorrection::Basis::kSpline;
  along.knot_spacing_s = error.piece_s;
  along.components = {true, false, false};
  along.prior_sigma_m[0] = {prior_m};
  for (const std::string& pass : error.passes) {  // shared: beside the pass's own
    model.groups.push_back({"diagnose.along." + pass, along, {pass}, true});
  }
  return model;
}

/// "12.3 m more, by squares, in the standard deviations of the ranges of A1"
std::string LargerSigmas(double by, bool range, const Names& passes) {
  return InFiles(by, 0.01 * by) + (range ? " m" : " s") +
         " more, by squares, in the standard deviations of the " +
         (range ? "ranges " : "azimuths ") + PassesPhrase(passes);
}

/// Looks of the passes in a block that share one error, on the average.
double LooksOfPiece(const Block& block, const TrajectoryError& error) {
  double looks = 0.0;
  ForLooks(block, error.passes, [&](std::size_t) { ++looks; });
  return std::max(1.0, looks / error.pieces);
}

/// m looks that share one error count as one look where each has sqrt(m) times its size.
Hypothesis CautiousRanges(const Block& whole, const TrajectoryError& error) {
  Hypothesis out;
  out.kind = MistakeKind::kSigma;
  const auto trajectory_error = std::make_shared<const TrajectoryError>(error);
  out.undo = [trajectory_error](Block* block, double value) {
    const double by_m = value * std::sqrt(LooksOfPiece(*block, *trajectory_error));
    for (const std::uint32_t p : PassesOf(*block, trajectory_error->passes)) {
      double& sigma_m = block->passes[p].sigma.range_m;
      sigma_m = std::hypot(sigma_m, by_m);
    }
    if (block->looks.range_sigma_m.empty()) return;
    ForLooks(*block, trajectory_error->passes, [&](std::size_t i) {
      double& sigma_m = block->looks.range_sigma_m[i];
      sigma_m = std::hypot(sigma_m, by_m);
    });
  };
  const double looks = LooksOfPiece(whole, error);
  out.change = [trajectory_error, looks](const Size& size) {
    const double by_m = std::abs(size.value) * std::sqrt(looks);
    return "block.toml: " + LargerSigmas(by_m, true, trajectory_error->passes) + " (some " +
           Short(looks) + " looks share one error: as many times its square)";
  };
  return out;
}

Hypothesis TimeCorrelated(const Block& sample, Coordinate measured, TrajectoryError found) {
  const auto trajectory_error = std::make_shared<const TrajectoryError>(std::move(found));
  const bool range = measured == Coordinate::kRange;
  Hypothesis out;
  out.kind = range ? MistakeKind::kRange : MistakeKind::kTime;
  out.cause = range ? "range.wander" : "time.wander";
  out.passes = trajectory_error->passes;
  // Residuals are predicted less measured: what is added to a measurement undoes its error. Errors
  // of times are solved for.
  out.undo = [trajectory_error, range](Block* block, double value) {
    if (!range) return;
    ForLooks(*block, trajectory_error->passes, [&](std::size_t i) {
      Looks& looks = block->looks;
      const Curve& curve = trajectory_error->curves.at(block->passes[looks.pass[i]].id);
      looks.range_m[i] += value * curve.At(looks.time_s[i]);
    });
  };
  out.parameters = trajectory_error->pieces;
  out.max_unexplained = 10.0;
  out.value = trajectory_error->rms;
  out.unit = range ? "m" : "s";
  constexpr double kWide = 10.0;
  double prior_m = kWide * trajectory_error->rms;
  if (range) {
    out.free = true;
    out.step = 0.1 * trajectory_error->rms;
    out.cautious = [trajectory_error](const Block& whole) {
      return CautiousRanges(whole, *trajectory_error);
    };
  } else {
    // A cubic spline has three coefficients more than pieces.
    out.parameters += 2 * static_cast<int>(trajectory_error->passes.size());
    double speed_mps = 0.0;
    for (const std::uint32_t p : PassesOf(sample, trajectory_error->passes)) {
      const Pass& pass = sample.passes[p];
      const auto motion = pass.path.At(0.5 * (pass.start_s + pass.end_s));
      if (motion) speed_mps = std::max(speed_mps, motion->velocity_mps.norm());
    }
    prior_m *= speed_mps;
    out.remodel = [trajectory_error, prior_m](CorrectionModel* model, double) {
      *model = WithErrorAlongTrack(std::move(*model), *trajectory_error, prior_m);
    };
  }
  out.says = [trajectory_error, range](const Size& size) {
    return std::string("errors of the ") + (range ? "ranges" : "times") + " " +
           PassesPhrase(trajectory_error->passes) +
           " are correlated in time: they drift along the strip by " + size.text +
           " (root mean square) and keep their sign for some " + Short(trajectory_error->piece_s) +
           " s";
  };
  out.change = [trajectory_error, range, prior_m](const Size& size) {
    const Names& passes = trajectory_error->passes;
    const std::string larger = LargerSigmas(std::abs(size.value), range, passes);
    // A path that is moved is no range that is wrong: its effect changes with the look angle.
    if (range) return "block.toml: " + larger;
    std::string others;
    for (std::size_t i = 1; i < passes.size(); ++i) others += (i == 1 ? "" : ", ") + passes[i];
    const std::string spline =
        "[[adjust.correction.position]] with basis = \"spline\", knot_spacing_s = " +
        Short(trajectory_error->piece_s) +
        ", components = [\"along\"], sigma_m = " + Short(prior_m) + ", passes = [\"" + passes[0] +
        "\"], shared = true (beside what the pass has" +
        (others.empty() ? "" : "; a table each for " + others) + ")";
    return "block.toml: " + spline + " if the flights have such errors, else " + larger;
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// Residuals show a part of an error and put another into the points and paths: what is left beside
/// the curve that they show is added to it, as long as that takes more.
Curve FollowRangeErrors(const Facts& facts, const std::string& pass, Curve curve, Trials* trials) {
  constexpr int kMaxSteps = 5;
  constexpr double kWorthAStep = 0.9, kPartForCurves = 0.8;
  Curve best = curve;
  // The first is to take half of what is too much (docs/theory/diagnosis.md, eq. (7)).
  double least = 0.5 * (facts.before.SquareSum() + facts.before.redundancy) / kWorthAStep;
  BlockState from = facts.before.state;
  for (int step = 0; step < kMaxSteps && trials->work().Allows(kPartForCurves); ++step) {
    const Hypothesis undone =
        TimeCorrelated(facts.sample.block, Coordinate::kRange, Together({{pass, curve}}));
    const bool near = step > 0 || facts.near();
    Fit fit = trials->With(undone,
                           undone.value,
                           {.warm = near ? &from : nullptr,
                            .effort = Effort::kQuick,
                            .useless_above = kWorthAStep * least});
    if (!fit.solved || !(fit.SquareSum() < kWorthAStep * least)) break;
    best = curve;
    least = fit.SquareSum();
    from = fit.state;
    Block block = trials->given();
    undone.undo(&block, undone.value);
    const SampleResiduals residuals = ResidualsOf(block, facts.corrections, fit);
    std::vector<Sign> signs = SignsOf(block, residuals, pass, Coordinate::kRange);
    for (Sign& sign : signs) sign.error += curve.At(sign.time_s);
    auto next = FindCurve(signs);
    if (!next) break;
    curve = std::move(*next);
  }
  return best;
}

}  // namespace

void AddTimeCorrelatedMistakes(const Facts& facts, Trials* trials, Hypotheses* out) {
  if (!facts.before.solved) return;
  for (const Coordinate measured : {Coordinate::kRange, Coordinate::kTime}) {
    std::vector<std::pair<std::string, Curve>> curves;
    for (const Pass& pass : facts.sample.block.passes) {
      auto curve = FindCurve(SignsOf(facts.sample.block, facts.residuals, pass.id, measured));
      if (!curve) continue;
      // Times that are off by more than the strip drift nowhere.
      const auto [least, most] = std::minmax_element(curve->values.begin(), curve->values.end());
      if (measured == Coordinate::kTime && *most - *least > pass.end_s - pass.start_s) continue;
      curves.emplace_back(pass.id, std::move(*curve));
    }
    for (auto& [pass, curve] : curves) {
      if (measured == Coordinate::kTime) break;
      curve = FollowRangeErrors(facts, pass, std::move(curve), trials);
    }
    for (const auto& curve : curves) {
      out->push_back(TimeCorrelated(facts.sample.block, measured, Together({curve})));
    }
    if (curves.size() > 1) {
      out->push_back(TimeCorrelated(facts.sample.block, measured, Together(curves)));
    }
  }
}

}  // namespace sarblock
