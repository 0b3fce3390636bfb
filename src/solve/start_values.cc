// SPDX-License-Identifier: Apache-2.0
#include "start_values.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/threads.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 512;

/// What one point starts with.
struct PointStart {
  PointStatus status = PointStatus::kAdjusted;
  IntersectionOutcome outcome = IntersectionOutcome::kDetermined;  ///< of kUndetermined
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNotGiven);
};

PointStart Refuse(PointStatus status,
                  IntersectionOutcome outcome = IntersectionOutcome::kTooFewLooks) {
  PointStart out;
  out.status = status;
  out.outcome = outcome;
  return out;
}

/// Why a point without a start has none.
std::string ReasonOf(const PointStart& start) {
  switch (start.status) {
    case PointStatus::kNotSeen:
      return "no look of it takes part";
    case PointStatus::kTooFewLooks:
      return "one look and no control: 2 equations, 3 unknowns";
    default:
      return Explain(start.outcome);
  }
}

PointStart StartOf(const AdjustmentProblem& problem,
                   std::size_t point,
                   const std::vector<Sight>& sights,
                   const IntersectionOptions& intersection) {
  const Block& block = problem.block;
  const ControlEquations* control =
      problem.control_of[point] < 0
          ? nullptr
          : &problem.control[static_cast<std::size_t>(problem.control_of[point])];
  const int control_rows = control == nullptr ? 0 : control->rows;
  if (sights.empty()) return Refuse(PointStatus::kNotSeen);
  if (2 * static_cast<int>(sights.size()) + control_rows < 3) {
    return Refuse(PointStatus::kTooFewLooks);
  }
  PointStart out;
  const Eigen::Vector3d& given_m = block.points.given_m[point];
  // A check point's coordinates are withheld, its start values too.
  if (given_m.allFinite() && block.points.role[point] != PointRole::kCheck) {
    const auto sees = [&](const Sight& sight) {
      return LiesWhereItLooks(block.frame, sight, given_m);
    };
    if (control != nullptr || std::all_of(sights.begin(), sights.end(), sees)) {
      out.position_m = given_m;
      return out;
    }
  }
  const Intersection met = Intersect(sights, block.frame, intersection);
  // Flight-path errors may keep circles apart that the adjustment brings together: a compromise is
  // good enough to start from.
  if (met.outcome == IntersectionOutcome::kDetermined ||
      met.outcome == IntersectionOutcome::kCirclesDoNotMeet ||
      met.outcome == IntersectionOutcome::kNotConverged) {
    out.position_m = met.position_m;
    return out;
  }
  return Refuse(PointStatus::kUndetermined, met.outcome);
}

/// Refuses passes whose states contradict each other so much that between them the Doppler cone
/// passes over a point several times: no time of such a look means anything.
void RequireSteadyCones(const AdjustmentProblem& problem) {
  for (std::size_t pass = 0; pass < problem.block.passes.size(); ++pass) {
    const ConeTurning& turning = problem.model.paths().TurningOf(pass);
    if (!(turning.median_1 > ConeTurning::kFolding_1)) continue;
    std::array<char, 640> text{};
    std::snprintf(
        text.data(),
        text.size(),
        "the flight path is too rough to be read at %.4g km: in %zu of %zu intervals "
        "between its states the path turns the Doppler cone back over points it has "
        "passed, since positions and velocities contradict each other (median %.2g of the "
        "cone's own rate, at most %.2g is allowed); set through = \"smooth\" or \"auto\" in its "
        "trajectory, smooth the states, or give states farther apart",
        1e-3 * turning.range_m,
        turning.folded,
        turning.pieces,
        turning.median_1,
        ConeTurning::kFolding_1);
    throw InputError("pass " + problem.block.passes[pass].id, text.data());
  }
}

}  // namespace

StartReport ComputeStartValues(AdjustmentProblem* problem,
                               ProgressSink* progress,
                               const IntersectionOptions& intersection) {
  const Block& block = problem->block;
  RequireSteadyCones(*problem);
  const std::size_t points = block.points.size();
  StartReport report;
  report.state.start_m.assign(points, Eigen::Vector3d::Constant(kNotGiven));
  report.state.displacement_m.assign(points, Eigen::Vector3d::Zero());
  report.state.corrections = Eigen::VectorXd::Zero(problem->layout.size());
  // Points and looks are left out after the loop, whose chunks several ranks divide.
  std::vector<PointStart> starts(points);
  std::vector<std::uint8_t> lost(block.looks.size(), 0);
  const auto start = [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<Sight> sights;
    for (std::size_t point = begin; point < end; ++point) {
      sights.clear();
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem->look_used[i] == 0) continue;
        const std::optional<Sight> sight = problem->model.SightOf(i, report.state.corrections);
        if (sight) {
          sights.push_back(*sight);
        } else {
          lost[i] = 1;
        }
      }
      starts[point] = StartOf(*problem, point, sights, intersection);
    }
  };
  Step(progress, "start values", 0, points);
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByItem(&starts), SharedArray::ByRange(block.looks.offsets, &lost)},
                   start);
  for (std::size_t i = 0; i < lost.size(); ++i) {
    if (lost[i] == 0) continue;
    report.looks_not_evaluated.push_back(i);
    problem->look_used[i] = 0;
  }
  for (std::size_t point = 0; point < points; ++point) {
    if (IsSolved(starts[point].status)) {
      report.state.start_m[point] = starts[point].position_m;
    } else {
      problem->LeaveOut(point, starts[point].status, ReasonOf(starts[point]));
    }
  }
  UpdateWeights(report.state, problem);
  Step(progress, "start values", points, points);
  return report;
}

}  // namespace sarblock
