// SPDX-License-Identifier: Apache-2.0
#include "plausibility.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "core/utc.h"
#include "geometry/recorded_states.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

/// Part of the speed by which velocities and positions of two states may differ. A cubic follows an
/// orbit with states 5 minutes apart to a hundredth.
constexpr double kVelocityPart = 0.05;
/// Added to that, times the noise of the recording: more than chance gives in millions of states.
constexpr double kNoiseSigmas = 12.0;
/// Parts of the range that errors of navigation may amount to.
constexpr double kPassPart = 0.05, kPointPart = 0.03;
/// Shortest range that terrain may lead to, as a part of the flight height.
constexpr double kHeightPart = 0.5;

std::string Short(double value) { return Digits(value, 4); }

std::string Km(double length_m) { return Short(1e-3 * length_m) + " km"; }

// ---- one path

std::string VelocityRemark(const Pass& pass) {
  const std::vector<StateVector>& states = pass.RecordedStates();
  for (std::size_t i = 1; i < states.size(); ++i) {
    const StateVector &a = states[i - 1], &b = states[i];
    const Eigen::Vector3d moved_mps = (b.position_m - a.position_m) / (b.time_s - a.time_s);
    const Eigen::Vector3d said_mps = 0.5 * (a.velocity_mps + b.velocity_mps);
    const double larger_mps = std::max(moved_mps.norm(), said_mps.norm());
    const StateNoise& noise = pass.recorded.effect.noise;
    const double noise_mps =
        std::hypot(noise.position_m / (b.time_s - a.time_s), noise.velocity_mps);
    const double most_mps = kVelocityPart * larger_mps + kNoiseSigmas * noise_mps;
    if ((moved_mps - said_mps).norm() <= most_mps) continue;
    return "pass " + pass.id + ": its velocities are not those of its positions: from " +
           Short(a.time_s) + " s to " + Short(b.time_s) + " s it moves at " +
           Short(moved_mps.norm()) + " m/s, the velocities say " + Short(said_mps.norm()) +
           " m/s and differ by " + Short((moved_mps - said_mps).norm()) +
           " m/s (a unit, an axis, a sign, or times of another unit)";
  }
  return "";
}

std::string AlternationRemark(const Pass& pass) {
  const auto alternation = FindAlternation(pass.RecordedStates());
  return alternation ? "pass " + pass.id + ": " + Describe(*alternation) : "";
}

std::string InertialRemark(const Block& block, const Pass& pass) {
  const auto motion = InertialMotionOf(block, pass);
  if (!motion) return "";
  return "pass " + pass.id + ": " + Describe(*motion) +
         " (body-fixed states are needed, unless the body does not turn in this block)";
}

// ---- what a pass sees

/// A look at a known point, read on the nominal path at its measured time.
struct KnownLook {
  std::uint32_t point = 0;
  double range_ratio = 0.0;  ///< measured over the distance to the known position
  double ahead_m = 0.0;      ///< how far the known position lies ahead of the cone
  double beam_mps = 0.0;     ///< at which the cone moves over it
  double range_m = 0.0;
  bool on_its_side = false;  ///< below the antenna, on the side it looks to
};

struct PassLooks {
  std::vector<KnownLook> known;
  double shortest_range_m = kNotGiven;
  std::size_t in_turn = 0, first_in_turn = 0;  ///< looks, and the first of them
};

/// A look is in a turn where the radius of the path is shorter than the range, so that the beam
/// does not pass evenly over the ground and no image can be focused: from kNear of R/|v| before it
/// to as long after, the velocity turns by 2 kNear or more (a low orbit: by an eighth of that), and
/// within kAround of R/|v| by more than gusts make.
constexpr double kNear = 0.025, kAround = 0.2, kGusts_rad = 0.35;

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::vector<bool> PathsThatTurn(const Block& block) {
  std::vector<bool> turn;
  for (const Pass& pass : block.passes) {
    const std::vector<StateVector>& states = pass.path.states();
    turn.push_back(std::any_of(states.begin(), states.end(), [&states](const StateVector& state) {
      return AngleBetween(states.front().velocity_mps, state.velocity_mps) > kGusts_rad;
    }));
  }
  return turn;
}

/// By how much the velocity turns from `reach_s` before a time to as long after.
double TurnAround_rad(const FlightPath& path, double time_s, double reach_s) {
  Motion before, after;
  if (!path.Evaluate(std::max(path.start_s(), time_s - reach_s), &before) ||
      !path.Evaluate(std::min(path.end_s(), time_s + reach_s), &after)) {
    return 0.0;
  }
  return AngleBetween(before.velocity_mps, after.velocity_mps);
}

bool IsInTurn(const FlightPath& path, double time_s, double range_m) {
  Motion at;
  if (std::isnan(range_m) || !path.Evaluate(time_s, &at)) return false;
  const double scale_s = range_m / at.velocity_mps.norm();
  return TurnAround_rad(path, time_s, kNear * scale_s) > 2.0 * kNear &&
         TurnAround_rad(path, time_s, kAround * scale_s) > kGusts_rad;
}

