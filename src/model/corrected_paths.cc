// SPDX-License-Identifier: Apache-2.0
#include "corrected_paths.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "geometry/smooth_path.h"

namespace sarblock {
namespace {

ConeTurning MeasureTurning(const FlightPath& path, const PathUse& use) {
  ConeTurning out;
  out.range_m = use.range_m;
  if (!(use.first_s <= use.last_s)) return out;  // no look
  std::vector<double> turning;
  const std::size_t last = path.PieceOf(use.last_s);
  for (std::size_t k = path.PieceOf(use.first_s); k <= last; ++k) {
    const double square = path.PieceVelocity_mps(k).squaredNorm();
    turning.push_back(path.AccelerationMisfit_mps2(k) * use.range_m / square);
    if (turning.back() > ConeTurning::kFolding) ++out.folded;
  }
  out.pieces = turning.size();
  out.largest = *std::max_element(turning.begin(), turning.end());
  out.median = Median(turning);
  return out;
}

/// Part of the standard deviation of azimuth that continuing a reading may be wrong by.
constexpr double kContinued = 1e-7;
/// Part of half a strip over which polynomials that are no cubics are continued.
constexpr double kPartOfStrip = 0.01;
constexpr int kContinuedDegree = 3;
/// Least intervals of a path without noise, and the places where two of them are compared.
constexpr std::size_t kLeastIntervals = 4;
constexpr int kComparedPlaces = 48;
/// The part of these places that two of them must agree at.
constexpr double kAgreeingPart = 0.9;

/// How much of the speed of the cone the accelerations of two paths turn it by, at most at
/// kAgreeingPart of the places from the first look to the last.
double TurnBetween(const FlightPath& path,
                   const FlightPath& finer,
                   const FlightPath& coarser,
                   const PathUse& use) {
  std::vector<double> turn;
  for (int k = 0; k < kComparedPlaces; ++k) {
    const double time_s = use.first_s + (use.last_s - use.first_s) * (k + 0.5) / kComparedPlaces;
    Motion fine, coarse;
    if (!finer.Read(time_s, Acceleration::kOfCubic, &fine) ||
        !coarser.Read(time_s, Acceleration::kOfCubic, &coarse)) {
      continue;
    }
    const double square = path.PieceVelocity_mps(path.PieceOf(time_s)).squaredNorm();
    turn.push_back((fine.acceleration_mps2 - coarse.acceleration_mps2).norm() * use.range_m /
                   square);
  }
  if (turn.empty()) return 0.0;
  const auto place = turn.begin() + static_cast<std::ptrdiff_t>(
                                        kAgreeingPart * static_cast<double>(turn.size() - 1));
  std::nth_element(turn.begin(), place, turn.end());
  return *place;
}

/// The path without the noise of its states: of splines each with half the knots of the one before
/// the coarser of the two whose accelerations differ least. Noise falls with the spacing of the
/// knots to the power 3/2, what they smear of the flight itself rises with its square, and the
/// least difference is between the two (Lepski 1991).
std::optional<FlightPath> WithoutNoise(const FlightPath& path, const PathUse& use) {
  const StateNoise noise = EstimateStateNoise(path.states());
  double ratio_s = noise.velocity_mps > 0.0 ? noise.position_m / noise.velocity_mps : 0.0;
  std::optional<FlightPath> out;
  FlightPath finer = path;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t intervals = (path.states().size() - 1) / 2; intervals >= kLeastIntervals;
       intervals /= 2) {
    const auto pieces = static_cast<double>(finer.states().size() - 1);
    ratio_s = std::max(ratio_s, (path.end_s() - path.start_s()) / pieces);
    std::vector<StateVector> states = FitSpline(finer.states(), intervals, {ratio_s, 1.0});
    if (states.empty()) break;
    FlightPath coarser(std::move(states));
    const double turn = TurnBetween(path, finer, coarser, use);
    if (turn < least) {
      least = turn;
      out = coarser;
    }
    finer = std::move(coarser);
  }
  return out;
}

/// Sum of the corrections along three axes, with time derivatives.
struct AxisSums {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  Eigen::Vector3d third = Eigen::Vector3d::Zero();
  bool used = false, bends = false;  // without bends second and third are 0
  // By functions, then axes: numbers just written one by one are not read in pairs, for which the
  // processor would wait.
  void Add(const TermAtTime& term, const double* x) {
    used = true;
    bends |= term.bends;
    std::array<const double*, 3> coefficient{};  // of each axis that is corrected
    int rank = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (term.components[axis]) coefficient[axis] = x + term.column + term.by_axis * rank++;
    }
    for (std::size_t k = 0; k < term.functions; ++k) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(k) * term.by_function;
      const auto of_axis = [&](std::size_t axis) {
        return coefficient[axis] == nullptr ? 0.0 : coefficient[axis][at];
      };
      const Eigen::Vector3d c(of_axis(0), of_axis(1), of_axis(2));
      value += term.value[k] * c;
      first += term.first[k] * c;
      if (!term.bends) continue;
      second += term.second[k] * c;
      third += term.third[k] * c;
    }
  }
};

