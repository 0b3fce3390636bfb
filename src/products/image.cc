// SPDX-License-Identifier: Apache-2.0
#include "image.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.h"
#include "geometry/recorded_states.h"
#include "geometry/smooth_path.h"
#include "xml.h"
#include <Eigen/Geometry>
#include <fmt/core.h>

namespace sarblock {
namespace {

/// Above it positions and velocities disagree: 1 mm/s of 7500 m/s turns the Doppler plane by 0.1 m
/// at 900 km.
constexpr double kContradiction_mps = 1e-3;

// With states 5 minutes apart the polynomial of degree 7 is some 6 mm from a low orbit; states
// farther apart no longer determine where the satellite was.
void RefuseGaps(const std::string& file, const std::vector<StateVector>& states) {
  constexpr double kLongest_s = 300.0;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double gap_s = states[k].time_s - states[k - 1].time_s;
    if (gap_s <= kLongest_s) continue;
    throw InputError(FilePlace{file, 0, "orbit"},
                     fmt::format("states {} and {} are {} s apart, {} s at most is allowed",
                                 k,
                                 k + 1,
                                 gap_s,
                                 kLongest_s));
  }
}

void RefuseCloseStates(const std::string& file, const std::vector<StateVector>& states) {
  const auto close = FindCloseStates(states);
  if (!close) return;
  throw InputError(
      FilePlace{file, 0, "orbit"},
      fmt::format("states {} and {} are {}", close->second, close->second + 1, Describe(*close)));
}

// What a path leaves out between its states, and another way that is better.
std::optional<std::string> ProblemBetweenStates(const std::vector<StateVector>& states,
                                                const TimeSpan& image_s,
                                                double step_s,
                                                OrbitThrough through) {
  constexpr double kRange_m = 1e6, kNamed_m = 0.1, kBetter = 0.5;
  const Recording recording(states, {}, image_s);
  const double turning_s = kRange_m / states.front().velocity_mps.norm();
  const auto off_m = [&](PathThrough way) {
    const PathErrors errors = recording.ErrorsOf(way);
    return std::hypot(errors.interpolation_m, turning_s * errors.interpolation_mps);
  };
  const bool cubic = step_s == 0.0, positions = through == OrbitThrough::kPositions;
  const double used_m = off_m(cubic       ? PathThrough::kStates
                              : positions ? PathThrough::kPositions
                                          : PathThrough::kOrbit);
  if (!(used_m > kNamed_m)) return std::nullopt;
  const bool through_states = positions || cubic;
  const double other_m = off_m(through_states ? PathThrough::kOrbit : PathThrough::kPositions);
  const char* const remedy = cubic       ? "--orbit-step-s 1"
                             : positions ? "--orbit-through states"
                                         : "--orbit-through positions";
  return fmt::format(
      "the path between the states of the orbit ({} states, {} s apart) is off by some {} m along "
      "track at a range of 1000 km; {}",
      states.size(),
      NumberText((states.back().time_s - states.front().time_s) /
                 static_cast<double>(states.size() - 1)),
      Digits(used_m, 2),
      other_m < kBetter * used_m ? fmt::format("with {} it is {} m", remedy, Digits(other_m, 2))
                                 : std::string("denser states are needed"));
}

}  // namespace

std::optional<std::string> ProblemOfState(const OrbitState* before, const OrbitState& state) {
  if (before != nullptr && !(SecondsBetween(before->time, state.time) > 0.0)) {
    return "its time " + UtcText(state.time) + " is not after that of the state before, " +
           UtcText(before->time);
  }
  // The Earth's polar radius is 6357 km; states in kilometres or in wrong columns show here.
  constexpr double kLowest_m = 6.36e6;
  if (!(state.position_m.norm() > kLowest_m)) {
    return "the position lies inside the Earth, metres in earth-fixed axes are needed";
  }
  if (!(state.velocity_mps.norm() > 0.0)) return "the velocity is zero";
  return std::nullopt;
}

std::vector<OrbitState> ReadStates(const XmlElement& list,
                                   const char* name,
                                   const std::function<OrbitState(const XmlElement&)>& read) {
  const std::vector<XmlElement> elements = list.Children(name);
  std::vector<OrbitState> states;
  for (const XmlElement& element : elements) {
    OrbitState state = read(element);
    const auto problem = ProblemOfState(states.empty() ? nullptr : &states.back(), state);
    if (problem) element.Fail(*problem);
    states.push_back(std::move(state));
  }
  if (states.size() < 2) list.Fail("has fewer than two states, a path needs two or more");
  if (const auto close = FindCloseStates(StatesFrom(states, states.front().time))) {
    elements[close->second].Fail("this state and the one on line " +
                                 std::to_string(elements[close->second - 1].line()) + " are " +
                                 Describe(*close));
  }
  return states;
}