/// Nothing where the look has no measured values or components of the position are not known.
bool ReadKnownLook(const Block& block, std::size_t look, std::uint32_t point, KnownLook* out) {
  const Looks& looks = block.looks;
  const Pass& pass = block.passes[looks.pass[look]];
  Motion motion;
  if (!pass.path.Evaluate(looks.time_s[look], &motion) || std::isnan(looks.range_m[look])) {
    return false;
  }
  const Eigen::Vector3d& p_m = block.points.given_m[point];
  const ConeValue cone = EvaluateCone(motion, p_m, block.ConeOf(look));
  out->point = point;
  out->range_m = looks.range_m[look];
  out->range_ratio = looks.range_m[look] / (p_m - motion.position_m).norm();
  out->ahead_m = cone.doppler_error_m;
  out->beam_mps = -cone.rate_mps;
  FixedPathLook observation;
  observation.antenna_m = motion.position_m;
  observation.velocity_mps = motion.velocity_mps;
  observation.side = static_cast<int>(pass.side);
  out->on_its_side = LiesWhereItLooks(block.frame, observation, p_m);
  return true;
}

/// Adds the looks of the points from `begin` to `end`.
void AddLooks(const Block& block,
              const std::vector<bool>& turns,
              std::size_t begin,
              std::size_t end,
              std::vector<PassLooks>* out) {
  const Looks& looks = block.looks;
  for (std::size_t j = begin; j < end; ++j) {
    const auto point = static_cast<std::uint32_t>(j);
    const KnownPosition* known =
        block.points.role[point] == PointRole::kTie ? nullptr : block.points.FindKnown(point);
    const bool compared = known != nullptr && known->fixed[0] && known->fixed[1] && known->fixed[2];
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (looks.rejected(i)) continue;
      PassLooks& pass = (*out)[looks.pass[i]];
      if (!(looks.range_m[i] >= pass.shortest_range_m)) {  // also where there was none yet
        if (!std::isnan(looks.range_m[i])) pass.shortest_range_m = looks.range_m[i];
      }
      if (turns[looks.pass[i]] &&
          IsInTurn(block.passes[looks.pass[i]].path, looks.time_s[i], looks.range_m[i])) {
        if (pass.in_turn++ == 0) pass.first_in_turn = i;
      }
      KnownLook look;
      if (compared && ReadKnownLook(block, i, point, &look)) pass.known.push_back(look);
    }
  }
}

std::vector<PassLooks> LooksByPass(const Block& block) {
  const std::size_t points = block.points.size();
  const std::vector<bool> turns = PathsThatTurn(block);
  std::vector<std::vector<PassLooks>> pieces(PiecesOfLooks(points),
                                             std::vector<PassLooks>(block.passes.size()));
  ForPiecesOfLooks(points, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    AddLooks(block, turns, begin, end, &pieces[piece]);
  });
  std::vector<PassLooks> out(block.passes.size());
  for (const std::vector<PassLooks>& piece : pieces) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i].shortest_range_m = std::fmin(out[i].shortest_range_m, piece[i].shortest_range_m);
      if (out[i].in_turn == 0) out[i].first_in_turn = piece[i].first_in_turn;
      out[i].in_turn += piece[i].in_turn;
      out[i].known.insert(out[i].known.end(), piece[i].known.begin(), piece[i].known.end());
    }
  }
  return out;
}

std::string TurnRemark(const Block& block, const Pass& pass, const PassLooks& looks) {
  if (looks.in_turn == 0) return "";
  const std::vector<std::uint64_t>& offsets = block.looks.offsets;
  const auto after = std::upper_bound(offsets.begin(), offsets.end(), looks.first_in_turn);
  const auto point = static_cast<std::uint32_t>(after - offsets.begin() - 1);
  return "pass " + pass.id + ": " + std::to_string(looks.in_turn) +
         " looks are in a turn of its path, the first of point " +
         std::string(block.points.ids[point]) + " at " +
         Short(block.looks.time_s[looks.first_in_turn]) +
         " s: no image can be focused there, and points are seen more than once; leave these looks "
         "out, or their times are mistaken";
}

std::string SideRemark(const Pass& pass, const PassLooks& looks) {
  const auto wrong = static_cast<std::size_t>(
      std::count_if(looks.known.begin(), looks.known.end(), [](const KnownLook& look) {
        return !look.on_its_side;
      }));
  if (2 * wrong <= looks.known.size()) return "";
  return "pass " + pass.id + ": " + std::to_string(wrong) + " of its " +
         std::to_string(looks.known.size()) +
         " known points lie above the antenna or on the side " + "it does not look to (look = \"" +
         (pass.side == LookSide::kLeft ? "left" : "right") + "\")";
}

struct Medians {
  double ratio = 1.0, ahead_m = 0.0, ahead_s = 0.0;
};

