// SPDX-License-Identifier: Apache-2.0
#include "pieces.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_set>
#include <utility>

#include "block/point_order.h"
#include "core/ranks.h"
#include "core/threads.h"
#include "linear/symbolic.h"
#include "point.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

/// A point of more blocks than this may be in the border.
constexpr std::size_t kMaxEliminated = 512;
/// Points in the border: each costs a solution with three columns a factorisation.
constexpr std::size_t kMaxBordered = 64;
/// Memory of the border's rows where every pass sees its points.
constexpr std::size_t kBorderBytes = std::size_t{128} << 20;
/// The border pays only where it leaves points of so many times fewer blocks.
constexpr std::size_t kGap = 2;
/// All points are in the border only where the corrections are so many times the rows of the
/// border: even without zeros it then takes no more memory than the dense matrix that they would
/// make.
constexpr std::size_t kFewRows = 6;
/// Points with so many pairs of blocks on so few rows make S dense; their pairs are not listed.
constexpr double kManyPairs = 2e7;
/// Operations that take less time than to find an order of elimination does for each pair: eight
/// microseconds at 4 million pairs of 20,000 passes.
constexpr double kOperationsOfOrder = 1000.0;

/// Pairs of blocks seen together: a word a block or a bit table while that is small, else a hash
/// set.
class PairSet {
 public:
  explicit PairSet(std::size_t blocks)
      : blocks_(blocks), words_(blocks <= 64 ? blocks : 0), dense_(blocks <= 16384) {
    if (dense_ && words_.empty()) bits_.assign(blocks * blocks, false);
  }
  /// All pairs of the blocks of a point, ascending.
  void AddPairs(const std::vector<int>& blocks) {
    if (!words_.empty()) {
      std::uint64_t seen = 0;
      for (const int block : blocks) {
        words_[static_cast<std::size_t>(block)] |= seen;
        seen |= std::uint64_t{1} << block;
      }
      return;
    }
    for (std::size_t a = 0; a < blocks.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) Add(blocks[a], blocks[b]);
    }
  }
  [[nodiscard]] std::vector<std::pair<int, int>> Pairs() {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if ((words_[i] >> j & 1U) == 0) continue;
        pairs_.emplace_back(static_cast<int>(i), static_cast<int>(j));
      }
    }
    return std::move(pairs_);
  }

 private:
  void Add(int i, int j) {
    const std::size_t key = static_cast<std::size_t>(i) * blocks_ + static_cast<std::size_t>(j);
    if (dense_) {
      if (bits_[key]) return;
      bits_[key] = true;
    } else if (!seen_.insert(key).second) {
      return;
    }
    pairs_.emplace_back(i, j);
  }

  std::size_t blocks_;
  std::vector<std::uint64_t> words_;  // by block, the earlier ones seen with it
  bool dense_;
  std::vector<bool> bits_;
  std::unordered_set<std::size_t> seen_;
  std::vector<std::pair<int, int>> pairs_;
};

/// Chooses, from points with their numbers of blocks, those seen by many more passes than the
/// points after them.
std::vector<std::uint32_t> ChooseBordered(
    std::vector<std::pair<std::size_t, std::uint32_t>> many_blocks,
    std::size_t most_others,
    std::size_t most) {
  std::stable_sort(many_blocks.begin(), many_blocks.end(), [](const auto& a, const auto& b) {
    return a.first > b.first;
  });
  std::size_t taken = 0;
  for (std::size_t k = 1; k <= std::min(most, many_blocks.size()); ++k) {
    const std::size_t next = k < many_blocks.size() ? many_blocks[k].first : most_others;
    if (many_blocks[k - 1].first >= kGap * next) taken = k;
  }
  std::vector<std::uint32_t> out;
  for (std::size_t k = 0; k < taken; ++k) out.push_back(many_blocks[k].second);
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::uint32_t> FindBordered(const AdjustmentProblem& problem) {
  if (problem.layout.blocks.size() <= kMaxEliminated) return {};
  BlocksOfPoints blocks_of(problem);
  std::vector<std::pair<std::size_t, std::uint32_t>> many_blocks;
  std::size_t most_others = 0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    auto count = static_cast<std::size_t>(problem.CountLooks(point));
    if (count * LookColumns{}.block.size() > kMaxEliminated) {
      count = blocks_of.At(point).size();
    }
    if (count > kMaxEliminated) {
      many_blocks.emplace_back(count, static_cast<std::uint32_t>(point));
    } else {
      most_others = std::max(most_others, count);
    }
  }
  const auto columns = static_cast<std::size_t>(problem.layout.size());
  const std::size_t fit = kBorderBytes / (3 * sizeof(double) * columns);
  return ChooseBordered(std::move(many_blocks), most_others, std::min(fit, kMaxBordered));
}

