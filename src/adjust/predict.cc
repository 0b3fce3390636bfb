// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>

#include "adjust.h"
#include "adjust_given.h"
#include "block/swath.h"
#include "core/threads.h"
#include "finish.h"
#include "model/problem.h"
#include "quality/assess.h"
#include "quality/covariance.h"
#include "quality/point_sweep.h"
#include "reduction/reduction.h"
#include "solve/inner_datum.h"
#include "solve/rank.h"
#include "solve/structure.h"
#include "solve/weak_directions.h"

namespace sarblock {
namespace {

/// Positions to predict at: those handed over, else the given coordinates, else an intersection of
/// what was measured.
std::vector<Eigen::Vector3d> CompletePositions(const Block& block,
                                               const std::vector<Eigen::Vector3d>& positions_m) {
  std::vector<Eigen::Vector3d> out(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  const AdjustmentProblem problem(block, {});
  const Eigen::VectorXd no_corrections;
  std::vector<FixedPathLook> observations;
  for (std::size_t point = 0; point < out.size(); ++point) {
    if (point < positions_m.size() && positions_m[point].allFinite()) {
      out[point] = positions_m[point];
      continue;
    }
    if (block.points.given_m[point].allFinite()) {
      out[point] = block.points.given_m[point];
      continue;
    }
    observations.clear();
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.rejected(i) || !std::isfinite(block.looks.time_s[i]) ||
          !std::isfinite(block.looks.range_m[i])) {
        continue;
      }
      if (const auto observation = problem.model.FixPath(i, no_corrections))
        observations.push_back(*observation);
    }
    const Intersection met = Intersect(observations, block.frame);
    if (met.outcome == IntersectionOutcome::kDetermined ||
        met.outcome == IntersectionOutcome::kCirclesDoNotMeet) {
      out[point] = met.position_m;
    }
  }
  return out;
}

/// A look of every pass at every point that it sees (IsSeen).
Looks VisibleLooks(const Block& block, const std::vector<Eigen::Vector3d>& positions_m) {
  Looks looks;
  for (std::size_t point = 0; point < positions_m.size(); ++point) {
    for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
      const Pass& p = block.passes[pass];
      if (!positions_m[point].allFinite()) continue;
      const std::optional<double> time_s = TimeSeen(block.frame, p, positions_m[point]);
      if (!time_s) continue;
      const Motion motion = *p.path.At(*time_s);
      looks.pass.push_back(static_cast<std::uint32_t>(pass));
      // A measured Doppler is that of the pass's squint.
      const bool doppler = p.sigma.azimuth_unit == AzimuthUnit::kHertz;
      looks.flags.push_back(doppler ? std::uint8_t{Looks::kDoppler} : std::uint8_t{0});
      looks.cone.push_back(doppler && p.squint_rad != 0.0
                               ? 2.0 * motion.velocity_mps.norm() * std::sin(p.squint_rad) /
                                     p.wavelength_m
                               : p.squint_rad);
      looks.time_s.push_back(*time_s);
      looks.range_m.push_back((positions_m[point] - motion.position_m).norm());
    }
    looks.offsets.push_back(looks.pass.size());
  }
  return looks;
}

/// FillMeasurements() of a block that is valid, with a position for each point.
Block Filled(const Block& block, const std::vector<Eigen::Vector3d>& positions_m) {
  Block out = block;
  if (out.looks.size() == 0) {
    out.looks = VisibleLooks(block, positions_m);
    return out;
  }
  const AdjustmentProblem problem(block, {});
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      double& time_s = out.looks.time_s[i];
      double& range_m = out.looks.range_m[i];
      if (std::isfinite(time_s) && std::isfinite(range_m)) continue;
      const FlightPath& path = block.passes[block.looks.pass[i]].path;
      if (!std::isfinite(time_s) && positions_m[point].allFinite()) {
        time_s =
            FindConeTime(
                path, positions_m[point], problem.block.ConeOf(i), path.start_s(), path.end_s())
                .value_or(kNotGiven);
      }
      if (std::isfinite(time_s)) {
        const auto motion = path.At(time_s);
        if (motion) range_m = (positions_m[point] - motion->position_m).norm();
      }
      if (!std::isfinite(time_s) || !std::isfinite(range_m)) {
        out.looks.flags[i] = static_cast<std::uint8_t>(out.looks.flags[i] | Looks::kRejected);
      }
    }
  }
  return out;
}

/// Whether a block has no looks, and not the offsets that say so of each point.
bool LacksOffsets(const Block& block) {
  return block.looks.size() == 0 && block.looks.offsets.size() != block.points.size() + 1;
}

/// Takes away what compares with measured values: a prediction is of the geometry and the weights,
/// whether or not the block has been measured. Counts of tests are made before.
void ForgetMeasurements(AdjustResult* result) {
  for (std::vector<float>& w : result->quality.w)
    std::fill(w.begin(), w.end(), static_cast<float>(kNotGiven));
  for (ControlQuality& control : result->control_quality) control.w = kNotGiven;
  for (PassShare& share : result->assessment.shares) {
    share.square_sum = share.prior_square_sum = kNotGiven;
  }
}