Eigen::Vector3d ReadVector(const XmlElement& element, const char* x, const char* y, const char* z) {
  return {element.Child(x).Number(), element.Child(y).Number(), element.Child(z).Number()};
}

std::vector<OrbitState> ReadFlatStates(const XmlElement& list, const char* name, const char* time) {
  return ReadStates(list, name, [time](const XmlElement& state) -> OrbitState {
    return {state.Child(time).Time(),
            ReadVector(state, "posX", "posY", "posZ"),
            ReadVector(state, "velX", "velY", "velZ")};
  });
}

LookSide ReadSide(const XmlElement& element, const std::string& left, const std::string& right) {
  const std::string text = element.Text();
  if (text != left && text != right) {
    element.Fail("must be " + left + " or " + right + ", got " + Quoted(text));
  }
  return text == left ? LookSide::kLeft : LookSide::kRight;
}

std::string CompactTime(const UtcTime& time) {
  std::string text = UtcText(time);
  std::erase_if(text, [](char c) { return c == '-' || c == ':' || c == 'Z'; });
  return text;
}

std::vector<StateVector> StatesFrom(const std::vector<OrbitState>& states, const UtcTime& epoch) {
  std::vector<StateVector> result;
  result.reserve(states.size());
  for (const OrbitState& state : states) {
    result.push_back({SecondsBetween(epoch, state.time), state.position_m, state.velocity_mps});
  }
  return result;
}

FlightPath PathThroughOrbit(const std::string& file,
                            const std::vector<StateVector>& states,
                            const TimeSpan& image_s,
                            double step_s,
                            OrbitThrough through,
                            std::vector<std::string>* warnings) {
  RefuseGaps(file, states);
  RefuseCloseStates(file, states);
  const double contradiction_mps = LargestContradiction_mps(states);
  if (through == OrbitThrough::kStates && contradiction_mps > kContradiction_mps) {
    warnings->push_back(
        fmt::format("{}: velocities of the orbit differ from the motion of its positions by up "
                    "to {:.4f} m/s; "
                    "the path swings between the states, --orbit-through positions avoids it",
                    file,
                    contradiction_mps));
  }
  FlightPath path(step_s == 0.0 ? states : ResampleOrbit(states, step_s, through));
  if (const auto problem = ProblemBetweenStates(states, image_s, step_s, through)) {
    warnings->push_back(file + ": " + *problem);
  }
  if (const auto alternation = FindAlternation(states)) {
    warnings->push_back(file + ": orbit: " + Describe(*alternation));
  }
  return path;
}

std::optional<Eigen::Vector3d> GroundOf(const FlightPath& path,
                                        LookSide side,
                                        const Frame& frame,
                                        const RadarCoordinates& radar,
                                        double height_m) {
  const auto motion = path.At(radar.time_s);
  if (!motion || !(radar.range_m > 0.0)) return std::nullopt;
  FixedPathLook look;
  look.antenna_m = motion->position_m;
  look.velocity_mps = motion->velocity_mps;
  look.acceleration_mps2 = motion->acceleration_mps2;
  look.range_m = radar.range_m;
  look.side = static_cast<int>(side);
  const Intersection ground = IntersectWithHeight(look, frame, height_m);
  if (ground.outcome != IntersectionOutcome::kDetermined) return std::nullopt;
  return ground.position_m;
}

std::string Describe(const FaultyRow& row) {
  const auto span = [](const double(&bounds)[2]) {
    return fmt::format("{:.1f} to {:.1f} m", bounds[0], bounds[1]);
  };
  std::string text = fmt::format(
      "{}: geolocationGrid line {} (row {}): {} of {} points do not fit the orbit, along track by "
      "{}, in range by {}",
      row.file_line > 0 ? fmt::format("{}:{}", row.file, row.file_line) : row.file,
      row.line,
      row.row,
      row.points,
      row.of,
      span(row.along_m),
      span(row.range_m));
  if (row.same_time) text += "; its azimuth time is that of the row before";
  if (row.fault == GridFault::kPosition) {
    return row.used ? text + "; their looks are rejected" : text;
  }
  text += "; heights changed by " + span(row.height_m) + " would fit";
  return row.used ? text + ", so their heights are not used" : text;
}