/// Track axes of a path at a time, at its nearer end beyond them; NaN where it has none.
Eigen::Matrix3d ConstantAxes(const Frame& frame, const FlightPath& path, double time_s) {
  Motion motion;
  if (!path.Evaluate(std::clamp(time_s, path.start_s(), path.end_s()), &motion)) {
    return Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  return TrackAxesOf(frame, motion).axes;
}

}  // namespace

CorrectedPath::CorrectedPath(const Frame& frame,
                             const FlightPath& path,
                             const PassCorrections& corrections,
                             const PathUse& use,
                             const Simplified& simplified)
    : frame_(&frame),
      path_(&path),
      corrections_(&corrections),
      turning_(MeasureTurning(path, use)) {
  if (simplified.flat_frame) {
    plane_ = Plane{frame.VerticalAt(simplified.middle_m), simplified.middle_m};
  }
  if (use.first_s <= use.last_s) {
    const double most = corrections.time_bias.empty() ? kMaxTurn : kSteadyTurn;
    if (turning_.largest > most) smooth_ = WithoutNoise(path, use);
    if (!ReadsAtCrossing()) anchor_step_s_ = AnchorStep_s(use.azimuth_sigma_m);
  }
  if (!corrections.NeedsTrackAxes()) return;
  if (simplified.fixed_track_axes || (frame.kind() == FrameKind::kLocal && path.IsStraight())) {
    axes_ = TrackAxesUse::kConstant;
    constant_axes_ = ConstantAxes(frame, path, corrections.middle_s);
  } else {
    axes_ = TrackAxesUse::kTurning;
    verticals_ = VerticalTable(frame, path);
  }
}

double CorrectedPath::AnchorStep_s(double sigma_m) const {
  const PassCorrections& c = *corrections_;
  if (c.time_bias.empty()) return 0.0;
  double step_s = std::numeric_limits<double>::infinity();
  if (turning_.largest > 0.0) {
    const double speed_mps = path_->PieceVelocity_mps(path_->PieceOf(c.middle_s)).norm();
    step_s = 2.0 * kContinued * sigma_m / (turning_.largest * speed_mps);
  }
  for (const PolynomialTerm& term : c.polynomials) {
    if (term.degree <= kContinuedDegree) continue;
    step_s = std::min(step_s, kPartOfStrip * c.half_length_s);
  }
  return std::isfinite(step_s) ? step_s : 0.0;
}

bool CorrectedPath::Anchor(double bias_s, double slack) {
  if (!(anchor_step_s_ > 0.0)) return false;
  if (std::abs(bias_s - anchor_s_) <= (0.5 + slack) * anchor_step_s_) return false;
  anchor_s_ = anchor_step_s_ * std::round(bias_s / anchor_step_s_);
  return true;
}

