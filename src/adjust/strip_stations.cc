// SPDX-License-Identifier: Apache-2.0
#include "strip_stations.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "geometry/track_axes.h"
#include "model/look_model.h"

namespace sarblock {
namespace {

/// Covariances of a result by pair of parameters.
class CovarianceOfPairs {
 public:
  explicit CovarianceOfPairs(const std::vector<ParameterCovariance>& list) {
    of_pair_.reserve(list.size());
    for (const ParameterCovariance& entry : list)
      of_pair_[Key(entry.a, entry.b)] = entry.covariance;
  }
  /// NaN where the result has none.
  [[nodiscard]] double Of(std::uint32_t a, std::uint32_t b) const {
    const auto found = of_pair_.find(Key(std::min(a, b), std::max(a, b)));
    return found == of_pair_.end() ? kNotGiven : found->second;
  }

 private:
  static std::uint64_t Key(std::uint32_t a, std::uint32_t b) {
    return (static_cast<std::uint64_t>(a) << 32U) | b;
  }
  std::unordered_map<std::uint64_t, double> of_pair_;
};

/// One parameter of a pass at one time: delta(t), in track axes, by it.
struct Influence {
  std::uint32_t parameter = 0;
  Eigen::Vector3d by_parameter_1 = Eigen::Vector3d::Zero();
};

/// What the looks of a pass reach.
struct Reach {
  double near_m = kNotGiven, far_m = kNotGiven;
  double height_m = kNotGiven;
  Cone cone;
};

class Sampler {
 public:
  Sampler(const Block& block,
          const std::vector<CorrectionGroup>& groups,
          const AdjustResult& result)
      : block_(block),
        result_(result),
        layout_(MakeParameterLayout(block, groups)),
        model_(block, layout_, result.selection.simplified),
        corrected_(layout_.size() > 0 &&
                   static_cast<std::size_t>(layout_.size()) == result.parameters.size()),
        covariance_(result.parameter_covariance),
        reach_(Reaches()) {}

  void Sample(std::uint32_t pass, std::vector<StripStation>* out) const {
    const Pass& source = block_.passes[pass];
    const std::size_t count = StationCount(pass);
    for (std::size_t k = 0; k < count; ++k) {
      StripStation station;
      station.pass = pass;
      const double part = static_cast<double>(k) / static_cast<double>(count - 1);
      station.strip_time_1 = 2.0 * part - 1.0;
      station.time_s = source.start_s + part * (source.end_s - source.start_s);
      const auto motion = source.path.At(station.time_s);
      if (!motion) continue;
      station.antenna_m = motion->position_m;
      PlaceEdges(reach_[pass], source, *motion, &station);
      if (corrected_) Correct(pass, *motion, &station);
      out->push_back(station);
    }
  }

 private:
  std::size_t StationCount(std::uint32_t pass) const {
    std::size_t count = kStripStations;
    if (!corrected_) return count;
    for (const SplineTerm& term : layout_.passes[pass].splines) {
      const double pieces =
          (block_.passes[pass].end_s - block_.passes[pass].start_s) / term.spline.spacing_s();
      const auto wanted = static_cast<std::size_t>(4.0 * std::min(pieces, 1e6)) + 1;
      count = std::max(count, std::min(wanted, kMostStripStations));
    }
    return count;
  }

  std::vector<Reach> Reaches() const {
    const std::size_t passes = block_.passes.size();
    std::vector<Reach> out(passes);
    std::vector<double> from_middle_s(passes, kNotGiven);
    std::vector<std::vector<double>> heights_m(passes);
    for (std::size_t point = 0; point < block_.points.size(); ++point) {
      const Eigen::Vector3d& p = result_.points.position_m[point];
      if (!p.allFinite()) continue;
      const double height_m = block_.frame.VerticalAt(p).height_m;
      for (std::size_t i = block_.looks.offsets[point]; i < block_.looks.offsets[point + 1]; ++i) {
        if (block_.looks.rejected(i) || !std::isfinite(block_.looks.range_m[i])) continue;
        const std::uint32_t pass = block_.looks.pass[i];
        Reach& reach = out[pass];
        reach.near_m = std::fmin(reach.near_m, block_.looks.range_m[i]);
        reach.far_m = std::fmax(reach.far_m, block_.looks.range_m[i]);
        heights_m[pass].push_back(height_m);
        const Pass& source = block_.passes[pass];
        const double apart_s =
            std::abs(block_.looks.time_s[i] - 0.5 * (source.start_s + source.end_s));
        if (!(apart_s >= from_middle_s[pass])) {
          from_middle_s[pass] = apart_s;
          reach.cone = model_.block().ConeOf(i);
        }
      }
    }
    for (std::size_t pass = 0; pass < passes; ++pass) {
      if (!heights_m[pass].empty()) out[pass].height_m = MedianInPlace(&heights_m[pass]);
    }
    return out;
  }

