// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <functional>
#include <vector>

#include "block/point_order.h"
#include <Eigen/Core>

namespace sarblock {

/// Adjust() with options.corrections == kAuto: the selection, then the adjustment with what it
/// chose.
[[nodiscard]] AdjustResult AdjustSelected(const Block& block,
                                          const AdjustOptions& options,
                                          const PointPairs& pairs,
                                          ProgressSink* progress);

/// Adjusts a block with `options.groups` and a simplified model and examines it: where a point
/// would move by more than the limit, or a bound of what was taken is above it at the solution, the
/// block is adjusted again with the full model. `report` holds what ChooseSimplified() said and
/// gets the outcome.
[[nodiscard]] AdjustResult AdjustSimplified(const Block& block,
                                            const AdjustOptions& options,
                                            const Simplified& simplified,
                                            const PointPairs& pairs,
                                            SelectionReport* report,
                                            ProgressSink* progress = nullptr);

/// Throws InputError unless a block and pairs of its points can be used: Validate(), paths above
/// the ground of the body, pairs of two existing points. kMeasured: every look that is not rejected
/// has a time and a range.
enum class LookUse { kPlanned, kMeasured };
void RequireUsable(const Block& block, const PointPairs& pairs, LookUse use);

/// Refuses options that this build does not offer, by name.
void RequireOffered(const AdjustOptions& options);

/// Makes both checks for a public function within CallInLibrary() and returns the options that it
/// has to use: kList where pairs are listed, and the number of threads that it may have.
[[nodiscard]] AdjustOptions UsableOptions(const Block& block,
                                          const AdjustOptions& options,
                                          const PointPairs& pairs,
                                          LookUse use);

/// Positions by point, frame axes, at which an adjustment would start; NaN where it could not.
[[nodiscard]] std::vector<Eigen::Vector3d> StartPositions(const Block& block,
                                                          ProgressSink* progress);

/// Calls solve() with a block whose looks are reduced by the models of its passes (ReducedBlock),
/// first at the start positions, then at the solved positions, until no reduction changes by more
/// than a millimetre: twice, as a rule. Without models the block is `block` itself.
[[nodiscard]] AdjustResult SolveReduced(const Block& block,
                                        ProgressSink* progress,
                                        const std::function<AdjustResult(const Block&)>& solve);

/// For commands that adjust nothing: refuses `montecarlo` and says that variance components are not
/// estimated.
void RefuseRepetition(const AdjustOptions& options, const char* command, AdjustResult* result);

/// A block whose points are in another order for a while (point_order.h).
class OrderedPoints {
 public:
  /// Reorders `block`, which must outlive this.
  OrderedPoints(PointOrder order, Block* block);

  /// Pairs of the points in their order before, converted to the present order.
  [[nodiscard]] PointPairs Pairs(PointPairs pairs) const;
  /// Converts a result in the present order of the points to their order before. Only what is
  /// listed by point or look changes its place; pairs that were not requested one by one
  /// (`sort_pairs`) are those of the first point with the second and sorted. Call it before
  /// RestoreBlock.
  void RestoreResult(bool sort_pairs, AdjustResult* result) const;
  /// The block becomes what it was, once.
  void RestoreBlock() const;

 private:
  PointOrder order_, back_;
  Block* block_;
};

}  // namespace sarblock
