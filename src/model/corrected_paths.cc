// SPDX-License-Identifier: Apache-2.0
#include "corrected_paths.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

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

/// Part of the standard deviation of azimuth that continuing a reading may be wrong by: on a path
/// without noise, and where states are noisy, which is as wrong at any place.
constexpr double kContinued = 1e-7, kContinuedNoisy = 0.01;
/// Part of half a strip over which polynomials that are no cubics are continued.
constexpr double kPartOfStrip = 0.01;
constexpr int kContinuedDegree = 3;
/// Readings of the velocity by which an acceleration is found, evenly over a window.
constexpr int kSlopeReadings = 9;
/// Windows, each twice as long as the one before, and the places where they are compared.
constexpr int kWindows = 12;
constexpr int kComparedPlaces = 48;

/// Slope of the straight line through the velocities within `half_s` of a time by least squares;
/// near an end of the path the window lies inside it.
Eigen::Vector3d VelocitySlope_mps2(const FlightPath& path, double time_s, double half_s) {
  const double middle_s =
      std::clamp(time_s,
                 std::min(path.start_s() + half_s, 0.5 * (path.start_s() + path.end_s())),
                 std::max(path.end_s() - half_s, 0.5 * (path.start_s() + path.end_s())));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares_s2 = 0.0;
  constexpr int kHalf = kSlopeReadings / 2;
  for (int k = -kHalf; k <= kHalf; ++k) {
    const double after_s = half_s * k / kHalf;
    Motion motion;
    if (!path.Evaluate(std::clamp(middle_s + after_s, path.start_s(), path.end_s()), &motion)) {
      continue;
    }
    sum += after_s * motion.velocity_mps;
    squares_s2 += after_s * after_s;
  }
  return sum / squares_s2;
}

