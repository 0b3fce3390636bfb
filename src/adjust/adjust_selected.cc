// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/selection.h"
#include "sarblock/adjust/simplifications.h"
#include "sarblock/core/stage_timer.h"

#include <string>
#include <utility>
#include <vector>

#include "selection_rows.h"
#include "solution.h"

namespace sarblock {

AdjustResult AdjustSelected(const Block& block,
                            const AdjustOptions& options,
                            const PointPairs& pairs,
                            ProgressSink* progress) {
  std::vector<StageCost> stages;
  SelectionReport report;
  {
    const StageTimer timer("select", &stages);
    report = SelectCorrections(block, options, progress);
  }
  AdjustOptions chosen = options;
  chosen.corrections = report.groups.empty() ? CorrectionChoice::kNone : CorrectionChoice::kGiven;
  chosen.groups = report.groups;
  AdjustResult result = Adjust(block, chosen, pairs, progress);
  result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  for (ParameterResult& parameter : result.parameters) {
    parameter.kept = KeptText(report, parameter.owner, parameter.name);
  }
  if (!report.settled) {
    Warn(&result,
         "the choice of corrections still changed after " + std::to_string(report.rounds) +
             " rounds");
  }
  report.simplifications = BoundSimplifications(block, result, options.selection.simplify_1);
  result.selection = std::move(report);
  return result;
}

}  // namespace sarblock
