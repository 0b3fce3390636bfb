// SPDX-License-Identifier: Apache-2.0
#include "describe_paths.h"

#include <vector>

#include "core/threads.h"
#include "quality/point_sweep.h"
#include "strip_stations.h"

namespace sarblock {
namespace {

/// The correction groups that a result was made with: given or chosen.
std::vector<CorrectionGroup> UsedGroups(const AdjustOptions& options, const AdjustResult& result) {
  switch (options.corrections) {
    case CorrectionChoice::kGiven:
      return options.groups;
    case CorrectionChoice::kAuto:
      return result.selection.groups;
    case CorrectionChoice::kNone:
      break;
  }
  return {};
}

}  // namespace

void DescribePaths(const Block& block,
                   const Block& measured,
                   const AdjustOptions& options,
                   AdjustResult* result) {
  const ThreadLimit limit(options.threads);
  const std::vector<CorrectionGroup> groups = UsedGroups(options, *result);
  result->strips = SampleStrips(block, groups, *result);
  if (options.datum != Datum::kGiven) return;
  const StageTimer timer("covariance", &result->stages);
  result->points.fixed_path_covariance_m2 = FixedPathCovariances(measured, groups, *result);
}

}  // namespace sarblock