bool CorrectedPath::ReadNominal(double measured_s,
                                double read_s,
                                Motion* out,
                                std::size_t* piece) const {
  if (!smooth_) return path_->Read(read_s, Acceleration::kOfCubic, out, piece);
  Motion recorded, without_noise;
  if (!path_->Read(measured_s, Acceleration::kOfCubic, &recorded, piece) ||
      !smooth_->Read(measured_s, Acceleration::kOfCubic, &without_noise)) {
    return false;
  }
  if (read_s == measured_s) {
    *out = {recorded.position_m,
            recorded.velocity_mps,
            without_noise.acceleration_mps2,
            without_noise.jerk_mps3};
    return true;
  }
  if (!smooth_->Read(read_s, Acceleration::kOfCubic, out)) return false;
  if (piece != nullptr) *piece = path_->PieceOf(read_s);
  const Eigen::Vector3d noise_mps = recorded.velocity_mps - without_noise.velocity_mps;
  out->position_m +=
      (recorded.position_m - without_noise.position_m) + (read_s - measured_s) * noise_mps;
  out->velocity_mps += noise_mps;
  return true;
}

Vertical CorrectedPath::DelayVerticalAt(const Eigen::Vector3d& p_m) const {
  if (!plane_) return frame_->VerticalAt(p_m);
  Vertical plane = plane_->middle;
  plane.height_m += plane.up.dot(p_m - plane_->middle_m);
  plane.dup_dp.setZero();
  return plane;
}

void TermAtTime::Read(const PassCorrections& pass, const PolynomialTerm& term, double t_s) {
  axes = term.axes;
  components = term.components;
  column = term.column;
  by_axis = term.degree + 1;
  by_function = 1;
  functions = static_cast<std::size_t>(term.degree) + 1;
  bends = term.degree > 1;
  const double rate = 1.0 / pass.half_length_s;
  if (!bends) {  // the usual offset and drift
    value[0] = 1.0;
    value[1] = (t_s - pass.middle_s) * rate;
    first[0] = 0.0;
    first[1] = rate;
    return;
  }
  LegendreValues((t_s - pass.middle_s) / pass.half_length_s,
                 {std::span(value).first(functions),
                  std::span(first).first(functions),
                  std::span(second).first(functions),
                  std::span(third).first(functions)});
  for (std::size_t k = 0; k < functions; ++k) {
    first[k] *= rate;
    second[k] *= rate * rate;
    third[k] *= rate * rate * rate;
  }
}

void TermAtTime::Read(const SplineTerm& term, int first_column, double measured_s, double t_s) {
  axes = term.axes;
  components = term.components;
  column = first_column;
  by_axis = 1;
  by_function = term.component_count;
  functions = 4;
  bends = true;
  term.spline.EvaluatePiece(term.spline.PieceOf(measured_s),
                            t_s,
                            {std::span(value).first(4),
                             std::span(first).first(4),
                             std::span(second).first(4),
                             std::span(third).first(4)});
}