Medians MediansOf(const std::vector<KnownLook>& known) {
  std::vector<double> ratio, ahead, ahead_s;
  for (const KnownLook& look : known) {
    ratio.push_back(look.range_ratio);
    ahead.push_back(look.ahead_m);
    ahead_s.push_back(look.ahead_m / look.beam_mps);
  }
  return {Median(ratio), Median(ahead), Median(ahead_s)};
}

std::string KnownPointsRemark(const Pass& pass, const PassLooks& looks, const Medians& median) {
  const std::string of = " (median of " + std::to_string(looks.known.size()) + ")";
  if (std::abs(median.ratio - 1.0) > kPassPart) {
    return "pass " + pass.id + ": its ranges are " + Short(median.ratio) +
           " times the distances to its known points" + of +
           ": ranges there and back, a unit, a path or control of another frame";
  }
  const double range_m = looks.known.front().range_m;
  if (std::abs(median.ahead_m) <= kPassPart * range_m) return "";
  return "pass " + pass.id + ": its known points lie " + Km(std::abs(median.ahead_m)) + " (" +
         Short(std::abs(median.ahead_s)) + " s of flight) " +
         (median.ahead_m > 0.0 ? "ahead of" : "behind") + " where its looks see them" + of +
         ": times of another origin, a path or control of another frame";
}

/// Ground below a pass: the ellipsoid, or the mean of the known points.
std::string HeightRemark(const Block& block, const Pass& pass, const PassLooks& looks) {
  if (std::isnan(looks.shortest_range_m)) return "";
  const Eigen::Vector3d& antenna_m = pass.path.states().front().position_m;
  double height_m = 0.0;
  if (block.frame.kind() == FrameKind::kGeocentric) {
    height_m = block.frame.GeodeticFromFrame(antenna_m).h_m;
  } else {
    if (looks.known.empty()) return "";
    double ground_m = 0.0;
    for (const KnownLook& look : looks.known) ground_m += block.points.given_m[look.point].z();
    height_m = antenna_m.z() - ground_m / static_cast<double>(looks.known.size());
  }
  const std::string ground =
      block.frame.kind() == FrameKind::kGeocentric ? "the ellipsoid" : "its known points";
  if (height_m < 0.0) {
    return "pass " + pass.id + ": its path lies " + Km(-height_m) + " below " + ground +
           ": coordinates of another frame or another ellipsoid";
  }
  if (looks.shortest_range_m >= kHeightPart * height_m) return "";
  return "pass " + pass.id + ": it flies " + Km(height_m) + " above " + ground +
         " but its shortest range is " + Km(looks.shortest_range_m) +
         ": a unit, or another frame or ellipsoid";
}

// ---- the frame

/// Extent of paths and known points in x and y of the frame [m].
Eigen::AlignedBox2d ExtentOf(const Block& block) {
  Eigen::AlignedBox2d extent;
  for (const Pass& pass : block.passes) {
    for (const StateVector& state : pass.path.states()) extent.extend(state.position_m.head<2>());
  }
  for (const KnownPosition& known : block.points.known) {
    const Eigen::Vector3d& p_m = block.points.given_m[known.point];
    if (p_m.allFinite()) extent.extend(p_m.head<2>());
  }
  return extent;
}

std::string ProjectionRemark(const Block& block) {
  if (!HasMapCoordinates(block)) return "";
  const Eigen::AlignedBox2d extent = ExtentOf(block);
  const Eigen::Vector2d &least = extent.min(), &most = extent.max();
  return "the coordinates are like those of a map projection (x " + Km(least.x()) + " to " +
         Km(most.x()) + ", y " + Km(least.y()) + " to " + Km(most.y()) +
         "), and the axes of kind = \"local\" are straight: a map's scale (UTM: up to 0.4 m in a "
         "kilometre) and the curved ground (2 m in 5 km, 31 m in 20 km) would be errors; a "
         "geocentric frame has none";
}

// ---- decimals

/// The step of decimals, 1, 0.1 and so on, of which all numbers are multiples; 0 once it is so
/// small that it does not matter.
class DecimalStep {
 public:
  /// Steps up to `harmless` are none.
  void Add(double value, double harmless) {
    if (std::isnan(value)) return;
    // The same number again, as the height of flat ground, is no further evidence of rounding.
    if (!(std::abs(value - last_) < kSame * step_)) ++count_;
    last_ = value;
    while (step_ > 0.0 && !IsMultiple(value)) step_ = step_ > harmless ? 0.1 * step_ : 0.0;
    if (step_ <= harmless) step_ = 0.0;
  }
  /// No number can change it any more.
  [[nodiscard]] bool settled() const { return step_ == 0.0; }
  /// NaN where there are too few numbers, or it does not matter.
  [[nodiscard]] double step() const { return count_ >= kFewest && step_ > 0.0 ? step_ : kNotGiven; }
  /// Standard deviation of rounding to it.
  [[nodiscard]] double rounding() const { return step() / std::sqrt(12.0); }

