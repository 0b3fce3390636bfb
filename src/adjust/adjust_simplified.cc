// SPDX-License-Identifier: Apache-2.0
#include "adjust_simplified.h"

#include <string>
#include <utility>
#include <vector>

#include "adjust_given.h"
#include "core/text.h"
#include "selection/simplify.h"

namespace sarblock {
AdjustResult AdjustSimplified(const Block& block,
                              const AdjustOptions& options,
                              const Simplified& simplified,
                              const PointPairs& pairs,
                              SelectionReport* report,
                              ProgressSink* progress) {
  const double limit_1 = options.selection.simplify_1;
  Simplified used = simplified;
  std::vector<SimplificationBound> bounds;
  double shift_1 = kNotGiven;
  const AtSolution examine =
      [&](const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result) {
        bounds = BoundSimplifications(problem, state, limit_1);
        if (used.any()) {
          shift_1 = ShiftToFullModel(problem, state, result->points.covariance_m2, progress);
        }
      };
  AdjustResult result = AdjustGiven(block, options, used, pairs, examine, progress);
  std::vector<SimplificationBound>& said = report->simplifications;
  bool holds = true;
  if (simplified.any()) {
    holds = shift_1 <= limit_1 && bounds.size() == said.size();
    for (std::size_t k = 0; holds && k < bounds.size(); ++k) {
      holds = bounds[k].allowed || !said[k].taken;
    }
    report->simplified_shift_1 = shift_1;
  }
  if (holds) {
    report->simplified = simplified;
  } else {
    used = {};
    std::vector<StageCost> stages = std::move(result.stages);
    result = AdjustGiven(block, options, used, pairs, examine, progress);
    result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  }
  for (std::size_t k = 0; k < bounds.size() && k < said.size(); ++k) {
    bounds[k].gain_1 = said[k].gain_1;
    bounds[k].taken = said[k].taken && holds;
    if (said[k].taken && !holds) {
      bounds[k].verdict = "taken first and given up: the full model moved a point by " +
                          Digits(shift_1, 2) + " sigma";
    } else if (bounds[k].allowed && said[k].allowed) {
      bounds[k].verdict = said[k].verdict;
    } else if (bounds[k].allowed) {
      bounds[k].verdict = "allowed, not taken: it was above the limit before the adjustment";
    }
  }
  said = std::move(bounds);
  return result;
}

}  // namespace sarblock