bool CorrectedPath::Read(double measured_s,
                         double read_s,
                         const double* x,
                         PathReading* out) const {
  const PassCorrections& c = *corrections_;
  Motion& motion = out->motion;
  std::size_t piece = 0;
  if (!ReadNominal(measured_s, read_s, &motion, &piece)) return false;
  out->given_mps = motion.velocity_mps;
  out->given_mps2 = motion.acceleration_mps2;
  if (axes_ == TrackAxesUse::kConstant) {
    out->axes = &constant_axes_;
  } else if (axes_ == TrackAxesUse::kTurning) {
    // Where readings move the axes are continued from one place: their acceleration jumps with the
    // jerk of the path.
    const double axes_s = ReadsAtCrossing() ? measured_s : read_s;
    if (axes_s == read_s) {
      out->turning = TrackAxesOf(verticals_.At(piece, axes_s), motion);
    } else {
      Motion there;
      if (!ReadNominal(measured_s, axes_s, &there, &piece)) return false;
      out->turning = TrackAxesOf(verticals_.At(piece, axes_s), there).After(read_s - axes_s);
    }
    out->axes = &out->turning->axes;
  }
  AxisSums track, frame;
  const auto add = [&](const TermAtTime& term) {
    (term.axes == PositionCorrection::Axes::kTrack ? track : frame).Add(term, x);
  };
  for (const PolynomialTerm& term : c.polynomials) {
    TermAtTime& at = out->terms[out->term_count++];
    at.Read(c, term, read_s);
    add(at);
  }
  int column = c.static_columns;
  for (const SplineTerm& term : c.splines) {
    TermAtTime& at = out->terms[out->term_count++];
    at.Read(term, column, measured_s, read_s);
    add(at);
    column += 4 * term.component_count;
  }
  // delta = A c + f and its time derivatives; A turns with the track (docs/theory/flight_path.md).
  if (track.used) {
    const Eigen::Matrix3d& axes = *out->axes;
    motion.position_m += axes * track.value;
    motion.velocity_mps += axes * track.first;
    if (track.bends) {
      motion.acceleration_mps2 += axes * track.second;
      motion.jerk_mps3 += axes * track.third;
    }
    if (out->turning) {
      const TrackAxes& a = *out->turning;
      motion.velocity_mps += a.rate * track.value;
      motion.acceleration_mps2 += a.acceleration * track.value + 2.0 * (a.rate * track.first);
      motion.jerk_mps3 += 3.0 * (a.acceleration * track.first + a.rate * track.second);
    }
  }
  if (frame.used) {
    motion.position_m += frame.value;
    motion.velocity_mps += frame.first;
    if (frame.bends) {
      motion.acceleration_mps2 += frame.second;
      motion.jerk_mps3 += frame.third;
    }
  }
  return motion.position_m.allFinite() && motion.velocity_mps.allFinite();
}

std::vector<PathUse> PathUsesOf(const Block& block) {
  std::vector<PathUse> out(block.passes.size());
  std::vector<std::size_t> last(block.passes.size());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const std::size_t pass = block.looks.pass[i];
    PathUse& use = out[pass];
    use.first_s = std::min(use.first_s, block.looks.time_s[i]);
    use.last_s = std::max(use.last_s, block.looks.time_s[i]);
    use.range_m = std::max(use.range_m, block.looks.range_m[i]);
    last[pass] = i;
  }
  for (std::size_t pass = 0; pass < out.size(); ++pass) {
    PathUse& use = out[pass];
    if (!(use.first_s <= use.last_s)) continue;
    const FlightPath& path = block.passes[pass].path;
    const double speed_mps = path.PieceVelocity_mps(path.PieceOf(use.first_s)).norm();
    use.azimuth_sigma_m = block.ApproximateAzimuthSigma_m(last[pass], speed_mps);
  }
  return out;
}

CorrectedPaths::CorrectedPaths(const Block& block,
                               const ParameterLayout& layout,
                               const Simplified& simplified)
    : layout_(layout) {
  if (simplified.linear_velocity) {
    for (const Pass& pass : block.passes) straightened_.push_back(StraightenedPath(pass));
  }
  const std::vector<PathUse> uses = PathUsesOf(block);
  paths_.reserve(block.passes.size());
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const FlightPath& path = straightened_.empty() ? block.passes[pass].path : straightened_[pass];
    try {
      paths_.emplace_back(block.frame, path, layout.passes[pass], uses[pass], simplified);
    } catch (const InputError& error) {
      throw InputError("pass " + block.passes[pass].id, error.what());
    }
  }
}

bool CorrectedPaths::Anchor(const Eigen::VectorXd& x, double slack) {
  bool changed = false;
  for (std::size_t pass = 0; pass < paths_.size(); ++pass) {
    changed = paths_[pass].Anchor(layout_.TimeBias_s(pass, x), slack) || changed;
  }
  return changed;
}

void CorrectedPaths::AnchorLike(const CorrectedPaths& other) {
  for (std::size_t pass = 0; pass < paths_.size(); ++pass) {
    paths_[pass].AnchorLike(other.paths_[pass]);
  }
}

}  // namespace sarblock