ReducedPattern PatternWith(const AdjustmentProblem& problem, BorderedPoints bordered) {
  const ParameterLayout& layout = problem.layout;
  ReducedPattern out;
  out.bordered = std::move(bordered);
  std::vector<int> sizes;
  for (const ParameterBlock& block : layout.blocks) sizes.push_back(block.size);
  PairSet seen(layout.blocks.size());
  BlocksOfPoints blocks_of(problem);
  std::vector<int> of_look;
  std::vector<std::pair<int, int>> border;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    const int row = out.bordered.RowOf(point);
    if (row < 0) {
      seen.AddPairs(blocks_of.At(point));
      continue;
    }
    const std::vector<int>& blocks = blocks_of.At(point, [&](const LookColumns& columns) {
      of_look.clear();
      InsertBlocks(columns, &of_look);
      seen.AddPairs(of_look);
    });
    for (const int block : blocks) {
      for (int term = row; term < row + 3; ++term) border.emplace_back(term, block);
    }
  }
  // A process is carried on through knots where nothing is seen.
  for (std::size_t b = 1; b < layout.blocks.size(); ++b) {
    const auto first = static_cast<std::size_t>(layout.blocks[b].offset);
    const auto end = first + static_cast<std::size_t>(layout.blocks[b].size);
    for (std::size_t i = first; i < end; ++i) {
      if (layout.parameters[i].before < 0) continue;
      seen.AddPairs({static_cast<int>(b) - 1, static_cast<int>(b)});
      break;
    }
  }
  out.looks = blocks_of.looks();
  out.columns = blocks_of.columns();
  out.pattern = std::make_shared<const BlockPattern>(std::move(sizes), seen.Pairs());
  out.border = std::make_shared<const BorderPattern>(*out.pattern, out.bordered.rows(), border);
  return out;
}

/// Operations of the factor of S and of what its border leaves of it (BorderedCholesky).
double OperationsOf(const AdjustmentProblem& problem, const ReducedPattern& found) {
  const double rows = found.bordered.rows();
  return sparse::Analyse(*found.pattern, SharedBlocks(problem.layout)).operations +
         found.border->SquareOperations() + rows * rows * rows / 3.0;
}

}  // namespace

std::vector<int> SharedBlocks(const ParameterLayout& layout) {
  std::vector<int> shared;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    if (layout.blocks[b].shared) shared.push_back(static_cast<int>(b));
  }
  return shared;
}

ReducedPattern FindPattern(const AdjustmentProblem& problem, bool allow_border) {
  if (!allow_border) return PatternWith(problem, {});
  // Thousands of passes of a few looks each on few points: what the points leave of the corrections
  // is dense, what the passes leave of the points is small.
  BorderedPoints all;
  double pairs = 0.0;
  const auto columns = static_cast<std::size_t>(problem.layout.size());
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    all.points.push_back(static_cast<std::uint32_t>(point));
    if (3 * kFewRows * all.points.size() > columns) {
      return PatternWith(problem, {FindBordered(problem)});
    }
    const double looks = problem.CountLooks(point);
    pairs += 0.5 * looks * looks;
  }
  if (pairs > kManyPairs) return PatternWith(problem, std::move(all));
  BorderedPoints few{FindBordered(problem)};
  for (const std::uint32_t point : few.points) {
    const double looks = problem.CountLooks(point);
    pairs -= 0.5 * looks * looks;
  }
  ReducedPattern every = PatternWith(problem, std::move(all));
  const double operations = OperationsOf(problem, every);
  if (operations <= kOperationsOfOrder * pairs) return every;
  ReducedPattern some = PatternWith(problem, std::move(few));
  return OperationsOf(problem, some) <= operations ? some : every;
}

