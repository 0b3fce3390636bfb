// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include "adjust_given.h"
#include "adjust_selected.h"
#include "describe_paths.h"
#include "option_checks.h"

namespace sarblock {

AdjustResult Adjust(const Block& block,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  RequireOffered(options);
  AdjustResult result = options.corrections == CorrectionChoice::kAuto
                            ? AdjustSelected(block, options, pairs, progress)
                            : AdjustGiven(block, options, {}, pairs, nullptr, progress);
  DescribePaths(block, block, options, &result);
  return result;
}

}  // namespace sarblock
