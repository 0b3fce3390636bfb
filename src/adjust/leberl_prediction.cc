// SPDX-License-Identifier: Apache-2.0
#include "leberl_prediction.h"

#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/threads.h"
#include "leberl/rigorous.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

constexpr std::size_t kPredictionsPerChunk = 1024;
constexpr std::size_t kLooksPairedWithAll = 6;
/// A correction without a prior that moves the range by less than this part of itself (an along
/// shift given in frame axes, say) leaves the path sigma known.
constexpr double kNoEffect = 1e-2;
/// Across directions of two points whose difference is still one across difference.
constexpr double kSameDirection_rad = 10.0 * kRadPerDeg;

leberl::Triple ToTriple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// A look that can be one of a pair.
struct Candidate {
  std::size_t look = 0;
  FixedPathLook observation;
  leberl::ReducedLook reduced;
  double range_sigma_m = 0.0;
};

struct BestPair {
  std::size_t first = 0, second = 0;  // look indices
  leberl::StereoConfiguration configuration;
  leberl::RangeNoise noise;
  double across_azimuth_rad = 0.0;
};

/// What an error does to the point: of one correction, as large as its prior sigma, or of a range,
/// of one metre.
struct Effect {
  int parameter = 0;  // of a joint prior the place of the column of its factor; 0 of a range
  double across_m = 0.0;
  double up_m = 0.0;
};

struct Prediction {
  std::optional<BestPair> best;
  std::vector<Effect> effects;  // ascending by parameter
  bool path_known = true;
};

/// Corrections that enter Eq. 14 and 15. Along, velocity, time and squint act through the Doppler
/// planes alone (Eq. 13).
std::vector<std::uint8_t> EntersRange(const ParameterLayout& layout) {
  std::vector<std::uint8_t> enters;
  for (const Parameter& parameter : layout.parameters) {
    switch (parameter.kind) {
      case ParameterKind::kPosition:
        enters.push_back(parameter.axes != PositionCorrection::Axes::kTrack || parameter.axis != 0);
        break;
      case ParameterKind::kRangeBias:
      case ParameterKind::kRangeScale:
      case ParameterKind::kZenithDelay:
        enters.push_back(1);
        break;
      default:
        enters.push_back(0);
    }
  }
  return enters;
}

class Predictor {
 public:
  Predictor(const AdjustmentProblem& problem,
            const BlockState& state,
            const std::vector<std::uint8_t>& enters)
      : problem_(problem), state_(state), enters_(enters) {}

  void Predict(std::size_t point, Prediction* out) {
    out->best.reset();
    out->effects.clear();
    out->path_known = true;
    GatherCandidates(point);
    FindBest(state_.Position(point), &out->best);
    if (!out->best || problem_.layout.size() == 0) return;
    AddEffects(point, out->best->first, &leberl::StereoErrors::first, out);
    AddEffects(point, out->best->second, &leberl::StereoErrors::second, out);
    JoinEffects(&out->effects);
  }