 private:
  static constexpr double kSame = 1e-3;      // of a step
  static constexpr std::size_t kFewest = 5;  // a chance of 3e-14 in any numbers
  [[nodiscard]] bool IsMultiple(double value) const {
    const double steps = value / step_;
    return std::abs(steps - std::round(steps)) < kSame;
  }
  double step_ = 1.0;
  double last_ = kNotGiven;
  std::size_t count_ = 0;
};

/// Rounding to this step, whose standard deviation is the step over sqrt(12), is half of sigma.
double HarmlessStep(double sigma) { return 0.5 * std::sqrt(12.0) * sigma; }

/// A column of points.csv at a known point.
struct PointColumn {
  const char* name;
  const char* unit;
  double metres;   ///< of one unit
  double value;    ///< of a known point
  double sigma_m;  ///< NaN where it is not known there
};

constexpr std::size_t kPointColumns = 6;

/// Both ways to give a known point: it has been read in one of them, and is round in no other.
std::array<PointColumn, kPointColumns> ColumnsOf(const Block& block, const KnownPosition& known) {
  const Eigen::Vector3d& p_m = block.points.given_m[known.point];
  const Eigen::Matrix3d& covariance_m2 = known.covariance_enu_m2;
  const Geodetic at = block.frame.GeodeticFromFrame(p_m);
  const auto sigma_of_m = [&](const Eigen::Vector3d& axis_enu) {
    for (int i = 0; i < 3; ++i) {
      if (axis_enu[i] != 0.0 && !known.fixed[static_cast<std::size_t>(i)]) return kNotGiven;
    }
    return std::sqrt(axis_enu.dot(covariance_m2 * axis_enu));
  };
  const Eigen::Matrix3d enu = block.frame.EnuFromFrame(p_m);
  const double degree_m = kRadPerDeg * block.frame.ellipsoid().a_m;
  return {{{"lat_deg", "deg", degree_m, kDegPerRad * at.lat_rad, sigma_of_m({0.0, 1.0, 0.0})},
           {"lon_deg",
            "deg",
            degree_m * std::cos(at.lat_rad),
            kDegPerRad * at.lon_rad,
            sigma_of_m({1.0, 0.0, 0.0})},
           {"h_m", "m", 1.0, at.h_m, sigma_of_m({0.0, 0.0, 1.0})},
           {"x_m", "m", 1.0, p_m.x(), sigma_of_m(enu.col(0))},
           {"y_m", "m", 1.0, p_m.y(), sigma_of_m(enu.col(1))},
           {"z_m", "m", 1.0, p_m.z(), sigma_of_m(enu.col(2))}}};
}

/// For geocentric frames: in a local frame coordinates of a plan are round and exact.
std::vector<std::string> PointDecimalRemarks(const Block& block) {
  std::vector<std::string> remarks;
  if (block.frame.kind() != FrameKind::kGeocentric) return remarks;
  std::array<PointColumn, kPointColumns> columns{};
  std::array<DecimalStep, kPointColumns> steps;
  for (const KnownPosition& known : block.points.known) {
    if (!block.points.given_m[known.point].allFinite()) continue;
    columns = ColumnsOf(block, known);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const PointColumn& column = columns[k];
      if (std::isnan(column.sigma_m)) continue;
      steps[k].Add(column.value, HarmlessStep(column.sigma_m / column.metres));
    }
  }
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (std::isnan(steps[k].step())) continue;
    remarks.push_back(std::string(columns[k].name) + " of known points are multiples of " +
                      Short(steps[k].step()) + " " + columns[k].unit + ": rounding alone is " +
                      Short(steps[k].rounding() * columns[k].metres) +
                      " m, more than half of the standard deviation given");
  }
  return remarks;
}

std::vector<std::string> DecimalRemarks(const Block& block) {
  std::vector<DecimalStep> range(block.passes.size()), time(block.passes.size());
  std::vector<double> speed_mps;
  for (const Pass& pass : block.passes) {
    speed_mps.push_back(pass.path.states().front().velocity_mps.norm());
  }
  const Looks& looks = block.looks;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::uint32_t pass = looks.pass[i];
    if (range[pass].settled() && time[pass].settled()) continue;
    if (block.passes[pass].image || looks.rejected(i)) continue;  // lines and pixels have their own
    const LookSigma sigma = block.SigmaOf(i);
    range[pass].Add(looks.range_m[i], HarmlessStep(sigma.range_m));
    if (block.MeasuresDoppler(i)) continue;
    const double sigma_s = sigma.azimuth_unit == AzimuthUnit::kSeconds
                               ? sigma.azimuth
                               : sigma.azimuth / speed_mps[pass];
    time[pass].Add(looks.time_s[i], HarmlessStep(sigma_s));
  }
  std::vector<std::string> remarks;
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const auto add =
        [&](const char* what, const DecimalStep& step, double metres, const char* where) {
          if (std::isnan(step.step())) return;
          remarks.push_back("pass " + block.passes[pass].id + ": its " + what +
                            " are multiples of " + Short(step.step()) + ": rounding alone is " +
                            Short(step.rounding() * metres) + " m " + where +
                            ", more than half of the standard deviation given");
        };
    add("times", time[pass], speed_mps[pass], "along the track");
    add("ranges", range[pass], 1.0, "in range");
  }
  for (std::string& remark : PointDecimalRemarks(block)) remarks.push_back(std::move(remark));
  return remarks;
}

