// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/problem.h"
#include "reduced_pattern.h"

namespace sarblock {

/// Points that are summed one after the other into one partial sum, and what of S they touch: a
/// partial sum holds no other blocks. The diagonal block of every touched parameter block is among
/// them.
struct PointPiece {
  std::size_t begin = 0, end = 0;         ///< places, see PointPieces::PointAt
  std::vector<int> blocks;                ///< parameter blocks, ascending
  std::vector<std::uint32_t> slots;       ///< of S, ascending: by column those of `blocks`
  std::vector<std::uint32_t> slot_begin;  ///< by block: the first of its column in `slots`, and end
  std::vector<std::size_t> value_begin;   ///< by block: its first value in the partial sum
  std::vector<std::size_t> row_begin;     ///< by block: its first row in the partial sum
  std::size_t values = 0;                 ///< doubles of the blocks of S
  std::size_t rows = 0;                   ///< rows of `blocks`
  double operations = 0.0;                ///< of the squares of its points

  /// Vectors over the rows beside the blocks of S (partial_sum.h).
  static constexpr std::size_t kVectors = 4;
  /// Doubles of its partial sum.
  [[nodiscard]] std::size_t doubles() const { return values + kVectors * rows; }
};

/// How the sum over points is cut. Pieces, their order and the order of points in them depend on
/// the block alone. A group of pieces is summed side by side, then added to S in the order of
/// pieces, every column by one thread; so the bytes of S depend neither on the threads nor on the
/// groups, and groups can be as small as memory asks for.
///
/// Where points stand in an order in which every piece would touch much of S, they are taken in
/// that of the passes that see them (block/point_order.h): neighbours then share their blocks.
class PointPieces {
 public:
  PointPieces() = default;
  /// Of the points that take part; looks may be left out later, but none may be added.
  /// `small_group`: doubles that a group may always have; tests give less.
  PointPieces(const AdjustmentProblem& problem,
              const BlockPattern& pattern,
              const BorderedPoints& bordered,
              std::size_t small_group = kSmallGroup);

  /// Fewest points of a piece, where there are more; most pieces.
  static constexpr std::size_t kLeastPoints = 128;
  static constexpr std::size_t kMostPieces = 1024;
  /// Partial sums of a group hold at most twice what S and its right side take, or this many
  /// doubles (64 MiB) where that is more.
  static constexpr std::size_t kSmallGroup = std::size_t{1} << 23;

  [[nodiscard]] std::size_t size() const { return pieces_.size(); }
  [[nodiscard]] const PointPiece& operator[](std::size_t piece) const { return pieces_[piece]; }
  [[nodiscard]] std::size_t PointAt(std::size_t place) const {
    return order_.empty() ? place : order_[place];
  }
  /// One past the last piece of the group that begins with piece `first`: at most four a thread or
  /// 64, at least two.
  [[nodiscard]] std::size_t GroupEnd(std::size_t first, int threads) const;
  /// Doubles of the largest group.
  [[nodiscard]] std::size_t MostDoubles(int threads) const;
  /// Of the squares of all points, half of the columns' squares times the rows left of them.
  [[nodiscard]] double operations() const;
  /// Doubles that the partial sums of a group may have together.
  [[nodiscard]] std::size_t limit() const { return limit_; }

 private:
  std::vector<PointPiece> pieces_;
  std::vector<std::uint32_t> order_;  // points by place; empty: as they stand
  std::size_t limit_ = kSmallGroup;
};

}  // namespace sarblock