 private:
  void GatherCandidates(std::size_t point) {
    candidates_.clear();
    const Looks& looks = problem_.block.looks;
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem_.look_used[i] == 0) continue;
      const auto observation = problem_.model.FixPath(i, state_.corrections);
      if (!observation) continue;
      candidates_.push_back(
          {i,
           *observation,
           {ToTriple(observation->antenna_m), ToTriple(observation->velocity_mps)},
           observation->range_sigma_m});
    }
  }

  void FindBest(const Eigen::Vector3d& p_m, std::optional<BestPair>* best) {
    if (candidates_.size() < 2) return;
    const Eigen::Vector3d up = problem_.block.frame.VerticalAt(p_m).up;
    std::size_t far = 0;
    if (candidates_.size() > kLooksPairedWithAll) {
      double widest_rad = -1.0;
      for (std::size_t i = 1; i < candidates_.size(); ++i) {
        const double rad =
            IntersectionAngle(p_m, candidates_[0].observation, candidates_[i].observation);
        if (rad > widest_rad) {
          widest_rad = rad;
          far = i;
        }
      }
    }
    double smallest_m2 = std::numeric_limits<double>::infinity();
    const Candidate *first = nullptr, *second = nullptr;
    BestPair pair;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      for (std::size_t j = i + 1; j < candidates_.size(); ++j) {
        if (far != 0 && i != 0 && i != far && j != far) continue;
        const Candidate &a = candidates_[i], &b = candidates_[j];
        const auto c = leberl::ReducePair(ToTriple(p_m), ToTriple(up), a.reduced, b.reduced);
        if (!c) continue;
        const auto noise = leberl::NoiseOfRange(*c, a.range_sigma_m, b.range_sigma_m);
        const double size_m2 =
            noise.sigma_y_m * noise.sigma_y_m + noise.sigma_z_m * noise.sigma_z_m;
        if (!(size_m2 < smallest_m2)) continue;
        smallest_m2 = size_m2;
        first = &a;
        second = &b;
        pair = {a.look, b.look, *c, noise, 0.0};
      }
    }
    if (first == nullptr) return;
    pair.across_azimuth_rad = AcrossAzimuth(p_m, up, first->observation, second->observation);
    *best = pair;
  }

  /// Azimuth of up x along [rad], clockwise from north; along is the mean track in the first look's
  /// sense, as in the reduction.
  [[nodiscard]] double AcrossAzimuth(const Eigen::Vector3d& p_m,
                                     const Eigen::Vector3d& up,
                                     const FixedPathLook& a,
                                     const FixedPathLook& b) const {
    const Eigen::Vector3d first = a.velocity_mps.normalized();
    const Eigen::Vector3d second = b.velocity_mps.normalized();
    const Eigen::Vector3d along = first + (first.dot(second) < 0.0 ? -1.0 : 1.0) * second;
    const Eigen::Vector3d enu = problem_.block.frame.EnuFromFrame(p_m) * up.cross(along);
    return std::atan2(enu.x(), enu.y());
  }

  /// Eq. 14 and 15 for every correction of one look. A correction that changes the range by g
  /// changes the point as a range error of -g does; for a shift of the antenna in the paper's
  /// frame, -g = (y dy0 - H dz0)/r, this gives the position terms of Eq. 14 and 15 themselves.
  void AddEffects(std::size_t point,
                  std::size_t look,
                  leberl::StationErrors leberl::StereoErrors::*station,
                  Prediction* out) {
    if (!EvaluateLook(problem_.model, state_, point, look, {}, &columns_, &at_)) {
      out->path_known = false;
      return;
    }
    leberl::StereoErrors errors;
    (errors.*station).dr_m = 1.0;
    const Effect of_range{0,
                          AcrossError(out->best->configuration, errors),
                          HeightError(out->best->configuration, errors)};
    Eigen::Index column = 0;
    for (int b = 0; b < columns_.block_count; ++b) {
      const ParameterBlock& block =
          problem_.layout
              .blocks[static_cast<std::size_t>(columns_.block[static_cast<std::size_t>(b)])];
      for (int k = 0; k < block.size; ++k, ++column) {
        const auto parameter = static_cast<std::size_t>(block.offset + k);
        if (enters_[parameter] == 0) continue;
        const Parameter& p = problem_.layout.parameters[parameter];
        const double slope = at_.row[0][static_cast<std::size_t>(column)];
        if (!p.has_prior()) {
          if (std::abs(slope) > kNoEffect) out->path_known = false;
          continue;
        }
        if (p.joint < 0) {
          // The steps of a process and its first coefficient are independent.
          double carried = slope;
          int from = block.offset + k;
          for (const Parameter* at = &p; at->before >= 0;) {
            AddEffect(from, -carried * at->step_sigma, of_range, out);
            carried *= at->carried;
            from = at->before;
            at = &problem_.layout.parameters[static_cast<std::size_t>(from)];
          }
          const auto first = static_cast<std::size_t>(from);
          AddEffect(from, -carried * problem_.layout.parameters[first].prior_sigma, of_range, out);
          continue;
        }
        // The independent errors of a joint prior are the columns of its factor.
        const JointPriorTerm& prior =
            problem_.layout.joint_priors[static_cast<std::size_t>(p.joint)];
        const auto at =
            std::find(prior.parameters.begin(), prior.parameters.end(), block.offset + k);
        const Eigen::Index row = at - prior.parameters.begin();
        for (Eigen::Index q = 0; q <= row; ++q) {
          AddEffect(prior.parameters[static_cast<std::size_t>(q)],
                    -slope * prior.factor(row, q),
                    of_range,
                    out);
        }
      }
    }
  }

  /// The effect of a range error of `dr_m`, given that of one metre.
  static void AddEffect(int source, double dr_m, const Effect& of_range, Prediction* out) {
    out->effects.push_back({source, dr_m * of_range.across_m, dr_m * of_range.up_m});
  }

  /// One entry a correction: a shared one acts on both looks.
  static void JoinEffects(std::vector<Effect>* effects) {
    std::stable_sort(effects->begin(), effects->end(), [](const Effect& a, const Effect& b) {
      return a.parameter < b.parameter;
    });
    std::size_t kept = 0;
    for (const Effect& effect : *effects) {
      if (kept > 0 && (*effects)[kept - 1].parameter == effect.parameter) {
        (*effects)[kept - 1].across_m += effect.across_m;
        (*effects)[kept - 1].up_m += effect.up_m;
      } else {
        (*effects)[kept++] = effect;
      }
    }
    effects->resize(kept);
  }

  const AdjustmentProblem& problem_;
  const BlockState& state_;
  const std::vector<std::uint8_t>& enters_;
  std::vector<Candidate> candidates_;
  LookColumns columns_;
  LookEvaluation at_;
};