// ---- single known points

std::string PointsRemark(const Block& block,
                         const std::vector<PassLooks>& passes,
                         const std::vector<Medians>& medians) {
  // By point: looks that deviate, all looks, and the largest deviation.
  struct Deviation {
    std::size_t off = 0, looks = 0;
    double largest_m = 0.0;
  };
  std::map<std::uint32_t, Deviation> d_point;
  for (std::size_t pass = 0; pass < passes.size(); ++pass) {
    if (passes[pass].known.size() < 3) continue;  // no majority to deviate from
    for (const KnownLook& look : passes[pass].known) {
      const double range_m = look.range_m * (1.0 - medians[pass].ratio / look.range_ratio);
      const double ahead_m = look.ahead_m - medians[pass].ahead_m;
      const double off_m = std::hypot(range_m, ahead_m);
      Deviation& point = d_point[look.point];
      ++point.looks;
      point.off += off_m > kPointPart * look.range_m ? 1U : 0U;
      point.largest_m = std::max(point.largest_m, off_m);
    }
  }
  std::vector<std::pair<std::uint32_t, Deviation>> off;
  for (const auto& [point, deviation] : d_point) {
    if (2 * deviation.off > deviation.looks) off.emplace_back(point, deviation);
  }
  if (off.empty()) return "";
  constexpr std::size_t kNamed = 5;
  std::string text = "known points that do not lie where their looks see them:";
  for (std::size_t i = 0; i < std::min(kNamed, off.size()); ++i) {
    text += (i == 0 ? " " : ", ") + std::string(block.points.ids[off[i].first]) + " (" +
            Km(off[i].second.largest_m) + ")";
  }
  if (off.size() > kNamed) text += " and " + std::to_string(off.size() - kNamed) + " more";
  return text + ": coordinates or names are mistaken";
}

}  // namespace

std::optional<InertialMotion> InertialMotionOf(const Block& block, const Pass& pass) {
  if (block.frame.kind() != FrameKind::kGeocentric) return std::nullopt;
  const Body* body = FindBody(block.frame.ellipsoid().name);
  return body == nullptr ? std::nullopt : FindInertialMotion(pass.RecordedStates(), *body);
}

bool HasMapCoordinates(const Block& block) {
  if (block.frame.kind() != FrameKind::kLocal) return false;
  constexpr double kMinEast_m = 100e3, kMaxEast_m = 61e6, kMinNorth_m = 100e3, kMaxNorth_m = 10e6;
  constexpr double kFar = 4.0;
  const Eigen::AlignedBox2d extent = ExtentOf(block);
  if (extent.isEmpty()) return false;
  const Eigen::Vector2d &least = extent.min(), &most = extent.max();
  return least.x() > kMinEast_m && most.x() < kMaxEast_m && least.y() > kMinNorth_m &&
         most.y() < kMaxNorth_m && extent.center().norm() > kFar * extent.sizes().norm();
}

std::vector<std::string> ExaminePlausibility(const Block& block) {
  std::vector<std::string> remarks;
  const auto add = [&remarks](std::string remark) {
    if (!remark.empty()) remarks.push_back(std::move(remark));
  };
  add(ProjectionRemark(block));
  std::vector<PassLooks> looks = LooksByPass(block);
  std::vector<Medians> medians(looks.size());
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    const Pass& pass = block.passes[i];
    add(VelocityRemark(pass));
    add(AlternationRemark(pass));
    add(InertialRemark(block, pass));
    add(HeightRemark(block, pass, looks[i]));
    add(TurnRemark(block, pass, looks[i]));
    if (looks[i].known.empty()) continue;
    medians[i] = MediansOf(looks[i].known);
    std::string side = SideRemark(pass, looks[i]);
    // A point on the wrong side has the range and the time of its mirror image.
    std::string remark =
        side.empty() ? KnownPointsRemark(pass, looks[i], medians[i]) : std::move(side);
    if (!remark.empty()) looks[i].known.clear();  // says nothing of single points
    add(std::move(remark));
  }
  for (std::string& remark : DecimalRemarks(block)) add(std::move(remark));
  add(PointsRemark(block, looks, medians));
  return remarks;
}

