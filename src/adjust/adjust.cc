// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include "adjust_given.h"
#include "adjust_selected.h"
#include "option_checks.h"

namespace sarblock {

AdjustResult Adjust(const Block& block,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  RequireOffered(options);
  if (options.corrections == CorrectionChoice::kAuto) {
    return AdjustSelected(block, options, pairs, progress);
  }
  return AdjustGiven(block, options, {}, pairs, nullptr, progress);
}

}  // namespace sarblock
