// SPDX-License-Identifier: Apache-2.0
#include "blunder_report.h"

#include "sarblock/model/result.h"

#include <string>

#include "blunder_search.h"

namespace sarblock {
namespace {

void WarnOfFindings(AdjustResult* result) {
  std::size_t kept = 0;
  for (const BlunderFinding& finding : result->snooping->findings) {
    kept += finding.action == BlunderFinding::Action::kKept ? 1U : 0U;
  }
  if (kept > 0) {
    Warn(result,
         std::to_string(kept) +
             " suspected blunders were kept in the adjustment, see the findings of the search");
  }
  if (result->snooping->rounds >= kMostSearchRounds) {
    Warn(result,
         "the search for blunders ended after " + std::to_string(result->snooping->rounds) +
             " rounds and is not complete");
  }
}

}  // namespace

void FillReasons(const AdjustmentProblem& problem,
                 const std::vector<std::size_t>& dropped,
                 AdjustResult* result) {
  const Block& block = problem.block;
  std::vector<RejectReason>& reason = result->looks.reason;
  std::vector<std::uint8_t>& rejected = result->looks.rejected;
  reason.assign(block.looks.size(), RejectReason::kNone);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (rejected[i] == 0) continue;
    reason[i] = block.looks.rejected(i) ? RejectReason::kGiven : RejectReason::kNoValue;
  }
  const auto mark = [&](std::size_t look, RejectReason why) {
    rejected[look] = 1;
    reason[look] = why;
  };
  for (const std::size_t look : dropped) mark(look, RejectReason::kRobust);
  if (!result->snooping) return;
  for (const std::uint64_t look : result->snooping->robust) mark(look, RejectReason::kRobust);
  for (const BlunderFinding& finding : result->snooping->findings) {
    if (!LeavesOut(finding)) continue;
    for (const std::uint64_t look : finding.looks) {
      mark(look, finding.located() ? RejectReason::kBlunder : RejectReason::kSuspect);
    }
  }
  WarnOfFindings(result);
}

}  // namespace sarblock
