// SPDX-License-Identifier: Apache-2.0
#include "wander_mistakes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "edits.h"
#include "words.h"

namespace sarblock {
namespace {

using Names = std::vector<std::string>;

enum class Coordinate { kRange, kTime };

/// What a residual tells of the error of its own measurement, in metres or seconds, and its weight.
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
struct Wander {
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
std::vector<Sign> SignsOf(const Facts& facts, const std::string& pass, Coordinate measured) {
  constexpr double kLeastRedundancy_1 = 0.02;
  const Block& block = facts.sample.block;
  const Eigen::Index component = measured == Coordinate::kRange ? 0 : 1;
  std::vector<Sign> out;
  ForLooks(block, {pass}, [&](std::size_t i) {
    if (measured == Coordinate::kTime && block.MeasuresDoppler(i)) return;
    const double whitened_1 = facts.residuals.whitened_1(static_cast<Eigen::Index>(i), component);
    const double redundancy_1 =
        facts.residuals.redundancy_1(static_cast<Eigen::Index>(i), component);
    const double sigma =
        measured == Coordinate::kRange ? block.SigmaOf(i).range_m : TimeSigma_s(block, i);
    if (!std::isfinite(whitened_1) || !std::isfinite(sigma)) return;
    if (!(redundancy_1 > kLeastRedundancy_1)) return;
    out.push_back(
        {block.looks.time_s[i], sigma * whitened_1 / redundancy_1, redundancy_1 / (sigma * sigma)});
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
  constexpr double kLeastPivot_1 = 1e-6;
  std::vector<double> pivots = diagonal;
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0) {
      const double factor = beside[k - 1] / pivots[k - 1];
      pivots[k] -= factor * beside[k - 1];
      right[k] -= factor * right[k - 1];
    }
    if (!(pivots[k] > kLeastPivot_1 * diagonal[k])) return kNotGiven;
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
  constexpr std::size_t kMostPieces = 24, kLooksAPiece = 2;
  /// Of -2 log L: 1e-5 that noise looks so.
  constexpr double kLeastGain_1 = 20.0;
  if (signs.size() < 12) return std::nullopt;
  const auto n = static_cast<double>(signs.size());
  const double span_s = signs.back().time_s - signs.front().time_s;
  if (!(span_s > 0.0)) return std::nullopt;
  std::optional<Curve> best;
  double straight_1 = 0.0, least_1 = 0.0;
  const std::size_t most = std::min(kMostPieces, signs.size() / kLooksAPiece);
  for (std::size_t pieces = 1; pieces <= most; ++pieces) {
    Curve curve{signs.front().time_s, span_s / static_cast<double>(pieces), {}};
    const double rest = FitCurve(signs, pieces, &curve);
    if (!(rest > 0.0)) continue;
    const double cost_1 = n * std::log(rest) + static_cast<double>(pieces + 1) * std::log(n);
    if (pieces == 1) {
      straight_1 = least_1 = cost_1;
    } else if (cost_1 < least_1) {
      least_1 = cost_1;
      best = std::move(curve);
    }
  }
  return straight_1 - least_1 > kLeastGain_1 ? best : std::nullopt;
}

/// The curves of some passes together, scaled to root mean square 1.
Wander Together(const std::vector<std::pair<std::string, Curve>>& curves) {
  Wander out;
  double square = 0.0, values = 0.0;
  for (const auto& [pass, curve] : curves) {
    out.passes.push_back(pass);
    out.pieces += static_cast<int>(curve.values.size());
    out.piece_s += curve.step_s / static_cast<double>(curves.size());
    for (const double value : curve.values) square += value * value;
    values += static_cast<double>(curve.values.size());
  }
  out.rms = std::sqrt(square / values);
  for (const auto& [pass, curve] : curves) {
    Curve scaled = curve;
    for (double& value : scaled.values) value /= out.rms;
    out.curves.emplace(pass, std::move(scaled));
  }
  return out;
}

Hypothesis Wandering(Coordinate measured, Wander found) {
  const auto wander = std::make_shared<const Wander>(std::move(found));
  const bool range = measured == Coordinate::kRange;
  Hypothesis out;
  out.kind = range ? MistakeKind::kRange : MistakeKind::kTime;
  out.cause = range ? "range.wander" : "time.wander";
  out.passes = wander->passes;
  // Residuals are predicted less measured: what is added to a measurement undoes its error.
  out.undo = [wander, range](Block* block, double value) {
    ForLooks(*block, wander->passes, [&](std::size_t i) {
      Looks& looks = block->looks;
      const Curve& curve = wander->curves.at(block->passes[looks.pass[i]].id);
      (range ? looks.range_m : looks.time_s)[i] += value * curve.At(looks.time_s[i]);
    });
  };
  out.parameters = wander->pieces;
  out.most_left_1 = 10.0;
  out.free = true;
  out.value = wander->rms;
  out.step = 0.1 * wander->rms;
  out.unit = range ? "m" : "s";
  out.says = [wander, range](const Size& size) {
    return std::string("errors of the ") + (range ? "ranges" : "times") + " " +
           OfPasses(wander->passes) + " are correlated in time: they wander along the strip by " +
           size.text + " (root mean square) and keep their sign for some " +
           Short(wander->piece_s) + " s";
  };
  out.change = [wander, range](const Size&) {
    return "block.toml: a spline in [adjust.correction.position] with knot_spacing_s = " +
           Short(wander->piece_s) + " for " + PassWords(wander->passes) +
           " if its flight path wanders so, else standard deviations of the " +
           (range ? "ranges" : "times") + " with that error in them";
  };
  out.screened = true;
  out.local = true;
  return out;
}

}  // namespace

void AddWanderMistakes(const Facts& facts, Hypotheses* out) {
  if (!facts.before.solved) return;
  for (const Coordinate measured : {Coordinate::kRange, Coordinate::kTime}) {
    std::vector<std::pair<std::string, Curve>> curves;
    for (const Pass& pass : facts.sample.block.passes) {
      if (auto curve = FindCurve(SignsOf(facts, pass.id, measured))) {
        curves.emplace_back(pass.id, std::move(*curve));
      }
    }
    for (const auto& curve : curves) out->push_back(Wandering(measured, Together({curve})));
    if (curves.size() > 1) out->push_back(Wandering(measured, Together(curves)));
  }
}

}  // namespace sarblock