namespace {

/// Seconds from the epoch of one pass to that of another; nothing where they cannot be compared.
std::optional<double> BetweenEpochs_s(const Pass& a, const Pass& b) {
  if (a.epoch_utc == b.epoch_utc) return 0.0;
  const std::optional<UtcTime> from = ParseUtc(a.epoch_utc), to = ParseUtc(b.epoch_utc);
  if (!from || !to) return std::nullopt;
  return SecondsBetween(*from, *to);
}

/// States that two passes share.
struct SharedStates {
  std::size_t count = 0;
  double times_apart_s = 0.0;  ///< time of a state in the second pass less that in the first
};

constexpr double kSameTime_s = 1e-3;

std::string SameFlightRemark(const Pass& a, const Pass& b, const SharedStates& shared) {
  const std::string both = "passes " + a.id + " and " + b.id + " have " +
                           std::to_string(shared.count) + " recorded states in common";
  const std::optional<double> epochs_s = BetweenEpochs_s(a, b);
  const double apart_s = std::abs(epochs_s.value_or(kNotGiven) + shared.times_apart_s);
  if (!(apart_s <= kSameTime_s)) {
    return both + " at different times (epochs " + Quoted(a.epoch_utc) + " and " +
           Quoted(b.epoch_utc) + (epochs_s ? ", " + Short(apart_s) + " s apart" : "") +
           "): one of both has the orbit of another date";
  }
  return both +
         ": they are one flight. Errors of its path are the same in both; corrections of each pass "
         "by itself take them for independent, and standard deviations come out up to 1.4 times "
         "too small: shared = true and passes = [" +
         Quoted(a.id) + ", " + Quoted(b.id) + "] in these corrections make them one";
}

// By pairs of passes, half of whose states or more they share.
std::map<std::pair<std::size_t, std::size_t>, SharedStates> FindSharedStates(const Block& block) {
  using Place = std::array<double, 3>;
  struct State {
    Place place;
    double time_s;
    std::size_t pass;
  };
  std::vector<State> states;
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    if (block.passes[i].path.IsStraight()) continue;  // a line that is flown twice, as planned
    for (const StateVector& state : block.passes[i].RecordedStates()) {
      const Eigen::Vector3d& p_m = state.position_m;
      states.push_back({{p_m.x(), p_m.y(), p_m.z()}, state.time_s, i});
    }
  }
  std::stable_sort(states.begin(), states.end(), [](const State& a, const State& b) {
    return a.place < b.place;
  });
  std::map<std::pair<std::size_t, std::size_t>, SharedStates> found;
  for (std::size_t k = 0, end = 0; k < states.size(); k = end) {
    while (end < states.size() && states[end].place == states[k].place) ++end;
    for (std::size_t i = k + 1; i < end; ++i) {  // each with the first
      const State &a = states[k], &b = states[i];
      if (a.pass == b.pass) continue;
      SharedStates& shared = found[{a.pass, b.pass}];
      ++shared.count;
      shared.times_apart_s = b.time_s - a.time_s;
    }
  }
  std::erase_if(found, [&block](const auto& entry) {
    const auto& [pair, shared] = entry;
    return 2 * shared.count < std::min(block.passes[pair.first].RecordedStates().size(),
                                       block.passes[pair.second].RecordedStates().size());
  });
  return found;
}

}  // namespace

std::vector<std::vector<std::size_t>> FindFlights(const Block& block) {
  std::vector<std::size_t> first(block.passes.size());  // of the flight of a pass
  std::iota(first.begin(), first.end(), std::size_t{0});
  for (const auto& [pair, shared] : FindSharedStates(block)) {
    const Pass &a = block.passes[pair.first], &b = block.passes[pair.second];
    const auto epochs_s = BetweenEpochs_s(a, b);
    if (!epochs_s || std::abs(*epochs_s + shared.times_apart_s) > kSameTime_s) continue;
    const std::size_t one = first[pair.first], other = first[pair.second];
    std::replace(first.begin(), first.end(), std::max(one, other), std::min(one, other));
  }
  std::map<std::size_t, std::vector<std::size_t>> by_first;
  for (std::size_t i = 0; i < first.size(); ++i) by_first[first[i]].push_back(i);
  std::vector<std::vector<std::size_t>> flights;
  for (auto& [of, passes] : by_first) {
    if (passes.size() > 1) flights.push_back(std::move(passes));
  }
  return flights;
}

std::vector<std::string> FindSameFlights(
    const Block& block, const std::function<bool(std::size_t, std::size_t)>& share) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::string> remarks;
  std::size_t more = 0;
  for (const auto& [pair, shared] : FindSharedStates(block)) {
    const Pass &a = block.passes[pair.first], &b = block.passes[pair.second];
    if (share(pair.first, pair.second)) continue;
    if (remarks.size() < kNamed) {
      remarks.push_back(SameFlightRemark(a, b, shared));
    } else {
      ++more;
    }
  }
  if (more > 0) {
    remarks.push_back(std::to_string(more) +
                      " pairs of passes more have recorded states in common");
  }
  return remarks;
}