namespace {

/// Pieces where so many partial sums may be there at once, each of nearly all of S: more pieces
/// would cost more additions.
constexpr std::size_t kFewPieces = 64, kMinTogether = 8;
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

/// Cuts the points into pieces, in an order or in that of the block.
std::vector<PointPiece> Cut(const AdjustmentProblem& problem,
                            const BlockPattern& pattern,
                            const BorderedPoints& bordered,
                            const std::vector<std::uint32_t>& order,
                            std::size_t most) {
  const std::size_t points = problem.block.points.size();
  const std::size_t count = std::clamp<std::size_t>(points / PointPieces::kMinPoints, 1, most);
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
  if (kMinTogether * DoublesOf(pieces_) <= limit_ * pieces_.size()) return;
  pieces_ = Cut(problem, pattern, bordered, {}, kMaxPieces);
  const std::size_t as_given = DoublesOf(pieces_);
  if (as_given <= kDoublesOfAPoint * problem.block.points.size()) return;
  PointOrder order = SortedByPasses(problem.block);
  std::vector<PointPiece> sorted = Cut(problem, pattern, bordered, order, kMaxPieces);
  if (2 * DoublesOf(sorted) > as_given) return;
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

std::size_t PointPieces::MaxDoubles(int threads) const {
  std::size_t most = 0;
  for (std::size_t first = 0; first < pieces_.size();) {
    const std::size_t end = GroupEnd(first, threads);
    most = std::max(most, DoublesOf(std::span(pieces_).subspan(first, end - first)));
    first = end;
  }
  return most;
}

namespace {

constexpr std::uint32_t kUntouched = PieceScratch::kUntouched;

std::size_t AsSize(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void PartialSum::Take(const PointPiece& piece, const BlockPattern& pattern) {
  CHECK_LT(piece.doubles(), kUntouched);
  piece_ = &piece;
  pattern_ = &pattern;
  numbers_.assign(piece.doubles(), 0.0);
}

void PartialSum::Begin(PieceScratch* scratch) {
  const PointPiece& piece = *piece_;
  const BlockPattern& pattern = *pattern_;
  if (scratch->piece == nullptr) {
    scratch->value_of_slot.assign(pattern.slot_count(), kUntouched);
    scratch->row_of_block.resize(AsSize(pattern.block_count()));
  } else {
    for (const std::uint32_t slot : scratch->piece->slots) {
      scratch->value_of_slot[slot] = kUntouched;
    }
  }
  scratch->piece = &piece;
  std::size_t value = 0;
  for (const std::uint32_t slot : piece.slots) {
    scratch->value_of_slot[slot] = static_cast<std::uint32_t>(value);
    value += pattern.ValuesOf(slot);
  }
  for (std::size_t b = 0; b < piece.blocks.size(); ++b) {
    scratch->row_of_block[AsSize(piece.blocks[b])] = static_cast<std::uint32_t>(piece.row_begin[b]);
  }
}

PointBlocks PartialSum::Blocks(const ParameterLayout& layout, PieceScratch* scratch) const {
  PointTerms& terms = scratch->terms;
  const PointBlocks blocks = FindSlots(layout, *pattern_, &terms);
  for (std::size_t& at : terms.value) {
    at = scratch->value_of_slot[at];
    CHECK_NE(at, kUntouched) << "a look takes part that did not when the points were cut";
  }
  return blocks;
}

void PartialSum::AddLooks(const ParameterLayout& layout,
                          Row gradient,
                          const PieceScratch& scratch) {
  for (int k = 0; k < scratch.factor.look_count; ++k) {
    const WhitenedLook& look = scratch.factor.looks[AsSize(k)];
    const double* range = look.row[0].data();
    const double* doppler = look.row[1].data();
    for (int b = 0; b < look.columns.block_count; ++b) {
      const int id = look.columns.block[AsSize(b)];
      const int size = layout.blocks[AsSize(id)].size;
      const std::uint32_t row = scratch.row_of_block[AsSize(id)];
      Kernels().AddLook(size,
                        range,
                        doppler,
                        look.whitened_error.data(),
                        Vector(Row::kDiagonal) + row,
                        Vector(gradient) + row);
      range += size;
      doppler += size;
    }
  }
}

/// A' B over the blocks of one look, two rows each.
void PartialSum::AddSquareOfLook(const ParameterLayout& layout,
                                 const LookColumns& columns,
                                 const double* a,
                                 const double* b,
                                 const PieceScratch& scratch) {
  constexpr std::size_t kStride = ParameterLayout::kMaxLocalColumns;
  int first = 0;
  for (int i = 0; i < columns.block_count; ++i) {
    const int id = columns.block[AsSize(i)];
    const int size = layout.blocks[AsSize(id)].size;
    int other = 0;
    for (int j = 0; j < columns.block_count; ++j) {
      const int id2 = columns.block[AsSize(j)];
      const int size2 = layout.blocks[AsSize(id2)].size;
      if (id2 <= id) {
        const std::size_t slot = id2 == id ? pattern_->FirstSlot(id) : pattern_->Slot(id, id2);
        CHECK_NE(scratch.value_of_slot[slot], kUntouched);
        double* const at = numbers_.data() + scratch.value_of_slot[slot];
        Kernels().AddProducts(at, size, size2, a + first, b + other, kStride, 2);
      }
      other += size2;
    }
    first += size;
  }
}

/// J_c' J_c of each look's own blocks, and of its rows.
void PartialSum::AddSquaresOfLooks(const ParameterLayout& layout, const PieceScratch& scratch) {
  const PointFactor& factor = scratch.factor;
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[AsSize(k)];
    AddSquareOfLook(layout, look.columns, look.row[0].data(), look.row[0].data(), scratch);
  }
  for (int k = 0; k < factor.curved_count; ++k) {
    const CurvedRows& rows = factor.curved[AsSize(k)];
    auto with_sign = rows.row;
    for (std::size_t row = 0; row < 2; ++row) {
      for (std::size_t c = 0; c < AsSize(rows.columns->column_count); ++c) {
        with_sign[row][c] *= rows.sign[static_cast<Eigen::Index>(row)];
      }
    }
    AddSquareOfLook(layout, *rows.columns, with_sign[0].data(), rows.row[0].data(), scratch);
  }
}

/// Right side += sum_k c_k x_k over the blocks of a point, x_k rows of the width.
void PartialSum::AddRightSide(const ParameterLayout& layout,
                              const double* x,
                              std::span<const double> c,
                              const PieceScratch& scratch) {
  const PointColumns& columns = scratch.terms.columns;
  for (std::size_t j = 0; j < columns.blocks.size(); ++j) {
    const std::size_t id = AsSize(columns.blocks[j]);
    Kernels().AddCombination(layout.blocks[id].size,
                             x + columns.begin[j],
                             AsSize(columns.width),
                             static_cast<int>(c.size()),
                             c.data(),
                             Vector(Row::kRightSide) + scratch.row_of_block[id]);
  }
}

/// A point by what its elimination leaves: the square of N' J_c. No digit is lost to thin
/// intersections.
void PartialSum::AddRest(const ParameterLayout& layout, PieceScratch* scratch) {
  PointTerms& terms = scratch->terms;
  FindColumns(layout, scratch->factor, &terms.columns);
  const PointBlocks blocks = Blocks(layout, scratch);
  ProjectToLeftNullSpace(layout, scratch->factor, &terms);
  Kernels().AddSquare(blocks,
                      terms.rest.data(),
                      AsSize(terms.columns.width),
                      static_cast<int>(terms.rest_e.size()),
                      1.0,
                      numbers_.data());
  AddRightSide(layout, terms.rest.data(), terms.rest_e, *scratch);
}

/// J_c' J_c of a point, and the right side of J_c' J_c - T' T.
void PartialSum::AddUnreduced(const AdjustmentProblem& problem,
                              const Eigen::Vector3d& c,
                              PieceScratch* scratch) {
  PointColumns& columns = scratch->terms.columns;
  ProjectColumns(problem, scratch->factor, &columns);
  AddLooks(problem.layout, Row::kSubtractedGradient, *scratch);
  AddSquaresOfLooks(problem.layout, *scratch);
  const Eigen::Vector3d taken = -c;
  AddRightSide(
      problem.layout, columns.t.data(), std::span<const double>(taken.data(), 3), *scratch);
  totals_.any_subtracted = true;
}

/// A point by J_c' J_c - T' T: three rows, however many looks. That subtraction costs digits where
/// points take most of what a correction's equations say.
void PartialSum::AddDifference(const AdjustmentProblem& problem,
                               const Eigen::Vector3d& c,
                               PieceScratch* scratch) {
  AddUnreduced(problem, c, scratch);
  const PointBlocks blocks = Blocks(problem.layout, scratch);
  const PointColumns& columns = scratch->terms.columns;
  Kernels().AddSquare(blocks, columns.t.data(), AsSize(columns.width), 3, -1.0, numbers_.data());
}

/// A point of the border by J_c' J_c and three rows T of the border.
void PartialSum::AddBordered(const PointEquations& equations,
                             const Eigen::Vector3d& c,
                             int row,
                             PieceScratch* scratch) {
  AddUnreduced(equations.problem, c, scratch);
  const PointColumns& columns = scratch->terms.columns;
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> t(
      columns.t.data(), 3, columns.width);
  for (std::size_t b = 0; b < columns.blocks.size(); ++b) {
    const ParameterBlock& block = equations.problem.layout.blocks[AsSize(columns.blocks[b])];
    for (int i = 0; i < block.size; ++i) {
      Eigen::Map<Eigen::Vector3d>(equations.border->At(row, block.offset + i)) =
          t.col(columns.begin[b] + i);
    }
  }
}

void PartialSum::Add(const PointEquations& equations, std::size_t point, PieceScratch* scratch) {
  const AdjustmentProblem& problem = equations.problem;
  const bool damped = equations.damping != 0.0;
  PointFactor& factor = scratch->factor;
  scratch->terms.columns.t.clear();
  factor.weight_change = 0.0;
  FactorPoint(problem, equations.state, equations.weighting, equations.damping, point, &factor);
  if (equations.following != nullptr && SettlePoint(problem,
                                                    equations.weighting,
                                                    equations.damping,
                                                    equations.settle_below,
                                                    point,
                                                    equations.following,
                                                    &factor)) {
    moved_.push_back(static_cast<std::uint32_t>(point));
  }
  totals_.cost += factor.cost;
  totals_.not_evaluated += factor.looks_not_evaluated;
  if (factor.looks_not_evaluated > 0) {
    totals_.first_not_evaluated = std::min(totals_.first_not_evaluated, point);
  }
  totals_.beyond_path += factor.looks_beyond_path;
  totals_.weight_change = std::max(totals_.weight_change, factor.weight_change);
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (!(factor.square[k] > 0.0)) continue;
    const double g = factor.gradient[k];
    totals_.gradient_square = std::max(totals_.gradient_square, g * g / factor.square[k]);
  }
  if (!damped && !(factor.reciprocal_condition >= kMinPointCondition)) {
    AddLooks(problem.layout, Row::kExactGradient, *scratch);
    weak_.push_back({static_cast<std::uint32_t>(point), factor.reciprocal_condition});
    return;
  }
  const Eigen::Vector3d c = Project(factor, factor.e);
  totals_.step_square += c.squaredNorm();
  const int border_row = equations.bordered.RowOf(point);
  if (border_row >= 0) {  // of hundreds of looks: it takes little of the equations of each
    AddBordered(equations, c, border_row, scratch);
    return;
  }
  // Up to three rows left are no more work than the three of T.
  const bool by_rest = !damped && !equations.weighting.curved;
  if (by_rest && (equations.exact || factor.row_count <= 6)) {
    AddLooks(problem.layout, Row::kExactGradient, *scratch);
    AddRest(problem.layout, scratch);
  } else {
    AddDifference(problem, c, scratch);
  }
}

void PartialSum::AddColumns(int begin, int end, const NormalSums& sums) const {
  const std::vector<int>& blocks = piece_->blocks;
  const auto first = std::lower_bound(blocks.begin(), blocks.end(), begin);
  const auto last = std::lower_bound(first, blocks.end(), end);
  if (first == last) return;
  auto b = static_cast<std::size_t>(first - blocks.begin());
  const double* value = numbers_.data() + piece_->value_begin[b];
  double* const all = sums.s->values().data();
  for (; b < static_cast<std::size_t>(last - blocks.begin()); ++b) {
    for (std::uint32_t k = piece_->slot_begin[b]; k < piece_->slot_begin[b + 1]; ++k) {
      double* const sum = all + pattern_->ValueBegin(piece_->slots[k]);
      const std::size_t size = pattern_->ValuesOf(piece_->slots[k]);
      for (std::size_t i = 0; i < size; ++i) sum[i] += value[i];
      value += size;
    }
    const Eigen::Index offset = pattern_->offset(blocks[b]), size = pattern_->size(blocks[b]);
    const auto part = [&](Row which) {
      return Eigen::Map<const Eigen::VectorXd>(Vector(which) + piece_->row_begin[b], size);
    };
    sums.right_side->segment(offset, size) +=
        part(Row::kRightSide) + part(Row::kSubtractedGradient);
    sums.diagonal->segment(offset, size) += part(Row::kDiagonal);
    sums.gradient->segment(offset, size) +=
        part(Row::kExactGradient) + part(Row::kSubtractedGradient);
  }
}

namespace {

/// What the points of a piece made beside its partial sum.
void AddPointParts(const PointPieces& pieces,
                   const PointPiece& piece,
                   const PointEquations& equations,
                   int rank,
                   std::vector<RankPart>* parts) {
  std::vector<LookWeights>* const renewed = equations.weighting.renewed;
  Border& border = *equations.border;
  if (renewed == nullptr && border.terms() == 0) return;
  const std::vector<std::uint64_t>& offsets = equations.problem.block.looks.offsets;
  for (std::size_t place = piece.begin; place < piece.end; ++place) {
    const std::size_t point = pieces.PointAt(place);
    if (renewed != nullptr) {
      const std::size_t begin = offsets[point], count = offsets[point + 1] - begin;
      AddPart(std::as_writable_bytes(std::span(*renewed).subspan(begin, count)), rank, parts);
    }
    const int row = equations.bordered.RowOf(point);
    if (row < 0) continue;
    for (const int group : border.pattern().GroupsOf(row)) {
      for (const int column : border.pattern().groups()[AsSize(group)].columns) {
        AddPart(std::as_writable_bytes(std::span(border.At(row, column), 3)), rank, parts);
      }
    }
  }
}

}  // namespace

std::vector<int> SharePieces(const PointPieces& pieces,
                             const BlockPattern& pattern,
                             const PointEquations& equations,
                             std::size_t first,
                             std::vector<PartialSum>* parts) {
  Ranks* const ranks = RanksScope::Current();
  std::vector<int> rank_of(parts->size(), 0);
  if (ranks == nullptr) return rank_of;
  std::vector<RankPart> sums, of_points;
  for (int r = 0; r < ranks->size(); ++r) {
    const PiecesOfRank its = PiecesOf(parts->size(), r, ranks->size());
    for (std::size_t k = its.first; k < its.last; ++k) {
      rank_of[k] = r;
      PartialSum& part = (*parts)[k];
      const PointPiece& piece = pieces[first + k];
      if (r != ranks->rank()) part.Take(piece, pattern);
      AddPart(std::as_writable_bytes(part.numbers()), r, &sums);
      AddPointParts(pieces, piece, equations, r, &of_points);
    }
  }
  ranks->Share(sums);
  if (!of_points.empty()) ranks->Share(of_points);
  return rank_of;
}

}  // namespace sarblock
