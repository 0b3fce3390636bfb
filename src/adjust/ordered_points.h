// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include "block/point_order.h"

namespace sarblock {

/// A block whose points stand in another order for a while (point_order.h).
class OrderedPoints {
 public:
  /// Reorders `block`, which must outlive this.
  OrderedPoints(PointOrder order, Block* block);

  /// Pairs of the points as they stood before, as they stand now.
  [[nodiscard]] PointPairs Pairs(PointPairs pairs) const;
  /// A result of the points as they stand now becomes one of the points as they stood before. Only
  /// what is listed by point or look changes its place; pairs that were not asked for one by one
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
