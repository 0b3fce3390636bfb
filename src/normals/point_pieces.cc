// SPDX-License-Identifier: Apache-2.0
#include "point_pieces.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "block/point_order.h"
#include "core/threads.h"
#include "point_blocks.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

/// Pieces where so many partial sums may be there at once, each of nearly all of S: more pieces
/// would cost more additions.
constexpr std::size_t kFewPieces = 64, kLeastAtOnce = 8;
/// To add up a number of partial sums takes a nanosecond or two. To take a point out of the order
/// in which looks stand in memory costs as much as to add up so many.
constexpr std::size_t kDoublesOfAPoint = 1000;

/// Scratch of the search for what a piece touches.
struct Marks {
  std::optional<BlocksOfPoints> blocks_of;
  std::vector<std::uint8_t> block, slot;
  std::vector<std::size_t> pairs;
  std::vector<int> of_look;
};

/// Adds the pairs of an ascending list of blocks.
void MarkPairs(const BlockPattern& pattern,
               const std::vector<int>& blocks,
               Marks* marks,
               PointPiece* piece) {
  marks->pairs.resize(blocks.size() * (blocks.size() + 1) / 2);
  pattern.SlotsOfPairs(blocks, marks->pairs.data());
  for (const std::size_t slot : marks->pairs) {
    if (std::exchange(marks->slot[slot], 1) == 0) {
      piece->slots.push_back(static_cast<std::uint32_t>(slot));
    }
  }
  for (const int block : blocks) {
    if (std::exchange(marks->block[static_cast<std::size_t>(block)], 1) == 0) {
      piece->blocks.push_back(block);
    }
  }
}

/// Sorts what was found, counts it and leaves the marks as they were.
void Finish(const BlockPattern& pattern, Marks* marks, PointPiece* piece) {
  for (const std::uint32_t slot : piece->slots) marks->slot[slot] = 0;
  for (const int block : piece->blocks) marks->block[static_cast<std::size_t>(block)] = 0;
  std::sort(piece->slots.begin(), piece->slots.end());
  std::sort(piece->blocks.begin(), piece->blocks.end());
  piece->slots.shrink_to_fit();
  piece->blocks.shrink_to_fit();
  piece->slot_begin.reserve(piece->blocks.size() + 1);
  piece->value_begin.reserve(piece->blocks.size());
  piece->row_begin.reserve(piece->blocks.size());
  std::uint32_t at = 0;
  for (const int block : piece->blocks) {
    CHECK_EQ(piece->slots[at], pattern.FirstSlot(block));
    piece->slot_begin.push_back(at);
    piece->value_begin.push_back(piece->values);
    piece->row_begin.push_back(piece->rows);
    for (; at < piece->slots.size() && piece->slots[at] < pattern.FirstSlot(block + 1); ++at) {
      piece->values += pattern.ValuesOf(piece->slots[at]);
    }
    piece->rows += static_cast<std::size_t>(pattern.size(block));
  }
  piece->slot_begin.push_back(at);
  CHECK_EQ(at, piece->slots.size());
}

/// Doubles of S and of the vectors beside it.
std::size_t WholeOf(const BlockPattern& pattern) {
  return pattern.ValueBegin(pattern.slot_count()) +
         PointPiece::kVectors * static_cast<std::size_t>(pattern.rows());
}

/// Cuts the points into pieces, in an order or as they stand.
std::vector<PointPiece> Cut(const AdjustmentProblem& problem,
                            const BlockPattern& pattern,
                            const BorderedPoints& bordered,
                            const std::vector<std::uint32_t>& order,
                            std::size_t most) {
  const std::size_t points = problem.block.points.size();
  const std::size_t count = std::clamp<std::size_t>(points / PointPieces::kLeastPoints, 1, most);
  const std::size_t per_piece = (points + count - 1) / count;
  std::vector<PointPiece> pieces(points == 0 ? 0 : (points + per_piece - 1) / per_piece);
  Pool<Marks> pool;
  ParallelForChunks(points, per_piece, [&](std::size_t k, std::size_t begin, std::size_t end) {
    const auto marks = pool.Borrow();
    if (!marks->blocks_of) {
      marks->blocks_of.emplace(problem);
      marks->block.assign(static_cast<std::size_t>(pattern.block_count()), 0);
      marks->slot.assign(pattern.slot_count(), 0);
    }
    PointPiece& piece = pieces[k];
    piece.begin = begin;
    piece.end = end;
    for (std::size_t place = begin; place < end; ++place) {
      const std::size_t point = order.empty() ? place : order[place];
      if (!problem.Solves(point)) continue;
      const std::size_t looks = marks->blocks_of->looks();
      if (bordered.RowOf(point) < 0) {
        const std::vector<int>& blocks = marks->blocks_of->At(point);
        MarkPairs(pattern, blocks, &*marks, &piece);
        double columns = 0.0;
        for (const int block : blocks) columns += pattern.size(block);
        const double rows = 2.0 * static_cast<double>(marks->blocks_of->looks() - looks) - 3.0;
        piece.operations += 0.5 * columns * columns * std::max(rows, 3.0);
        continue;
      }
      const std::vector<int>& blocks = marks->blocks_of->At(point, [&](const LookColumns& look) {
        marks->of_look.clear();
        InsertBlocks(look, &marks->of_look);
        MarkPairs(pattern, marks->of_look, &*marks, &piece);
      });
      for (const int block : blocks) MarkPairs(pattern, {block}, &*marks, &piece);
    }
    Finish(pattern, &*marks, &piece);
  });
  return pieces;
}

std::size_t DoublesOf(std::span<const PointPiece> pieces) {
  std::size_t sum = 0;
  for (const PointPiece& piece : pieces) sum += piece.doubles();
  return sum;
}

}  // namespace

PointPieces::PointPieces(const AdjustmentProblem& problem,
                         const BlockPattern& pattern,
                         const BorderedPoints& bordered,
                         std::size_t small_group)
    : pieces_(Cut(problem, pattern, bordered, {}, kFewPieces)),
      limit_(std::max(2 * WholeOf(pattern), small_group)) {
  if (kLeastAtOnce * DoublesOf(pieces_) <= limit_ * pieces_.size()) return;
  pieces_ = Cut(problem, pattern, bordered, {}, kMostPieces);
  const std::size_t as_they_stand = DoublesOf(pieces_);
  if (as_they_stand <= kDoublesOfAPoint * problem.block.points.size()) return;
  PointOrder order = SortedByPasses(problem.block);
  std::vector<PointPiece> sorted = Cut(problem, pattern, bordered, order, kMostPieces);
  if (2 * DoublesOf(sorted) > as_they_stand) return;
  pieces_ = std::move(sorted);
  order_ = std::move(order);
}

std::size_t PointPieces::GroupEnd(std::size_t first, int threads) const {
  const std::size_t most = std::max<std::size_t>(64, 4 * static_cast<std::size_t>(threads));
  std::size_t end = first, doubles = 0;
  while (end < pieces_.size() && end - first < most) {
    doubles += pieces_[end].doubles();
    if (end > first && doubles > limit_) break;
    ++end;
  }
  return end;
}

double PointPieces::operations() const {
  double sum = 0.0;
  for (const PointPiece& piece : pieces_) sum += piece.operations;
  return sum;
}

std::size_t PointPieces::MostDoubles(int threads) const {
  std::size_t most = 0;
  for (std::size_t first = 0; first < pieces_.size();) {
    const std::size_t end = GroupEnd(first, threads);
    most = std::max(most, DoublesOf(std::span(pieces_).subspan(first, end - first)));
    first = end;
  }
  return most;
}

}  // namespace sarblock