/// Sum of the corrections along three axes, with time derivatives.
struct AxisSums {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  Eigen::Vector3d third = Eigen::Vector3d::Zero();
  bool used = false;
  void Add(const TermAtTime& term, const double* x) {
    used = true;
    int rank = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!term.components[static_cast<std::size_t>(axis)]) continue;
      double sum = 0.0, by_t = 0.0, by_tt = 0.0, by_ttt = 0.0;
      const double* coefficient = x + term.column + term.by_axis * rank++;
      for (std::size_t k = 0; k < term.functions; ++k, coefficient += term.by_function) {
        sum += *coefficient * term.value[k];
        by_t += *coefficient * term.first[k];
        by_tt += *coefficient * term.second[k];
        by_ttt += *coefficient * term.third[k];
      }
      value[axis] += sum;
      first[axis] += by_t;
      second[axis] += by_tt;
      third[axis] += by_ttt;
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
    if (turning_.largest > kMaxTurn) steady_ = FindSteadyAcceleration(path, use);
    anchor_step_s_ = AnchorStep_s(use.azimuth_sigma_m);
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

// The shortest window whose accelerations agree with those of one twice as long: noise falls with
// the window's length to the power 3/2, what a longer window smears of the flight itself rises with
// its square, and the first to agree is between the two (Lepski 1991).
CorrectedPath::SteadyAcceleration CorrectedPath::FindSteadyAcceleration(const FlightPath& path,
                                                                        const PathUse& use) {
  const double first_s = use.first_s, last_s = use.last_s;
  const double most_s = 0.25 * (path.end_s() - path.start_s());
  const std::size_t middle = path.PieceOf(0.5 * (first_s + last_s));
  double half_s = std::min(most_s, path.PieceEnd_s(middle) - path.PieceStart_s(middle));
  double best_s = half_s;
  SteadyAcceleration out;
  out.noise = std::numeric_limits<double>::infinity();
  std::vector<double> change;
  for (int window = 0; window < kWindows && 2.0 * half_s <= most_s; ++window, half_s *= 2.0) {
    change.clear();
    for (int k = 0; k < kComparedPlaces; ++k) {
      const double time_s = first_s + (last_s - first_s) * (k + 0.5) / kComparedPlaces;
      const double square = path.PieceVelocity_mps(path.PieceOf(time_s)).squaredNorm();
      const Eigen::Vector3d change_mps2 =
          VelocitySlope_mps2(path, time_s, 2.0 * half_s) - VelocitySlope_mps2(path, time_s, half_s);
      change.push_back(change_mps2.norm() * use.range_m / square);
    }
    const double median = MedianInPlace(&change);
    if (median < out.noise) {
      out.noise = median;
      best_s = 2.0 * half_s;
    }
    if (median <= kMaxTurn) break;
  }
  out.step_s = 0.5 * best_s;
  // Over the whole path: a time bias may read anywhere.
  out.start_s =
      first_s - std::ceil(std::max(0.0, first_s - path.start_s()) / out.step_s) * out.step_s;
  const double end_s = std::max(last_s, path.end_s());
  const auto knots = static_cast<std::size_t>((end_s - out.start_s) / out.step_s) + 2;
  for (std::size_t k = 0; k < knots; ++k) {
    const double time_s = out.start_s + static_cast<double>(k) * out.step_s;
    out.knots_mps2.push_back(VelocitySlope_mps2(path, time_s, best_s));
  }
  return out;
}

double CorrectedPath::AnchorStep_s(double sigma_m) const {
  const PassCorrections& c = *corrections_;
  if (c.time_bias.empty()) return 0.0;
  double step_s = std::numeric_limits<double>::infinity();
  const double turning = IsNoisy() ? steady_.noise : turning_.largest;
  if (turning > 0.0) {
    const double speed_mps = path_->PieceVelocity_mps(path_->PieceOf(c.middle_s)).norm();
    const double part = turning_.largest > kSteadyTurn ? kContinuedNoisy : kContinued;
    step_s = 2.0 * part * sigma_m / (turning * speed_mps);
  }
  for (const PolynomialTerm& term : c.polynomials) {
    if (term.degree <= kContinuedDegree) continue;
    step_s = std::min(step_s, kPartOfStrip * c.half_length_s);
  }
  return std::isfinite(step_s) ? step_s : 0.0;
}

bool CorrectedPath::Anchor(double bias_s, double slack) {
  if (!LeavesAnchor(bias_s, slack)) return false;
  anchor_s_ = anchor_step_s_ * std::round(bias_s / anchor_step_s_);
  return true;
}

bool CorrectedPath::ReadNominal(double time_s, Motion* out, std::size_t* piece) const {
  if (!path_->Read(time_s, Acceleration::kOfCubic, out, piece)) return false;
  const std::size_t knots = steady_.knots_mps2.size();
  if (knots == 0) return true;
  const double place =
      std::clamp((time_s - steady_.start_s) / steady_.step_s, 0.0, static_cast<double>(knots - 1));
  const auto k = std::min(static_cast<std::size_t>(place), knots - 2);
  const double part = place - static_cast<double>(k);
  const Eigen::Vector3d change_mps2 = steady_.knots_mps2[k + 1] - steady_.knots_mps2[k];
  out->acceleration_mps2 = steady_.knots_mps2[k] + part * change_mps2;
  out->jerk_mps3 = change_mps2 / steady_.step_s;
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
  const double rate = 1.0 / pass.half_length_s;
  if (term.degree <= 1) {  // the usual offset and drift
    value[0] = 1.0;
    value[1] = (t_s - pass.middle_s) * rate;
    first[0] = 0.0;
    first[1] = rate;
    second[0] = second[1] = third[0] = third[1] = 0.0;
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
  if (!ReadNominal(read_s, &motion, &piece)) return false;
  if (axes_ == TrackAxesUse::kConstant) {
    out->axes = &constant_axes_;
  } else if (axes_ == TrackAxesUse::kTurning) {
    out->turning = TrackAxesOf(verticals_.At(piece, read_s), motion);
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
    motion.acceleration_mps2 += axes * track.second;
    motion.jerk_mps3 += axes * track.third;
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
    motion.acceleration_mps2 += frame.second;
    motion.jerk_mps3 += frame.third;
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

bool CorrectedPaths::Anchor(const Eigen::VectorXd& x, double slack, Anchors which) {
  bool changed = false;
  for (std::size_t pass = 0; pass < paths_.size(); ++pass) {
    const bool noisy = paths_[pass].HasNoisyAnchor();
    if (which != Anchors::kAll && noisy != (which == Anchors::kNoisy)) continue;
    changed = paths_[pass].Anchor(layout_.TimeBias_s(pass, x), slack) || changed;
  }
  return changed;
}

bool CorrectedPaths::LeaveNoisyAnchors(const Eigen::VectorXd& x, double slack) const {
  for (std::size_t pass = 0; pass < paths_.size(); ++pass) {
    const CorrectedPath& path = paths_[pass];
    if (path.HasNoisyAnchor() && path.LeavesAnchor(layout_.TimeBias_s(pass, x), slack)) return true;
  }
  return false;
}

bool CorrectedPaths::HasNoisyAnchors() const {
  return std::any_of(paths_.begin(), paths_.end(), [](const CorrectedPath& path) {
    return path.HasNoisyAnchor();
  });
}

void CorrectedPaths::AnchorLike(const CorrectedPaths& other) {
  for (std::size_t pass = 0; pass < paths_.size(); ++pass) {
    paths_[pass].AnchorLike(other.paths_[pass]);
  }
}

}  // namespace sarblock
