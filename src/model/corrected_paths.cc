// SPDX-License-Identifier: Apache-2.0
#include "corrected_paths.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <limits>
#include <span>

namespace sarblock {
namespace {

/// First and last time and largest range that each pass measured.
struct Span {
  double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s, range_m = 0.0;
};

std::vector<Span> SpansOf(const Block& block) {
  std::vector<Span> out(block.passes.size());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    Span& span = out[block.looks.pass[i]];
    span.first_s = std::min(span.first_s, block.looks.time_s[i]);
    span.last_s = std::max(span.last_s, block.looks.time_s[i]);
    span.range_m = std::max(span.range_m, block.looks.range_m[i]);
  }
  return out;
}

ConeTurning MeasureTurning(const FlightPath& path, const Span& span) {
  ConeTurning out;
  out.range_m = span.range_m;
  if (!(span.first_s <= span.last_s)) return out;  // no look
  std::vector<double> turning_1;
  const std::size_t last = path.PieceOf(span.last_s);
  for (std::size_t k = path.PieceOf(span.first_s); k <= last; ++k) {
    const double square = path.PieceVelocity_mps(k).squaredNorm();
    turning_1.push_back(path.AccelerationMisfit_mps2(k) * span.range_m / square);
    if (turning_1.back() > ConeTurning::kFolding_1) ++out.folded;
  }
  out.pieces = turning_1.size();
  out.largest_1 = *std::max_element(turning_1.begin(), turning_1.end());
  out.median_1 = Median(turning_1);
  return out;
}

/// Sum of the corrections along three axes, with time derivatives.
struct AxisSums {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  bool used = false;
  void Add(const TermAtTime& term, const double* x) {
    used = true;
    int rank = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!term.components[static_cast<std::size_t>(axis)]) continue;
      double sum = 0.0, by_t = 0.0, by_tt = 0.0;
      const double* coefficient = x + term.column + term.by_axis * rank++;
      for (std::size_t k = 0; k < term.functions; ++k, coefficient += term.by_function) {
        sum += *coefficient * term.value[k];
        by_t += *coefficient * term.first[k];
        by_tt += *coefficient * term.second[k];
      }
      value[axis] += sum;
      first[axis] += by_t;
      second[axis] += by_tt;
    }
  }
};

VerticalTable VerticalsOf(const Block& block, std::size_t pass, const FlightPath& path) {
  try {
    return VerticalTable(block.frame, path);
  } catch (const InputError& error) {
    throw InputError("pass " + block.passes[pass].id, error.what());
  }
}

}  // namespace

CorrectedPaths::CorrectedPaths(const Block& block,
                               const ParameterLayout& layout,
                               const Simplified& simplified)
    : block_(block), layout_(layout), rules_(block.passes.size()) {
  if (simplified.linear_velocity) {
    for (const Pass& pass : block.passes) straightened_.push_back(StraightenedPath(pass));
  }
  const std::vector<Span> spans = SpansOf(block);
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const FlightPath& path = PathOf(pass);
    Rule& rule = rules_[pass];
    rule.turning = MeasureTurning(path, spans[pass]);
    rule.acceleration = rule.turning.largest_1 <= kMostTurn_1 ? Acceleration::kOfCubic
                                                              : Acceleration::kOfVelocities;
    if (!layout.passes[pass].NeedsTrackAxes()) continue;
    if (simplified.fixed_track_axes ||
        (block.frame.kind() == FrameKind::kLocal && path.IsStraight())) {
      rule.axes = TrackAxesUse::kConstant;
      rule.axes_1 = AxesInTheMiddle(block.frame, path, block.passes[pass]);
    } else {
      rule.axes = TrackAxesUse::kTurning;
      rule.verticals = VerticalsOf(block, pass, path);
    }
  }
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
    second[0] = second[1] = 0.0;
    return;
  }
  LegendreValues((t_s - pass.middle_s) / pass.half_length_s,
                 {std::span(value).first(functions),
                  std::span(first).first(functions),
                  std::span(second).first(functions)});
  for (std::size_t k = 0; k < functions; ++k) {
    first[k] *= rate;
    second[k] *= rate * rate;
  }
}

void TermAtTime::Read(const SplineTerm& term, int first_column, double measured_s, double t_s) {
  axes = term.axes;
  components = term.components;
  column = first_column;
  by_axis = 1;
  by_function = term.component_count;
  functions = 4;
  term.spline.EvaluatePiece(
      term.spline.PieceOf(measured_s),
      t_s,
      {std::span(value).first(4), std::span(first).first(4), std::span(second).first(4)});
}

bool CorrectedPaths::Read(
    std::size_t pass, double measured_s, double path_s, const double* x, PathReading* out) const {
  const PassCorrections& c = layout_.passes[pass];
  const FlightPath& path = PathOf(pass);
  const Rule& rule = rules_[pass];
  Motion& motion = out->motion;
  std::size_t piece = 0;
  if (!path.Read(path_s, rule.acceleration, &motion, &piece)) return false;
  out->beyond_path = path_s < path.start_s() || path_s > path.end_s();
  if (rule.axes == TrackAxesUse::kConstant) {
    out->axes_1 = &rule.axes_1;
  } else if (rule.axes == TrackAxesUse::kTurning) {
    out->turning = TrackAxesOf(rule.verticals.At(piece, path_s), motion);
    out->axes_1 = &out->turning->axes_1;
  }
  AxisSums track, frame;
  const auto add = [&](const TermAtTime& term) {
    (term.axes == PositionCorrection::Axes::kTrack ? track : frame).Add(term, x);
  };
  for (const PolynomialTerm& term : c.polynomials) {
    TermAtTime& at = out->terms[out->term_count++];
    at.Read(c, term, path_s);
    add(at);
  }
  int column = c.static_columns;
  for (const SplineTerm& term : c.splines) {
    TermAtTime& at = out->terms[out->term_count++];
    at.Read(term, column, measured_s, path_s);
    add(at);
    column += 4 * term.component_count;
  }
  // delta = A c + f and its time derivatives; A turns with the track (docs/theory/flight_path.md).
  if (track.used) {
    const Eigen::Matrix3d& axes_1 = *out->axes_1;
    motion.position_m += axes_1 * track.value;
    motion.velocity_mps += axes_1 * track.first;
    motion.acceleration_mps2 += axes_1 * track.second;
    if (out->turning) {
      const TrackAxes& a = *out->turning;
      motion.velocity_mps += a.rate * track.value;
      motion.acceleration_mps2 += a.acceleration * track.value + 2.0 * (a.rate * track.first);
    }
  }
  if (frame.used) {
    motion.position_m += frame.value;
    motion.velocity_mps += frame.first;
    motion.acceleration_mps2 += frame.second;
  }
  return motion.position_m.allFinite() && motion.velocity_mps.allFinite();
}

}  // namespace sarblock
