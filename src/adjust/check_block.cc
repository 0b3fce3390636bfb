// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/check_block.h"

#include "core/threads.h"
#include "resource_needs.h"
#include "solve/point_defects.h"
#include "solve/start.h"
#include "solve/structure.h"

namespace sarblock {

BlockCheck CheckBlock(const Block& block, const AdjustOptions& options, ProgressSink* progress) {
  const ThreadLimit limit(options.threads);
  const CorrectionModel given = GivenCorrections(options);
  AdjustmentProblem problem(block, given.groups, {}, given.priors);
  BlockCheck check;
  check.corrections = problem.layout.size();
  const StartReport start = ComputeStartValues(&problem, progress);
  const PointDefects defects = FindPointDefects(problem, start.state);
  LeaveOutOpenPoints(defects, &problem);
  for (const Finding& finding : ExamineStructure(problem, start.state)) {
    check.findings.push_back(finding.text);
  }
  for (const Finding& finding : DescribePoints(problem, defects)) {
    check.findings.push_back(finding.text);
  }
  ReducedSystem system(problem);
  check.needs = PredictNeeds(problem, options, &system);
  if (const std::string text = ProblemOfMemory(check.needs, options); !text.empty()) {
    check.findings.push_back(text);
  }
  return check;
}

}  // namespace sarblock