void RequireAboveGround(const Block& block) {
  if (block.frame.kind() != FrameKind::kGeocentric) return;
  const Ellipsoid& ellipsoid = block.frame.ellipsoid();
  const double least_m = 0.5 * ellipsoid.a_m * std::min(1.0, 1.0 - ellipsoid.flattening);
  for (const Pass& pass : block.passes) {
    for (const StateVector& state : pass.path.states()) {
      const double radius_m = state.position_m.norm();
      if (radius_m >= least_m) continue;
      throw InputError("pass " + pass.id,
                       "its path is " + Km(radius_m) + " from the centre of " +
                           (ellipsoid.name.empty() ? "the ellipsoid" : ellipsoid.name) +
                           ", deep below the ground; geocentric coordinates of this body are "
                           "needed, or kind = \"local\"");
    }
  }
}

void RequireBodyFixedStates(const Block& block) {
  constexpr double kOfTurning = 1.0 / 3.0;
  std::vector<PassLooks> looks;
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    const auto motion = InertialMotionOf(block, block.passes[i]);
    if (!motion) continue;
    if (looks.empty()) looks = LooksByPass(block);
    const std::vector<KnownLook>& known = looks[i].known;
    if (known.empty()) continue;
    const StateVector& state = block.passes[i].path.states().front();
    const double turned_mps = std::hypot(state.position_m.x(), state.position_m.y()) *
                              FindBody(block.frame.ellipsoid().name)->rotation;
    const double turned_m =
        std::abs(turned_mps) / state.velocity_mps.norm() * known.front().range_m;
    if (!(std::abs(MediansOf(known).ahead_m) > kOfTurning * turned_m)) continue;
    throw InputError("pass " + block.passes[i].id,
                     Describe(*motion) +
                         ", and its looks do not see its known points from these: "
                         "body-fixed positions and velocities are needed");
  }
}

namespace {

/// Equal looks that no chance makes.
constexpr std::size_t kMinEqual = 3, kMinEqualOfPoint = 2;

using PassPair = std::pair<std::uint32_t, std::uint32_t>;

/// `sigma` are the standard deviations of look i.
bool AreRangesEqual(const Looks& looks, const LookSigma& sigma, std::size_t i, std::size_t j) {
  return std::abs(looks.range_m[i] - looks.range_m[j]) <= kEqual * sigma.range_m;
}

bool AreAzimuthsEqual(const Block& block, const LookSigma& sigma, std::size_t i, std::size_t j) {
  const Looks& looks = block.looks;
  const double speed_mps = block.passes[looks.pass[i]].path.states().front().velocity_mps.norm();
  const double sigma_s = sigma.azimuth_unit == AzimuthUnit::kSeconds
                             ? sigma.azimuth
                             : block.ApproximateAzimuthSigma_m(i, speed_mps) / speed_mps;
  if (block.MeasuresDoppler(i) &&
      !(std::abs(looks.cone[i] - looks.cone[j]) <= kEqual * sigma.azimuth)) {
    return false;
  }
  return std::abs(looks.time_s[i] - looks.time_s[j]) <= kEqual * sigma_s;
}

std::string NamesOfPairs(const Block& block,
                         const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, pairs.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::string(block.points.ids[pairs[i].first]) + " and " +
            std::string(block.points.ids[pairs[i].second]);
  }
  if (pairs.size() > 5) text += " and " + std::to_string(pairs.size() - 5) + " more";
  return text;
}

/// Looks of the later pass that are those of the earlier one.
using EqualLooks = std::map<PassPair, std::vector<std::size_t>>;

/// Those of the points from `begin` to `end`. `sigma_of_pass` serves blocks whose looks have none
/// of their own.
EqualLooks FindEqualLooks(const Block& block,
                          const std::vector<LookSigma>& sigma_of_pass,
                          std::size_t begin,
                          std::size_t end) {
  const Looks& looks = block.looks;
  const bool own = !looks.range_sigma_m.empty() || !looks.azimuth_sigma.empty();
  EqualLooks equal;
  for (std::size_t point = begin; point < end; ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const std::uint32_t pass = looks.pass[i];
      const LookSigma sigma = own ? block.SigmaOf(i) : sigma_of_pass[pass];
      for (std::size_t j = i + 1; j < looks.offsets[point + 1]; ++j) {
        if (looks.pass[j] == pass || !AreRangesEqual(looks, sigma, i, j) ||
            !AreAzimuthsEqual(block, sigma, i, j)) {
          continue;
        }
        equal[std::minmax(pass, looks.pass[j])].push_back(pass < looks.pass[j] ? j : i);
      }
    }
  }
  return equal;
}