  void PlaceEdges(const Reach& reach,
                  const Pass& pass,
                  const Motion& motion,
                  StripStation* station) const {
    if (!std::isfinite(reach.height_m)) return;
    Sight sight;
    sight.antenna_m = motion.position_m;
    sight.velocity_mps = motion.velocity_mps;
    sight.acceleration_mps2 = motion.acceleration_mps2;
    sight.cone = reach.cone;
    sight.side = pass.side == LookSide::kLeft ? +1 : -1;
    const auto place = [&](double range_m, Eigen::Vector3d* edge_m) {
      sight.range_m = range_m;
      const Intersection met = IntersectWithHeight(sight, block_.frame, reach.height_m);
      if (met.outcome == IntersectionOutcome::kDetermined) *edge_m = met.position_m;
    };
    place(reach.near_m, &station->near_m);
    place(reach.far_m, &station->far_m);
  }

  void AddInfluence(std::uint32_t parameter,
                    PositionCorrection::Axes axes,
                    const TrackAxes& track,
                    int axis,
                    double value_1,
                    std::vector<Influence>* out) const {
    Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
    if (axes == PositionCorrection::Axes::kFrame) unit = track.axes_1.transpose() * unit;
    out->push_back({parameter, value_1 * unit});
  }

  std::vector<Influence> InfluencesAt(std::uint32_t pass,
                                      double time_s,
                                      const TrackAxes& track) const {
    std::vector<Influence> out;
    const PassCorrections& corrections = layout_.passes[pass];
    std::vector<std::uint32_t> parameter;  // by static local column
    for (const int b : corrections.blocks) {
      const ParameterBlock& block = layout_.blocks[static_cast<std::size_t>(b)];
      for (int i = 0; i < block.size; ++i) {
        parameter.push_back(static_cast<std::uint32_t>(block.offset + i));
      }
    }
    const double x = (time_s - corrections.middle_s) / corrections.half_length_s;
    for (const PolynomialTerm& term : corrections.polynomials) {
      const auto size = static_cast<std::size_t>(term.degree) + 1;
      std::array<std::array<double, PositionCorrection::kMaxDegree + 1>, 3> values;
      LegendreValues(x,
                     {std::span(values[0]).first(size),
                      std::span(values[1]).first(size),
                      std::span(values[2]).first(size)});
      auto column = static_cast<std::size_t>(term.column);
      for (int axis = 0; axis < 3; ++axis) {
        if (!term.components[static_cast<std::size_t>(axis)]) continue;
        for (std::size_t k = 0; k < size; ++k, ++column) {
          AddInfluence(parameter[column], term.axes, track, axis, values[0][k], &out);
        }
      }
    }
    for (const SplineTerm& term : corrections.splines) {
      std::array<std::array<double, 4>, 3> values;
      const std::size_t first = term.spline.Evaluate(
          time_s, {std::span(values[0]), std::span(values[1]), std::span(values[2])});
      for (std::size_t q = 0; q < 4; ++q) {
        const ParameterBlock& block =
            layout_.blocks[static_cast<std::size_t>(term.first_block) + first + q];
        int column = block.offset;
        for (int axis = 0; axis < 3; ++axis) {
          if (!term.components[static_cast<std::size_t>(axis)]) continue;
          AddInfluence(
              static_cast<std::uint32_t>(column++), term.axes, track, axis, values[0][q], &out);
        }
      }
    }
    return out;
  }

  void Correct(std::uint32_t pass, const Motion& motion, StripStation* station) const {
    const TrackAxes track = TrackAxesOf(block_.frame, motion);
    const std::vector<Influence> influences = InfluencesAt(pass, station->time_s, track);
    if (influences.empty()) return;
    station->correction_m.setZero();
    Eigen::Vector3d variance_m2 = Eigen::Vector3d::Zero();
    for (const Influence& a : influences) {
      station->correction_m += result_.parameters[a.parameter].value * a.by_parameter_1;
      for (const Influence& b : influences) {
        const Eigen::Vector3d product = a.by_parameter_1.cwiseProduct(b.by_parameter_1);
        if (product.isZero(0.0)) continue;
        variance_m2 += covariance_.Of(a.parameter, b.parameter) * product;
      }
    }
    station->correction_sigma_m = variance_m2.cwiseSqrt();
  }

  const Block& block_;
  const AdjustResult& result_;
  ParameterLayout layout_;
  LookModel model_;
  bool corrected_;
  CovarianceOfPairs covariance_;
  std::vector<Reach> reach_;
};

}  // namespace

std::vector<StripStation> SampleStrips(const Block& block,
                                       const std::vector<CorrectionGroup>& groups,
                                       const AdjustResult& result) {
  const Sampler sampler(block, groups, result);
  std::vector<StripStation> out;
  for (std::uint32_t pass = 0; pass < block.passes.size(); ++pass) sampler.Sample(pass, &out);
  return out;
}

}  // namespace sarblock