Block WithoutLooks(Block block) {
  block.looks = {};
  block.looks.offsets.assign(block.points.size() + 1, 0);
  return block;
}

}  // namespace

Block FillMeasurements(const Block& block, const std::vector<Eigen::Vector3d>& positions_m) {
  if (LacksOffsets(block)) {
    return FillMeasurements(WithoutLooks(block), positions_m);
  }
  RequireUsable(block, {}, LookUse::kPlanned);
  if (positions_m.size() != block.points.size()) {
    throw InputError("positions_m",
                     "must have one entry for each point, " + std::to_string(block.points.size()) +
                         ", got " + std::to_string(positions_m.size()));
  }
  Block out = Filled(block, positions_m);
  const ReductionOfLooks models(block, ModelsOf(block));
  if (!models.any()) return out;
  // What is measured holds what will be taken off again.
  const bool planned = block.looks.size() != out.looks.size();
  for (std::size_t point = 0; point < out.points.size(); ++point) {
    const KnownPosition* known = out.points.FindKnown(static_cast<std::uint32_t>(point));
    const Eigen::Vector3d velocity_mpy =
        known == nullptr ? Eigen::Vector3d::Zero() : known->velocity_mpy;
    for (std::size_t i = out.looks.offsets[point]; i < out.looks.offsets[point + 1]; ++i) {
      const bool time = planned || !std::isfinite(block.looks.time_s[i]);
      const bool range = planned || !std::isfinite(block.looks.range_m[i]);
      if (!time && !range) continue;
      const LookReduction delay = models.Of(
          out.looks.pass[i], out.looks.time_s[i], out.ConeOf(i), positions_m[point], velocity_mpy);
      if (time) out.looks.time_s[i] += delay.Time_s();
      if (range) out.looks.range_m[i] += delay.Range_m();
    }
  }
  return out;
}

namespace {

AdjustResult Predicted(const Block& block,
                       const AdjustOptions& options,
                       const std::vector<Eigen::Vector3d>& positions_m,
                       const PointPairs& pairs,
                       ProgressSink* progress) {
  if (positions_m.size() > block.points.size()) {
    throw InputError("positions_m",
                     "must have at most one entry for each point, " +
                         std::to_string(block.points.size()) + ", got " +
                         std::to_string(positions_m.size()));
  }
  if (options.corrections == CorrectionChoice::kAuto) {
    throw InputError("adjust.corrections",
                     "'auto' chooses by measured values, a prediction has none; 'given' or 'none' "
                     "is allowed");
  }
  AdjustResult result;
  RefuseRepetition(options, "predict", &result);
  result.status = AdjustStatus::kPredicted;
  const std::vector<Eigen::Vector3d> known_m = CompletePositions(block, positions_m);
  const Block filled = Filled(block, known_m);
  const CorrectionModel given = GivenCorrections(options);
  AdjustmentProblem problem(filled, given.groups, {}, given.priors);
  BlockState state;
  state.start_m = known_m;
  state.displacement_m.assign(known_m.size(), Eigen::Vector3d::Zero());
  state.corrections = Eigen::VectorXd::Zero(problem.layout.size());
  for (std::size_t point = 0; point < known_m.size(); ++point) {
    problem.point_status[point] = PointStatus::kPredicted;
    const std::optional<PointStatus> lacks = problem.LacksEquations(point);
    if (!known_m[point].allFinite()) {
      problem.LeaveOut(point, PointStatus::kUndetermined, "no position to predict at");
    } else if (lacks) {
      problem.LeaveOut(point,
                       *lacks,
                       *lacks == PointStatus::kNotSeen
                           ? "no pass sees it"
                           : "one look and no control: 2 equations, 3 unknowns");
    }
  }
  const StageTimer timer("covariance", &result.stages);
  UpdateWeights(state, &problem);
  const PointDefects defects = FindPointDefects(problem, state);
  LeaveOutOpenPoints(defects, &problem);
  std::optional<ReducedSystem> system;
  RequireCovarianceMethod(problem, options);
  FormDetermined(state, {}, &problem, &system, progress);
  std::vector<std::string> structure;
  for (const Finding& finding : ExamineStructure(problem, state)) {
    structure.push_back(finding.text);
    Warn(&result, finding.text);
  }
  std::optional<DatumTransform> datum;
  if (options.datum == Datum::kInner && FixDatumIfFloating(state, &problem)) {
    datum.emplace(SettleInnerDatum(
        options, [] {}, &problem, &state));
    system->Form(state, {}, progress);
  }
  const RankReport rank = FactorAndAnalyse(&*system, &state);
  RequireRegular(problem, rank, structure);
  WarnOfWeakDirections(rank, &result);
  result.condition = rank.condition;
  FillParameters(problem, state, &result);
  FillCovariance(problem, state, *system, datum, options, pairs, progress, &result);
  FinishResult(problem, state, options, {}, defects, &result);
  Assess(filled, options, &result);
  ForgetMeasurements(&result);
  if (block.looks.size() != filled.looks.size()) {
    if (const auto warning = WarningOfPlan(filled, known_m)) Warn(&result, *warning);
  }
  // The looks of the result are those of the block as it was handed over.
  if (block.looks.size() != filled.looks.size()) result.looks = {};
  DescribePaths(block, options, &result);
  return result;
}

}  // namespace