void FindPasses(const Block& block, Copies* copies) {
  constexpr std::size_t kPointsAtOnce = 65536;
  std::vector<LookSigma> sigma_of_pass;
  for (const Pass& pass : block.passes) sigma_of_pass.push_back(pass.sigma);
  const std::size_t points = block.points.size();
  std::vector<EqualLooks> pieces((points + kPointsAtOnce - 1) / kPointsAtOnce);
  ParallelForChunks(
      points, kPointsAtOnce, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        pieces[piece] = FindEqualLooks(block, sigma_of_pass, begin, end);
      });
  EqualLooks equal;
  for (const EqualLooks& piece : pieces) {
    for (const auto& [pair, copied] : piece) {
      equal[pair].insert(equal[pair].end(), copied.begin(), copied.end());
    }
  }
  if (equal.empty()) return;
  std::vector<std::size_t> of_pass(block.passes.size(), 0);
  for (const std::uint32_t pass : block.looks.pass) ++of_pass[pass];
  for (const auto& [pair, copied] : equal) {
    const auto& [a, b] = pair;
    if (copied.size() < kMinEqual || 2 * copied.size() < std::min(of_pass[a], of_pass[b])) {
      continue;
    }
    if (std::find(copies->passes.begin(), copies->passes.end(), b) != copies->passes.end()) {
      continue;  // of three copies the second and the third are named
    }
    copies->passes.push_back(b);
    copies->looks.insert(copies->looks.end(), copied.begin(), copied.end());
    copies->remarks.push_back("pass " + block.passes[b].id + ": " + std::to_string(copied.size()) +
                              " of its " + std::to_string(of_pass[b]) +
                              " looks equal those of pass " + block.passes[a].id +
                              ": one is a copy; these looks count once, remove one of the passes");
  }
}

void FindPoints(const Block& block, Copies* copies) {
  const Looks& looks = block.looks;
  std::vector<std::uint32_t> point_of(looks.size());
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      point_of[i] = point;
    }
  }
  std::vector<std::size_t> order(looks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) {
    return looks.rejected(i) || std::isnan(looks.time_s[i]) || std::isnan(looks.range_m[i]);
  });
  // Exact times may be one time: ranges and Dopplers then bring copies together.
  const auto key = [&](std::size_t i) {
    const double cone = looks.cone.empty() ? 0.0 : looks.cone[i];
    return std::tuple(looks.pass[i], looks.time_s[i], looks.range_m[i], cone, i);
  };
  std::sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> equal;
  for (std::size_t k = 1; k < order.size(); ++k) {
    const std::size_t i = order[k - 1], j = order[k];
    if (looks.pass[i] != looks.pass[j] || point_of[i] == point_of[j]) continue;
    const LookSigma sigma = block.SigmaOf(i);
    if (!AreRangesEqual(looks, sigma, i, j) || !AreAzimuthsEqual(block, sigma, i, j)) continue;
    ++equal[std::minmax(point_of[i], point_of[j])];
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const auto& [pair, count] : equal) {
    const auto looks_of = [&](std::uint32_t p) { return looks.offsets[p + 1] - looks.offsets[p]; };
    const std::size_t fewer = std::min(looks_of(pair.first), looks_of(pair.second));
    if (count < kMinEqualOfPoint || count < fewer) continue;
    pairs.push_back(pair);
    copies->points.push_back(pair.second);
  }
  if (pairs.empty()) return;
  copies->remarks.push_back("the same point under two ids, with equal looks: " +
                            NamesOfPairs(block, pairs) + "; its measurements count twice");
}

}  // namespace

Copies FindCopiedPasses(const Block& block) {
  Copies copies;
  FindPasses(block, &copies);
  return copies;
}

Copies FindCopies(const Block& block) {
  Copies copies = FindCopiedPasses(block);
  FindPoints(block, &copies);
  return copies;
}

std::vector<std::string> FindSameKnownPoints(const Block& block) {
  const auto key = [&](const KnownPosition& known) {
    const Eigen::Vector3d& p_m = block.points.given_m[known.point];
    return std::tuple(p_m.x(), p_m.y(), p_m.z(), known.point);
  };
  std::vector<KnownPosition> known;
  for (const KnownPosition& one : block.points.known) {
    if (block.points.given_m[one.point].allFinite()) known.push_back(one);
  }
  std::sort(known.begin(), known.end(), [&](const KnownPosition& a, const KnownPosition& b) {
    return key(a) < key(b);
  });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::size_t k = 1; k < known.size(); ++k) {
    const std::uint32_t a = known[k - 1].point, b = known[k].point;
    if (block.points.given_m[a] == block.points.given_m[b]) pairs.emplace_back(a, b);
  }
  if (pairs.empty()) return {};
  return {"known points under two ids, with the same coordinates: " + NamesOfPairs(block, pairs) +
          "; one survey counts as two, and standard deviations come out up to 1.4 times too small: "
          "give the looks of both one id"};
}

void CountOnce(const Copies& copies, Block* block) {
  Looks& looks = block->looks;
  for (const std::size_t look : copies.looks) looks.flags[look] |= Looks::kRejected;
  for (const std::uint32_t point : copies.points) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      looks.flags[i] |= Looks::kRejected;
    }
  }
}

}  // namespace sarblock