/// Root of the sum of squares of `b` minus `a`, by correction; `turn` is +1, or -1 where across
/// points the other way at b.
Effect RootOfDifferences(const std::vector<Effect>& a, const std::vector<Effect>& b, double turn) {
  Effect sum;
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    const bool take_a = j == b.size() || (i < a.size() && a[i].parameter <= b[j].parameter);
    const bool take_b = i == a.size() || (j < b.size() && b[j].parameter <= a[i].parameter);
    const double across_m = (take_b ? turn * b[j].across_m : 0.0) - (take_a ? a[i].across_m : 0.0);
    const double up_m = (take_b ? b[j].up_m : 0.0) - (take_a ? a[i].up_m : 0.0);
    sum.across_m += across_m * across_m;
    sum.up_m += up_m * up_m;
    if (take_a) ++i;
    if (take_b) ++j;
  }
  sum.across_m = std::sqrt(sum.across_m);
  sum.up_m = std::sqrt(sum.up_m);
  return sum;
}

void PredictPair(const Prediction& a, const Prediction& b, PairResult* pair) {
  if (!a.best || !b.best) return;
  const double turned_rad = a.best->across_azimuth_rad - b.best->across_azimuth_rad;
  if (std::abs(std::cos(turned_rad)) < std::cos(kSameDirection_rad)) return;
  pair->sigma_leberl_across_m = std::hypot(a.best->noise.sigma_y_m, b.best->noise.sigma_y_m);
  pair->sigma_leberl_up_m = std::hypot(a.best->noise.sigma_z_m, b.best->noise.sigma_z_m);
  if (!a.path_known || !b.path_known) return;
  const Effect root =
      RootOfDifferences(a.effects, b.effects, std::cos(turned_rad) < 0.0 ? -1.0 : 1.0);
  pair->sigma_leberl_path_across_m = root.across_m;
  pair->sigma_leberl_path_up_m = root.up_m;
}

}  // namespace

void FillLeberlPrediction(const AdjustmentProblem& problem,
                          const BlockState& state,
                          AdjustResult* result) {
  const std::size_t points = problem.block.points.size();
  const std::vector<std::uint8_t> enters = EntersRange(problem.layout);
  PointResults& out = result->points;
  for (std::vector<double>* column : {&out.sigma_leberl_across_m,
                                      &out.sigma_leberl_up_m,
                                      &out.sigma_leberl_path_across_m,
                                      &out.sigma_leberl_path_up_m,
                                      &out.leberl_across_azimuth_rad}) {
    column->assign(points, kNaN);
  }
  ForChunksOfRanks(points,
                   kPredictionsPerChunk,
                   {SharedArray::ByItem(&out.sigma_leberl_across_m),
                    SharedArray::ByItem(&out.sigma_leberl_up_m),
                    SharedArray::ByItem(&out.sigma_leberl_path_across_m),
                    SharedArray::ByItem(&out.sigma_leberl_path_up_m),
                    SharedArray::ByItem(&out.leberl_across_azimuth_rad)},
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     Predictor predictor(problem, state, enters);
                     Prediction at;
                     for (std::size_t point = begin; point < end; ++point) {
                       if (!problem.Solves(point)) continue;
                       predictor.Predict(point, &at);
                       if (!at.best) continue;
                       out.sigma_leberl_across_m[point] = at.best->noise.sigma_y_m;
                       out.sigma_leberl_up_m[point] = at.best->noise.sigma_z_m;
                       out.leberl_across_azimuth_rad[point] = at.best->across_azimuth_rad;
                       if (!at.path_known) continue;
                       const Effect root = RootOfDifferences({}, at.effects, 1.0);
                       out.sigma_leberl_path_across_m[point] = root.across_m;
                       out.sigma_leberl_path_up_m[point] = root.up_m;
                     }
                   });
  std::vector<PairResult>& pairs = result->pairs;
  ParallelForChunks(
      pairs.size(), kPredictionsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        Predictor predictor(problem, state, enters);
        Prediction a, b;
        for (std::size_t q = begin; q < end; ++q) {
          // pairs = "all" lists all partners of a point one after the other
          if (q == begin || pairs[q].a != pairs[q - 1].a) predictor.Predict(pairs[q].a, &a);
          predictor.Predict(pairs[q].b, &b);
          PredictPair(a, b, &pairs[q]);
        }
      });
}

}  // namespace sarblock