AdjustResult Predict(const Block& block,
                     const AdjustOptions& options,
                     const std::vector<Eigen::Vector3d>& positions_m,
                     const PointPairs& pairs,
                     ProgressSink* progress) {
  if (LacksOffsets(block)) {
    return Predict(WithoutLooks(block), options, positions_m, pairs, progress);
  }
  return CallInLibrary(options.threads, progress, [&] {
    const AdjustOptions usable = UsableOptions(block, options, pairs, LookUse::kPlanned);
    ReducedBlock reduced(block);
    if (reduced.HasModels()) reduced.ReduceAt(CompletePositions(block, positions_m));
    return Predicted(reduced.block(), usable, positions_m, pairs, progress);
  });
}

namespace {

constexpr std::size_t kIntersectionsPerChunk = 512;

PointStatus StatusOf(IntersectionOutcome outcome) {
  switch (outcome) {
    case IntersectionOutcome::kDetermined:
      return PointStatus::kIntersected;
    case IntersectionOutcome::kCirclesDoNotMeet:
      return PointStatus::kApart;
    case IntersectionOutcome::kTooFewLooks:
      return PointStatus::kTooFewLooks;
    default:
      return PointStatus::kUndetermined;
  }
}

AdjustResult Intersected(const Block& block, const AdjustOptions& options, ProgressSink* progress) {
  AdjustResult result;
  RefuseRepetition(options, "intersect", &result);
  result.status = AdjustStatus::kIntersected;
  AdjustmentProblem problem(block, {});
  problem.control.clear();
  problem.control_of.assign(block.points.size(), -1);
  const std::size_t points = block.points.size();
  BlockState state;
  state.start_m.assign(points, Eigen::Vector3d::Constant(kNaN));
  state.displacement_m.assign(points, Eigen::Vector3d::Zero());
  state.corrections.resize(0);
  const bool wanted = options.covariance != CovarianceLevel::kNone &&
                      options.covariance != CovarianceLevel::kLeberl;
  if (wanted) result.points.covariance_m2.resize(points);
  std::vector<double> square_sum(points, 0.0);
  {
    const StageTimer timer("solve", &result.stages);
    Step(progress, "intersect", 0, points);
    ParallelForChunks(
        points, kIntersectionsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
          std::vector<FixedPathLook> observations;
          for (std::size_t point = begin; point < end; ++point) {
            observations.clear();
            for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
                 ++i) {
              if (problem.look_used[i] == 0) continue;
              if (const auto observation = problem.model.FixPath(i, state.corrections)) {
                observations.push_back(*observation);
              }
            }
            if (wanted) result.points.covariance_m2[point].fill(kNaN);
            const Intersection met = Intersect(observations, block.frame);
            problem.point_status[point] = StatusOf(met.outcome);
            // Circles that stay apart have a best place, but no sigma that describes it.
            if (met.outcome == IntersectionOutcome::kCirclesDoNotMeet) {
              state.start_m[point] = met.position_m;
            }
            if (met.outcome != IntersectionOutcome::kDetermined) {
              problem.LeaveOut(point, problem.point_status[point], Explain(met.outcome));
              continue;
            }
            state.start_m[point] = met.position_m;
            square_sum[point] = met.weighted_square_sum;
            if (wanted) {
              result.points.covariance_m2[point] =
                  ToEnu(block.frame, met.position_m, met.covariance_m2);
            }
          }
        });
  }
  const bool some_apart =
      std::count(problem.point_status.begin(), problem.point_status.end(), PointStatus::kApart) > 0;
  if (!some_apart) RequireSolvable(problem);
  double total = 0.0;
  for (const double s : square_sum) total += s;
  if (options.pairs != PairChoice::kNone) {
    Warn(&result,
         "pairs are not formed by intersect: its points are independent, the covariance of a "
         "difference is the sum of theirs");
  }
  FinishResult(problem, state, options, {total}, {}, &result);
  if (result.looks_used == 0) Refuse(&result, "no point could be intersected");
  Assess(block, options, &result);
  DescribePaths(block, options, &result);
  ScaleByPosterior(options, &result);
  return result;
}

}  // namespace

AdjustResult IntersectBlock(const Block& block,
                            const AdjustOptions& options,
                            ProgressSink* progress) {
  return CallInLibrary(options.threads, progress, [&] {
    RequireUsable(block, {}, LookUse::kMeasured);
    return SolveReduced(block, progress, [&](const Block& reduced) {
      return Intersected(reduced, options, progress);
    });
  });
}

}  // namespace sarblock
