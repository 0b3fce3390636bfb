// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "linear/block_matrix.h"
#include "model/problem.h"
#include "point_factor.h"
#include "point_pieces.h"
#include "point_terms.h"
#include "weak_point.h"
#include <Eigen/Core>

namespace sarblock {

/// What the equations of points are formed from, and the border that takes the rows of some.
struct PointEquations {
  const AdjustmentProblem& problem;
  const BlockState& state;
  const Weighting& weighting;
  const BorderedPoints& bordered;
  double damping_1 = 0.0;
  bool exact = false;  ///< by what is left of a point's equations, however many they are
  Eigen::MatrixXd* border = nullptr;
};

/// The sums over all points: S, its right side, and of J_c before elimination the diagonal of
/// J_c' J_c and J_c' e.
struct NormalSums {
  BlockSymmetricMatrix* s;
  Eigen::VectorXd *right_side, *diagonal, *gradient;
};

/// Numbers of points without a place in S.
struct PointTotals {
  double cost_1 = 0.0, step_square_1 = 0.0, gradient_square_1 = 0.0;
  int not_evaluated = 0, beyond_path = 0;
  bool any_subtracted = false;  ///< a point was added as a difference
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
  /// Adds a point; one whose own equations are rank deficient is only named. Leaves its factor and
  /// columns in the scratch.
  void Add(const PointEquations& equations, std::size_t point, PieceScratch* scratch);
  /// Adds the columns [begin, end) of blocks to the sums over all points.
  void AddColumns(int begin, int end, const NormalSums& sums) const;
  [[nodiscard]] const PointTotals& totals() const { return totals_; }
  /// Points whose own equations are rank deficient.
  [[nodiscard]] const std::vector<WeakPoint>& weak() const { return weak_; }
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
  /// Where the blocks of a point stand in the partial sum.
  [[nodiscard]] PointBlocks Blocks(const ParameterLayout& layout, PieceScratch* scratch) const;
  void AddLooks(const ParameterLayout& layout, Row gradient, const PieceScratch& scratch);
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
};

}  // namespace sarblock
