// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "linear/block_matrix.h"
#include "model/problem.h"
#include "point.h"
#include <Eigen/Core>

namespace sarblock {

/// Points with three rows each in the border of the reduced matrix, ascending.
struct BorderedPoints {
  std::vector<std::uint32_t> points;

  [[nodiscard]] int rows() const { return 3 * static_cast<int>(points.size()); }
  /// First row of a point, or -1 where it is eliminated.
  [[nodiscard]] int RowOf(std::size_t point) const {
    if (points.empty()) return -1;
    const auto at = std::lower_bound(points.begin(), points.end(), point);
    return at == points.end() || *at != point ? -1 : 3 * static_cast<int>(at - points.begin());
  }
};

/// Where the reduced matrix has blocks, which points are in its border, and how much the looks in
/// use have together.
///
/// A point couples all passes that see it: thousands of them would make the matrix dense. Such
/// points, where they are few, stay out of the pattern; three rows of the border say what each
/// takes (linear/block_cholesky.h; docs/theory/covariance.md, "Points that many passes see").
struct ReducedPattern {
  std::shared_ptr<const BlockPattern> pattern;
  BorderedPoints bordered;
  std::shared_ptr<const BorderPattern> border;  ///< of the rows of `bordered`
  std::size_t looks = 0, columns = 0;
};

/// Blocks of corrections that passes share, which S eliminates last.
[[nodiscard]] std::vector<int> SharedBlocks(const ParameterLayout& layout);

/// From the looks that take part. Without `allow_border` every point is eliminated.
[[nodiscard]] ReducedPattern FindPattern(const AdjustmentProblem& problem, bool allow_border);

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

  /// Vectors over the rows beside the blocks of S (pieces.h).
  static constexpr std::size_t kVectors = 4;
  /// Doubles of its partial sum.
  [[nodiscard]] std::size_t doubles() const { return values + kVectors * rows; }
};

/// How the sum over points is cut. Pieces, their order and the order of points in them depend on
/// the block alone. A group of pieces is summed side by side, then added to S in the order of
/// pieces, every column by one thread; so the bytes of S depend neither on the threads nor on the
/// groups, and groups can be as small as memory asks for.
///
/// If every piece of points in their own order would touch much of S, points are taken in the order
/// of the passes that see them (block/point_order.h): neighbours then share their blocks.
class PointPieces {
 public:
  PointPieces() = default;
  /// Cuts the points that take part; looks may be left out later, but none may be added.
  /// `small_group`: doubles that a group may always have; tests give less.
  PointPieces(const AdjustmentProblem& problem,
              const BlockPattern& pattern,
              const BorderedPoints& bordered,
              std::size_t small_group = kSmallGroup);

  /// Least number of points of a piece, where the block has more; largest number of pieces.
  static constexpr std::size_t kMinPoints = 128;
  static constexpr std::size_t kMaxPieces = 1024;
  /// Partial sums of a group hold at most twice what S and its right side take, or this many
  /// doubles (64 MiB) where that is more.
  static constexpr std::size_t kSmallGroup = std::size_t{1} << 23;

  [[nodiscard]] std::size_t size() const { return pieces_.size(); }
  [[nodiscard]] const PointPiece& operator[](std::size_t piece) const { return pieces_[piece]; }
  [[nodiscard]] std::size_t PointAt(std::size_t place) const {
    return order_.empty() ? place : order_[place];
  }
  /// One past the last piece of the group that begins with piece `first`: at most four per thread
  /// or 64, at least two.
  [[nodiscard]] std::size_t GroupEnd(std::size_t first, int threads) const;
  /// Doubles of the largest group.
  [[nodiscard]] std::size_t MaxDoubles(int threads) const;
  /// Operations of the squares of all points: half of the columns' squares times the rows left of
  /// them.
  [[nodiscard]] double operations() const;
  /// Doubles that the partial sums of a group may have together.
  [[nodiscard]] std::size_t limit() const { return limit_; }

 private:
  std::vector<PointPiece> pieces_;
  std::vector<std::uint32_t> order_;  // points by place; empty: in the order of the block
  std::size_t limit_ = kSmallGroup;
};

/// What the equations of points are formed from, and the border that takes the rows of some.
struct PointEquations {
  const AdjustmentProblem& problem;
  const BlockState& state;
  const Weighting& weighting;
  const BorderedPoints& bordered;
  double damping = 0.0;
  bool exact = false;  ///< by what is left of a point's equations, however many they are
  BlockState* following = nullptr;  ///< `state`, where its points are settled (SettlePoint)
  double settle_below = 0.0;
  Border* border = nullptr;
};

