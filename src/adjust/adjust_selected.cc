// SPDX-License-Identifier: Apache-2.0
#include "adjust_selected.h"

#include <string>
#include <utility>
#include <vector>

#include "adjust_simplified.h"
#include "core/threads.h"
#include "selection/candidates.h"
#include "selection/selection.h"
#include "selection/simplify.h"

namespace sarblock {
namespace {

/// A datum by inner constraints moves with everything, and without covariance a robust solution has
/// no length to compare a step with: what was taken could not be verified.
bool CanVerify(const AdjustOptions& options) {
  const bool covariance = options.covariance != CovarianceLevel::kNone &&
                          options.covariance != CovarianceLevel::kLeberl;
  return options.datum == Datum::kGiven && (covariance || options.robust == RobustLoss::kNone);
}

}  // namespace

AdjustResult AdjustSelected(const Block& block,
                            const AdjustOptions& options,
                            const PointPairs& pairs,
                            ProgressSink* progress) {
  std::vector<StageCost> stages;
  SelectionReport report;
  Simplified simplified;
  const AtSelection simplify =
      [&](const AdjustmentProblem& problem, const BlockState& state, SelectionReport* selected) {
        const double limit_1 = options.selection.simplify_1;
        selected->simplifications = BoundSimplifications(problem, state, limit_1);
        if (!CanVerify(options)) {
          for (SimplificationBound& bound : selected->simplifications) {
            if (bound.allowed) bound.verdict = "allowed, not taken: it could not be verified";
          }
          return;
        }
        simplified = ChooseSimplified(problem, state, limit_1, &selected->simplifications);
        if (simplified.any()) {
          selected->simplified_gain_1 = MeasureGain(problem, state, simplified);
        }
      };
  {
    const StageTimer timer("select", &stages);
    report = SelectCorrections(block, options, simplify, progress);
  }
  AdjustOptions chosen = options;
  chosen.corrections = report.groups.empty() ? CorrectionChoice::kNone : CorrectionChoice::kGiven;
  chosen.groups = report.groups;
  AdjustResult result = AdjustSimplified(block, chosen, simplified, pairs, &report, progress);
  result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  for (ParameterResult& parameter : result.parameters) {
    parameter.kept = KeptText(report, parameter.owner, parameter.name);
  }
  if (options.selection.mode == SelectionOptions::Mode::kPerPass) {
    Warn(&result,
         "corrections were chosen for every pass by itself (selection.mode = \"per-pass\"): "
         "standard "
         "deviations take the choice for certain and are too small, by a fifth to a half in "
         "simulated blocks; \"common\" states them realistically");
  }
  if (!report.settled) {
    Warn(&result,
         "the choice of corrections still changed after " + std::to_string(report.rounds) +
             " rounds");
  }
  result.selection = std::move(report);
  return result;
}

}  // namespace sarblock