namespace {

struct Misfit {
  double range_m = 0.0;
  double along_m = 0.0;
  double range_per_height = 0.0;  // d e_r / d height
};

Misfit MisfitAt(const Motion& motion,
                const Eigen::Vector3d& p_m,
                const Eigen::Vector3d& up,
                const GridPoint& given) {
  LookEquations equations;
  if (!EvaluateLookEquations(
          p_m, motion.position_m, motion.velocity_mps, given.cone, 0.0, &equations)) {
    return {kNotGiven, kNotGiven, kNotGiven};
  }
  return {equations.rho_m - given.range_m, equations.doppler_error_m, equations.drho_dp.dot(up)};
}

// The change of height that makes the range fit, if the point then fits altogether, else NaN:
// Newton's method on a nearly linear function.
double HeightChange(const Motion& motion,
                    const GridFit& fit,
                    const Eigen::Vector3d& up,
                    const GridPoint& given,
                    double max_misfit_m) {
  constexpr double kMax_m = 9000.0;  // more than the relief of the Earth's land is no height error
  double change_m = 0.0;
  for (int step = 0; step < 10; ++step) {
    const Misfit at = MisfitAt(motion, fit.position_m + change_m * up, up, given);
    if (!(std::abs(at.range_per_height) > 0.05)) return kNotGiven;  // grazing: no say
    change_m -= at.range_m / at.range_per_height;
    if (!(std::abs(change_m) < kMax_m)) return kNotGiven;
  }
  const Misfit end = MisfitAt(motion, fit.position_m + change_m * up, up, given);
  const bool fits = std::abs(end.range_m) < max_misfit_m && std::abs(end.along_m) < max_misfit_m;
  return fits ? change_m : kNotGiven;
}

LookSide SideOf(const Motion& motion, const Frame& frame, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d left = frame.VerticalAt(motion.position_m).up.cross(motion.velocity_mps);
  return left.dot(p_m - motion.position_m) > 0.0 ? LookSide::kLeft : LookSide::kRight;
}

void Widen(double value, bool first, double (&bounds)[2]) {
  bounds[0] = first ? value : std::min(bounds[0], value);
  bounds[1] = first ? value : std::max(bounds[1], value);
}

}  // namespace

std::optional<GridFit> FitGridPoint(const GridPoint& point,
                                    const Frame& frame,
                                    const FlightPath& path,
                                    double max_misfit_m) {
  const auto motion = path.At(point.time_s);
  if (!motion) return std::nullopt;
  GridFit fit;
  fit.position_m = frame.FrameFromGeodetic(point.place);
  fit.side = SideOf(*motion, frame, fit.position_m);
  const Eigen::Vector3d up = frame.VerticalAt(fit.position_m).up;
  const Misfit misfit = MisfitAt(*motion, fit.position_m, up, point);
  fit.range_error_m = misfit.range_m;
  fit.along_error_m = misfit.along_m;
  const bool range_fits = std::abs(misfit.range_m) <= max_misfit_m;
  const bool along_fits = std::abs(misfit.along_m) <= max_misfit_m;
  if (!range_fits || !along_fits) {
    const double change_m = HeightChange(*motion, fit, up, point, max_misfit_m);
    const bool fits = !std::isnan(change_m);
    fit.fault = fits ? GridFault::kHeight : GridFault::kPosition;
    fit.height_change_m = fits ? change_m : 0.0;
  }
  return fit;
}

void FaultyRows::Begin(int line, bool same_time) {
  End();
  ++count_;
  for (const GridFault fault : {GridFault::kPosition, GridFault::kHeight}) {
    current_.push_back({.file = file_, .fault = fault, .line = line, .row = count_});
    current_.back().same_time = same_time;
  }
}

void FaultyRows::Add(const GridFit& fit, std::size_t file_line) {
  ++points_;
  for (FaultyRow& row : current_) {
    if (fit.fault != row.fault) continue;
    const bool first = row.points++ == 0;
    if (first) row.file_line = file_line;
    Widen(fit.along_error_m, first, row.along_m);
    Widen(fit.range_error_m, first, row.range_m);
    Widen(fit.height_change_m, first, row.height_m);
  }
}

void FaultyRows::End() {
  for (FaultyRow& row : current_) {
    row.of = points_;
    if (row.points > 0) rows_.push_back(std::move(row));
  }
  current_.clear();
  points_ = 0;
}

std::vector<FaultyRow> FaultyRows::Take() {
  End();
  return std::move(rows_);
}

}  // namespace sarblock
