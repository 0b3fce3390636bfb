// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/intersect_block.h"

#include "sarblock/core/error.h"

#include <algorithm>

#include "core/threads.h"
#include "describe_paths.h"
#include "finish_result.h"
#include "model/problem.h"
#include "option_checks.h"
#include "quality/assess.h"
#include "quality/point_sweep.h"
#include "solve/rank.h"

namespace sarblock {
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

}  // namespace

AdjustResult IntersectBlock(const Block& block,
                            const AdjustOptions& options,
                            ProgressSink* progress) {
  const ThreadLimit limit(options.threads);
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
          std::vector<Sight> sights;
          for (std::size_t point = begin; point < end; ++point) {
            sights.clear();
            for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
                 ++i) {
              if (problem.look_used[i] == 0) continue;
              if (const auto sight = problem.model.SightOf(i, state.corrections)) {
                sights.push_back(*sight);
              }
            }
            if (wanted) result.points.covariance_m2[point].fill(kNaN);
            const Intersection met = Intersect(sights, block.frame);
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
  DescribePaths(block, block, options, &result);
  return result;
}

}  // namespace sarblock