/// The sums over all points: S, its right side, and of J_c before elimination the diagonal of
/// J_c' J_c and J_c' e.
struct NormalSums {
  BlockSymmetricMatrix* s;
  Eigen::VectorXd *right_side, *diagonal, *gradient;
};

/// Sums over points that are not elements of S.
struct PointTotals {
  static constexpr std::size_t kNoPoint = static_cast<std::size_t>(-1);
  double cost = 0.0, step_square = 0.0, gradient_square = 0.0, weight_change = 0.0;
  int not_evaluated = 0, beyond_path = 0;
  std::size_t first_not_evaluated = kNoPoint;  ///< the first point with such a look
  bool any_subtracted = false;                 ///< a point was added as a difference
};

/// Scratch of one piece at a time.
struct PieceScratch {
  static constexpr std::uint32_t kUntouched = 0xffffffffu;
  PointFactor factor;
  PointTerms terms;
  const PointPiece* piece = nullptr;         ///< last begun
  std::vector<std::uint32_t> value_of_slot;  ///< in its partial sum, or kUntouched
  std::vector<std::uint32_t> row_of_block;   ///< valid for its blocks
};

/// What the points of a piece add to S and to the vectors beside it, only where they add anything:
/// one array of PointPiece::doubles().
class PartialSum {
 public:
  /// Takes the memory, all zero; `piece` and `pattern` must outlive this.
  void Take(const PointPiece& piece, const BlockPattern& pattern);
  /// Finds the places, before the first point.
  void Begin(PieceScratch* scratch);
  /// Adds a point; one whose own equations are rank deficient is only listed in weak(). Leaves its
  /// factor and columns in the scratch.
  void Add(const PointEquations& equations, std::size_t point, PieceScratch* scratch);
  /// Adds the columns [begin, end) of blocks to the sums over all points.
  void AddColumns(int begin, int end, const NormalSums& sums) const;
  [[nodiscard]] const PointTotals& totals() const { return totals_; }
  /// Points whose own equations are rank deficient.
  [[nodiscard]] const std::vector<WeakPoint>& weak() const { return weak_; }
  /// Points that were moved until they were settled.
  [[nodiscard]] const std::vector<std::uint32_t>& moved() const { return moved_; }
  /// The array.
  [[nodiscard]] std::span<double> numbers() { return numbers_; }

 private:
  /// The vectors behind the blocks of S.
  enum class Row : std::size_t { kRightSide, kDiagonal, kExactGradient, kSubtractedGradient };
  [[nodiscard]] const double* Vector(Row row) const {
    return numbers_.data() + piece_->values + static_cast<std::size_t>(row) * piece_->rows;
  }
  [[nodiscard]] double* Vector(Row row) {
    return numbers_.data() + piece_->values + static_cast<std::size_t>(row) * piece_->rows;
  }
  /// Places of the blocks of a point in the partial sum.
  [[nodiscard]] PointBlocks Blocks(const ParameterLayout& layout, PieceScratch* scratch) const;
  void AddLooks(const ParameterLayout& layout, Row gradient, const PieceScratch& scratch);
  void AddSquareOfLook(const ParameterLayout& layout,
                       const LookColumns& columns,
                       const double* a,
                       const double* b,
                       const PieceScratch& scratch);
  void AddSquaresOfLooks(const ParameterLayout& layout, const PieceScratch& scratch);
  void AddRightSide(const ParameterLayout& layout,
                    const double* x,
                    std::span<const double> c,
                    const PieceScratch& scratch);
  void AddRest(const ParameterLayout& layout, PieceScratch* scratch);
  void AddUnreduced(const AdjustmentProblem& problem,
                    const Eigen::Vector3d& c,
                    PieceScratch* scratch);
  void AddDifference(const AdjustmentProblem& problem,
                     const Eigen::Vector3d& c,
                     PieceScratch* scratch);
  void AddBordered(const PointEquations& equations,
                   const Eigen::Vector3d& c,
                   int row,
                   PieceScratch* scratch);

  const PointPiece* piece_ = nullptr;
  const BlockPattern* pattern_ = nullptr;
  std::vector<double> numbers_;
  PointTotals totals_;
  std::vector<WeakPoint> weak_;
  std::vector<std::uint32_t> moved_;
};

/// Shares among ranks (core/ranks.h) what each computed for its pieces of a group: the partial
/// sums, the weights that were renewed on the way and the rows of the border. `parts` are those of
/// the pieces from `first` on, divided among the ranks as ForChunksOfRanks divides them. Returns
/// the rank of each; without ranks nothing is done and all are of rank 0.
std::vector<int> SharePieces(const PointPieces& pieces,
                             const BlockPattern& pattern,
                             const PointEquations& equations,
                             std::size_t first,
                             std::vector<PartialSum>* parts);

}  // namespace sarblock
