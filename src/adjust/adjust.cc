// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"

#include <optional>
#include <utility>
#include <vector>

#include "adjust_given.h"
#include "adjust_selected.h"
#include "core/threads.h"
#include "describe_paths.h"
#include "option_checks.h"
#include "ordered_points.h"

namespace sarblock {
namespace {

AdjustResult AdjustAsItStands(const Block& block,
                              const AdjustOptions& options,
                              const PointPairs& pairs,
                              ProgressSink* progress) {
  AdjustResult result = options.corrections == CorrectionChoice::kAuto
                            ? AdjustSelected(block, options, pairs, progress)
                            : AdjustGiven(block, options, {}, pairs, nullptr, progress);
  DescribePaths(block, block, options, &result);
  return result;
}

/// `order`: as the points of `block` are to stand meanwhile.
AdjustResult AdjustInOrder(PointOrder order,
                           const AdjustOptions& options,
                           const PointPairs& pairs,
                           ProgressSink* progress,
                           Block* block) {
  std::vector<StageCost> stages;
  std::optional<StageTimer> timer;
  timer.emplace("order", &stages);
  Step(progress, "order", 0, 2, "points by their passes");
  const OrderedPoints ordered(std::move(order), block);
  timer.reset();
  AdjustResult result;
  try {
    result = AdjustAsItStands(*block, options, ordered.Pairs(pairs), progress);
    Step(progress, "order", 1, 2, "points as the block lists them");
  } catch (...) {
    ordered.RestoreBlock();
    throw;
  }
  timer.emplace("order", &stages);
  ordered.RestoreResult(options.pairs != PairChoice::kList, &result);
  ordered.RestoreBlock();
  timer.reset();
  result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  return result;
}

}  // namespace

AdjustResult Adjust(const Block& block,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  RequireOffered(options);
  const ThreadLimit limit(options.threads);
  PointOrder order = OrderByPasses(block);
  if (order.empty()) return AdjustAsItStands(block, options, pairs, progress);
  Block copy = block;
  return AdjustInOrder(std::move(order), options, pairs, progress, &copy);
}

AdjustResult Adjust(Block* block,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  RequireOffered(options);
  const ThreadLimit limit(options.threads);
  PointOrder order = OrderByPasses(*block);
  if (order.empty()) return AdjustAsItStands(*block, options, pairs, progress);
  return AdjustInOrder(std::move(order), options, pairs, progress, block);
}

}  // namespace sarblock
