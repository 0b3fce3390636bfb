// SPDX-License-Identifier: Apache-2.0
#include "point_defects.h"

#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/text.h"
#include "core/threads.h"
#include "weak_directions.h"
#include <Eigen/Geometry>

namespace sarblock {
namespace {

constexpr std::size_t kDefectsPerChunk = 1024;

/// Circles that cut at a sharper angle than this many sqrt(sigma / R) cannot touch within their
/// noise: the mirror solution is 3 standard deviations away at 1.7 (docs/theory/rank.md, section
/// 3).
constexpr double kThinAngle = 5.0;

bool CutsThin(const Eigen::Vector3d& p_m, const std::vector<FixedPathLook>& observations) {
  double largest = 0.0;
  for (const FixedPathLook& observation : observations) {
    largest = std::max(largest, observation.range_sigma_m / observation.range_m);
  }
  return LargestIntersectionAngle(p_m, observations) < kThinAngle * std::sqrt(largest);
}

/// The mirror image of p about the plane through two antennas along their flight lies where all
/// looks look, too.
bool MirrorFits(const Frame& frame,
                const Eigen::Vector3d& p_m,
                const std::vector<FixedPathLook>& observations) {
  const FixedPathLook* other = &observations.back();
  double most_m2 = 0.0;
  const FixedPathLook& first = observations.front();
  const Eigen::Vector3d u = first.velocity_mps.normalized();
  for (const FixedPathLook& observation : observations) {
    const double base_m2 = u.cross(observation.antenna_m - first.antenna_m).squaredNorm();
    if (base_m2 > most_m2) {
      most_m2 = base_m2;
      other = &observation;
    }
  }
  if (!(most_m2 > 0.0)) return false;
  const Eigen::Vector3d n = u.cross(other->antenna_m - first.antenna_m).normalized();
  const Eigen::Vector3d mirror_m = p_m - 2.0 * n.dot(p_m - first.antenna_m) * n;
  return std::all_of(
      observations.begin(), observations.end(), [&](const FixedPathLook& observation) {
        return LiesWhereItLooks(frame, observation, mirror_m);
      });
}

}  // namespace

PointDefects FindPointDefects(const AdjustmentProblem& problem, const BlockState& state) {
  const Block& block = problem.block;
  const std::size_t points = block.points.size();
  std::vector<IntersectionOutcome> outcome(points, IntersectionOutcome::kDetermined);
  const auto examine = [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<FixedPathLook> observations;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point) || problem.control_of[point] >= 0) continue;
      observations.clear();
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem.look_used[i] == 0) continue;
        if (const auto observation = problem.model.FixPath(i, state.corrections)) {
          observations.push_back(*observation);
        }
      }
      if (observations.size() < 2) continue;
      const Eigen::Vector3d p_m = state.Position(point);
      if (!CutsThin(p_m, observations) && !MirrorFits(block.frame, p_m, observations)) continue;
      outcome[point] = Intersect(observations, block.frame).outcome;
    }
  };
  ForChunksOfRanks(points, kDefectsPerChunk, {SharedArray::ByItem(&outcome)}, examine);
  PointDefects out;
  for (std::size_t point = 0; point < points; ++point) {
    switch (outcome[point]) {
      case IntersectionOutcome::kCirclesTouch:
        out.touching.push_back(point);
        break;
      case IntersectionOutcome::kCirclesCoincide:
        out.coinciding.push_back(point);
        break;
      case IntersectionOutcome::kAmbiguous:
        out.ambiguous.push_back(point);
        break;
      default:
        break;
    }
  }
  return out;
}

namespace {

/// A tie point's given coordinates choose between its two places; a check point's are withheld.
bool CoordinatesChoose(const Block& block, std::size_t point) {
  return block.points.given_m[point].allFinite() && block.points.role[point] != PointRole::kCheck;
}

}  // namespace

bool LeaveOutOpenPoints(const PointDefects& defects, AdjustmentProblem* problem) {
  bool any = !defects.touching.empty() || !defects.coinciding.empty();
  for (const std::size_t point : defects.touching) {
    problem->LeaveOut(
        point, PointStatus::kUndetermined, Explain(IntersectionOutcome::kCirclesTouch));
  }
  for (const std::size_t point : defects.coinciding) {
    problem->LeaveOut(
        point, PointStatus::kUndetermined, Explain(IntersectionOutcome::kCirclesCoincide));
  }
  for (const std::size_t point : defects.ambiguous) {
    if (CoordinatesChoose(problem->block, point)) continue;
    problem->LeaveOut(point, PointStatus::kUndetermined, Explain(IntersectionOutcome::kAmbiguous));
    any = true;
  }
  return any;
}

std::vector<Finding> DescribePoints(const AdjustmentProblem& problem, const PointDefects& defects) {
  const IdTable& ids = problem.block.points.ids;
  std::vector<Finding> out;
  Finding left_out;
  std::map<std::string, std::vector<std::string>> by_reason;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) continue;
    left_out.names.emplace_back(ids[point]);
    by_reason[problem.point_reason[point]].emplace_back(ids[point]);
  }
  if (!left_out.names.empty()) {
    left_out.text = std::to_string(left_out.names.size()) + " of " +
                    std::to_string(problem.block.points.size()) +
                    " points are not determined and left out";
    for (const auto& [reason, names] : by_reason) {
      left_out.text += "; " + ListNames(names) + ": " + reason;
    }
    out.push_back(std::move(left_out));
  }
  if (!defects.ambiguous.empty()) {
    Finding mirrored;
    bool all_given = true;
    for (const std::size_t point : defects.ambiguous) {
      mirrored.names.emplace_back(ids[point]);
      all_given = all_given && CoordinatesChoose(problem.block, point);
    }
    mirrored.text = ListNames(mirrored.names) +
                    ": a mirror point satisfies the looks and their sides as well, " +
                    (all_given ? "only the given start coordinates chose between the two"
                               : "and nothing in the block chooses between the two") +
                    "; a third look or control has to decide";
    out.push_back(std::move(mirrored));
  }
  return out;
}

}  // namespace sarblock
