// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/predict.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>

#include "core/threads.h"
#include "describe_paths.h"
#include "finish_result.h"
#include "geometry/track_axes.h"
#include "option_checks.h"
#include "quality/assess.h"
#include "quality/result_covariance.h"
#include "solve/inner_datum.h"
#include "solve/point_defects.h"
#include "solve/rank.h"
#include "solve/structure.h"

namespace sarblock {
namespace {

/// Positions to predict at: those handed over, else the given coordinates, else an intersection of
/// what was measured.
std::vector<Eigen::Vector3d> CompletePositions(const Block& block,
                                               const std::vector<Eigen::Vector3d>& positions_m) {
  std::vector<Eigen::Vector3d> out(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  const AdjustmentProblem problem(block, {});
  const Eigen::VectorXd no_corrections;
  std::vector<Sight> sights;
  for (std::size_t point = 0; point < out.size(); ++point) {
    if (point < positions_m.size() && positions_m[point].allFinite()) {
      out[point] = positions_m[point];
      continue;
    }
    if (block.points.given_m[point].allFinite()) {
      out[point] = block.points.given_m[point];
      continue;
    }
    sights.clear();
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.rejected(i) || !std::isfinite(block.looks.time_s[i]) ||
          !std::isfinite(block.looks.range_m[i])) {
        continue;
      }
      if (const auto sight = problem.model.SightOf(i, no_corrections)) sights.push_back(*sight);
    }
    const Intersection met = Intersect(sights, block.frame);
    if (met.outcome == IntersectionOutcome::kDetermined ||
        met.outcome == IntersectionOutcome::kCirclesDoNotMeet) {
      out[point] = met.position_m;
    }
  }
  return out;
}

/// All looks of passes that see a point on their look side, below the antenna, within the path.
Looks VisibleLooks(const Block& block, const std::vector<Eigen::Vector3d>& positions_m) {
  Looks looks;
  for (std::size_t point = 0; point < positions_m.size(); ++point) {
    for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
      const Pass& p = block.passes[pass];
      if (!positions_m[point].allFinite()) continue;
      const auto time_s =
          FindConeTime(p.path, positions_m[point], Cone{}, p.path.start_s(), p.path.end_s());
      if (!time_s) continue;
      const Motion motion = *p.path.At(*time_s);
      const Eigen::Vector3d in_track = TrackAxesOf(block.frame, motion).axes_1.transpose() *
                                       (positions_m[point] - motion.position_m);
      if (in_track[1] * static_cast<double>(p.side) <= 0.0 || in_track[2] >= 0.0) continue;
      looks.pass.push_back(static_cast<std::uint32_t>(pass));
      // Measured Dopplers are taken as those of looks straight to the side.
      const bool doppler = p.sigma.azimuth_unit == AzimuthUnit::kHertz;
      looks.flags.push_back(doppler ? std::uint8_t{Looks::kDoppler} : std::uint8_t{0});
      looks.cone.push_back(0.0);
      looks.time_s.push_back(*time_s);
      looks.range_m.push_back(in_track.norm());
    }
    looks.offsets.push_back(looks.pass.size());
  }
  return looks;
}

}  // namespace

Block FillMeasurements(const Block& block, const std::vector<Eigen::Vector3d>& positions_m) {
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

AdjustResult Predict(const Block& block,
                     const AdjustOptions& options,
                     const std::vector<Eigen::Vector3d>& positions_m,
                     const PointPairs& pairs,
                     ProgressSink* progress) {
  RequireOffered(options);
  if (options.corrections == CorrectionChoice::kAuto) {
    throw InputError("adjust.corrections",
                     "'auto' chooses by measured values, a prediction has none; 'given' or 'none' "
                     "is allowed");
  }
  const ThreadLimit limit(options.threads);
  AdjustResult result;
  RefuseRepetition(options, "predict", &result);
  result.status = AdjustStatus::kPredicted;
  const std::vector<Eigen::Vector3d> known_m = CompletePositions(block, positions_m);
  const Block filled = FillMeasurements(block, known_m);
  const CorrectionModel given = GivenCorrections(options);
  AdjustmentProblem problem(filled, given.groups, {}, given.priors);
  BlockState state;
  state.start_m = known_m;
  state.displacement_m.assign(known_m.size(), Eigen::Vector3d::Zero());
  state.corrections = Eigen::VectorXd::Zero(problem.layout.size());
  for (std::size_t point = 0; point < known_m.size(); ++point) {
    problem.point_status[point] = PointStatus::kPredicted;
    const int rows =
        problem.control_of[point] < 0
            ? 0
            : problem.control[static_cast<std::size_t>(problem.control_of[point])].rows;
    const int looks = problem.CountLooks(point);
    if (!known_m[point].allFinite()) {
      problem.LeaveOut(point, PointStatus::kUndetermined, "no position to predict at");
    } else if (looks == 0) {
      problem.LeaveOut(point, PointStatus::kNotSeen, "no pass sees it");
    } else if (2 * looks + rows < 3) {
      problem.LeaveOut(
          point, PointStatus::kTooFewLooks, "one look and no control: 2 equations, 3 unknowns");
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
  if (options.datum == Datum::kInner && HoldIfFloating(state, &problem)) {
    datum.emplace(SettleInnerDatum(
        options, [] {}, &problem, &state));
    system->Form(state, {}, progress);
  }
  const RankReport rank = FactorAndAnalyse(&*system, &state);
  RequireRegular(problem, rank, structure);
  WarnOfWeakDirections(rank, &result);
  result.condition = rank.condition_1;
  FillParameters(problem, state, &result);
  FillCovariance(problem, state, *system, datum, options, pairs, progress, &result);
  FinishResult(problem, state, options, {}, defects, &result);
  Assess(filled, options, &result);
  // The looks of the result are those of the block as it was handed over.
  if (block.looks.size() != filled.looks.size()) result.looks = {};
  DescribePaths(block, filled, options, &result);
  return result;
}

}  // namespace sarblock
