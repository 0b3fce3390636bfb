// SPDX-License-Identifier: Apache-2.0
#include "form_determined.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace sarblock {
namespace {

void LeaveOutWeakPoints(const ReducedSystem& system, AdjustmentProblem* problem) {
  for (const WeakPoint& weak : system.weak_points()) {
    problem->LeaveOut(weak.point,
                      PointStatus::kUndetermined,
                      "its looks leave a direction open (their circles touch or coincide)");
  }
}

}  // namespace

void RequireSolvable(const AdjustmentProblem& problem) {
  // Control points are known anyway: a block in which none of the others can be solved has no
  // answer, however well its control fits. A point in no look that takes part asks for none.
  const Block& block = problem.block;
  const std::size_t points = block.points.size();
  const auto asks = [&block](std::size_t point) {
    if (block.points.role[point] == PointRole::kControl) return false;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (!block.looks.rejected(i)) return true;
    }
    return false;
  };
  bool only_control = true;
  for (std::size_t point = 0; point < points; ++point) only_control &= !asks(point);
  std::map<std::string, std::vector<std::string>> by_reason;
  for (std::size_t point = 0; point < points; ++point) {
    if (!only_control && !asks(point)) continue;
    if (problem.Solves(point)) return;
    by_reason[problem.point_reason[point]].emplace_back(block.points.ids[point]);
  }
  std::string text = only_control ? "no point of the block can be determined"
                                  : "no tie or check point of the block can be determined";
  std::vector<std::string> names;
  for (const auto& [reason, ids] : by_reason) {
    text += "; " + ids.front();
    if (ids.size() > 1) text += " and " + std::to_string(ids.size() - 1) + " more";
    text += ": " + reason;
    names.insert(names.end(), ids.begin(), ids.end());
  }
  throw UndeterminedError(text, names);
}

void FormDetermined(const BlockState& state,
                    const Weighting& weighting,
                    AdjustmentProblem* problem,
                    std::optional<ReducedSystem>* system,
                    ProgressSink* progress) {
  for (;;) {
    RequireSolvable(*problem);
    system->emplace(*problem, KeptFactors::kMostBytes);
    (*system)->Form(state, weighting, progress);
    if ((*system)->weak_points().empty()) return;
    LeaveOutWeakPoints(**system, problem);
  }
}

}  // namespace sarblock
