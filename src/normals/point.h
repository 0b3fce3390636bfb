// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels.h"
#include "linear/block_matrix.h"
#include "model/look_model.h"
#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// How looks are weighted in a linearisation.
struct Weighting {
  RobustLoss loss = RobustLoss::kNone;
  double scale = 0.0;
  /// Uses the curvature of a loss along the residual (BendAlongResidual): for the solver's last
  /// steps.
  bool second_order = false;
  /// Adds residuals times second derivatives of each look (CurvedRows); damped or not, S is then
  /// summed as a difference.
  bool curved = false;
  /// Where given, the weights of the problem: looks are weighted as UpdateWeights would at this
  /// state, and their weights put there. Else they are weighted as they are.
  std::vector<LookWeights>* renewed = nullptr;
};

/// One look at one state, weighted: its two equations are standard normal if the model is true.
/// Under a robust loss both carry the square root of the look's weight.
struct WhitenedLook : LookEvaluation {
  std::size_t look = 0;  ///< index in the block
  LookColumns columns;
  double weight_change = 0.0;  ///< relative, of the azimuth, where weights are renewed
  double cost = 0.0;           ///< half the squared length, robust loss applied
  double radial = 1.0;         ///< RobustValue::radial
  int curved_count = 0;        ///< CurvedRows that it has, where these are asked for
};

/// What the errors of a look times its second derivatives (LookCurvature) add to J'J: the sum over
/// the rows g, two here and at most seven of a look, of sign g' g. Gauss-Newton leaves it out; in a
/// direction that is known only to some ten metres it is as much as all the rest.
struct CurvedRows {
  static constexpr int kMaxPerLook = 4;  ///< of an odd number of rows the last is 0
  const LookColumns* columns = nullptr;
  Eigen::Vector2d sign = Eigen::Vector2d::Ones();
  Eigen::Matrix<double, 2, 3> d_point;
  std::array<std::array<double, ParameterLayout::kMaxLocalColumns>, 2> row;
  Eigen::Matrix<double, 3, 2> turned;  ///< R^-T g' sign of each row, as Q' of those of J_p
};

/// The equations of one point and the thin QR factorisation of their Jacobian by the point
/// (docs/theory/covariance.md, eq. (22)):
///
///     J_p = Q R,   c = Q' e;   two rows per look in use, the rows of its control, then, if damped,
///                              three rows sqrt(damping J_p' J_p)
///
/// J_c stays with the looks, each its own columns: this is what the solver, the covariance and the
/// quality figures are made of. The storage is reused from point to point.
struct PointFactor {
  std::vector<WhitenedLook> looks;  ///< the first look_count are set; rows 2 k and 2 k + 1
  int look_count = 0;
  /// Second-derivative rows of the looks, where the weighting is curved; none where V is not
  /// positive definite with them.
  std::vector<CurvedRows> curved;
  int curved_count = 0;
  int looks_not_evaluated = 0;
  int looks_beyond_path = 0;  ///< that read a path continued beyond its ends
  double cost = 0.0;          ///< half the square sum, robust loss applied
  /// Largest WhitenedLook::weight_change of all evaluations since it was set to 0.
  double weight_change = 0.0;

  int row_count = 0;
  std::vector<double> q;  ///< row_count x 3, column by column
  std::vector<double> e;  ///< row_count
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< J_p' e, undamped
  Eigen::Vector3d square = Eigen::Vector3d::Zero();    ///< squared lengths of J_p's columns
  /// 1 / condition of J_p with its columns scaled to unit length (Frobenius norms, so 1/3 at most);
  /// 0 where a column vanishes or there are fewer than three rows; not computed when damped.
  double reciprocal_condition = 0.0;

  [[nodiscard]] Eigen::Vector3d RowOfQ(int row) const {
    const auto i = static_cast<std::size_t>(row), m = static_cast<std::size_t>(row_count);
    return {q[i], q[m + i], q[2 * m + i]};
  }
};

/// J_c of a point over the distinct parameter blocks its looks touch.
struct PointColumns {
  std::vector<int> blocks;  ///< ascending
  std::vector<int> begin;   ///< first column of each
  int width = 0;            ///< columns of J_c
  /// T = Q' J_c, 3 x width, row by row.
  std::vector<double> t;
  /// Row by row, row_count x (width + 1): the complement M = (I - Q Q') [J_c | e]; filled by
  /// Complement.
  std::vector<double> m;

  std::vector<int> column_of_block;  ///< by parameter block; valid for those in `blocks`
  std::vector<double> scratch;
};

/// False where the model has no value at this state.
[[nodiscard]] bool EvaluateWhitened(const AdjustmentProblem& problem,
                                    const BlockState& state,
                                    const Weighting& weighting,
                                    std::size_t point,
                                    std::size_t look,
                                    WhitenedLook* out,
                                    CurvedRows* curved = nullptr);

/// A column of J_p shorter than this part (squared) of the longest is damped as if it had that
/// length.
inline constexpr double kMinColumnPart = 1e-12;

/// Evaluates and factors the equations of a point that takes part. A look without a value at this
/// state is counted and left out.
void FactorPoint(const AdjustmentProblem& problem,
                 const BlockState& state,
                 const Weighting& weighting,
                 double damping,
                 std::size_t point,
                 PointFactor* out);

/// Own steps of points up to this length, in standard deviations, are left to the next step of all
/// unknowns.
inline constexpr double kMaxOwnStep = 0.1;

/// Moves a point by Gauss-Newton steps of its own, the corrections as they are in the state, until
/// the remaining step is at most `settle_below` standard deviations or no longer lowers the cost of
/// the point's equations. `out` holds its factor on entry, and on return that at its new place.
/// Returns whether it moved.
///
/// A step of the corrections moves the best place of a point along a curve, from which the point's
/// linear step deviates: with many points the cost of that would allow only short steps of the
/// corrections (variable projection, Golub and Pereyra 1973; embedded point iterations, Jeong et
/// al. 2012).
bool SettlePoint(const AdjustmentProblem& problem,
                 const Weighting& weighting,
                 double damping,
                 double settle_below,
                 std::size_t point,
                 BlockState* state,
                 PointFactor* out);

/// Q' of a vector of the point's rows.
[[nodiscard]] Eigen::Vector3d Project(const PointFactor& factor, const std::vector<double>& rows);

/// Finds the blocks and T.
void ProjectColumns(const AdjustmentProblem& problem,
                    const PointFactor& factor,
                    PointColumns* columns);

/// Forms M after ProjectColumns, projected twice: what elimination leaves of the equations has the
/// digits of J_c itself, however thin the intersection. The point adds M' M to S.
void Complement(const AdjustmentProblem& problem, const PointFactor& factor, PointColumns* columns);

/// Evaluates the looks of a point that take part into out->looks.
void EvaluateLooks(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Weighting& weighting,
                   std::size_t point,
                   PointFactor* out);

/// Second-order weighting of a look under a robust loss (after Triggs et al. 2000, with a floor):
/// rows keep their weight across the residual and get the loss's own curvature along it; the errors
/// are rescaled so that the gradient stays what it is.
void BendAlongResidual(WhitenedLook* look);

/// R of V = R' R by Cholesky and the inverses of its diagonal; V by its diagonal and the elements
/// (0, 1), (0, 2) and (1, 2) above it. False for an intersection so thin that V = J'J has lost
/// digits that J still has.
[[nodiscard]] bool FactorNormal(const Eigen::Vector3d& diagonal,
                                const Eigen::Vector3d& above,
                                bool damped,
                                Eigen::Matrix3d* r,
                                Eigen::Vector3d* inverse);

/// The same with the point's CurvedRows added to V. Where V is not positive definite with them,
/// they are left out and removed from `factor`.
[[nodiscard]] bool FactorSquare(const Eigen::Vector3d& diagonal,
                                const Eigen::Vector3d& above,
                                bool damped,
                                PointFactor* factor,
                                Eigen::Matrix3d* r,
                                Eigen::Vector3d* inverse);

/// What the kernels of kernels.h need of a point beside its PointColumns. The storage is reused
/// from point to point.
struct PointTerms {
  PointColumns columns;
  std::vector<int> size;           ///< columns of each block
  std::vector<std::size_t> value;  ///< PointBlocks::value in the matrix of FindBlocks
  /// N' J_c, row by row, and N' e; N completes Q to an orthonormal basis of the point's rows.
  std::vector<double> rest, rest_e;
  std::vector<double> basis;
};

/// The kernels of this machine.
[[nodiscard]] inline const ProductKernels& Kernels() {
  static const ProductKernels& kernels = KernelsOfThisMachine();
  return kernels;
}

/// Puts a block where it belongs in an ascending list of distinct ones.
inline void InsertBlock(int id, std::vector<int>* blocks) {
  std::size_t at = blocks->size();
  while (at > 0 && (*blocks)[at - 1] > id) --at;
  if (at > 0 && (*blocks)[at - 1] == id) return;
  if (at == blocks->size()) {  // looks mostly come in the order of their passes
    blocks->push_back(id);
  } else {
    blocks->insert(blocks->begin() + static_cast<std::ptrdiff_t>(at), id);
  }
}

/// The same for the blocks of a look.
inline void InsertBlocks(const LookColumns& look, std::vector<int>* blocks) {
  for (int b = 0; b < look.block_count; ++b) {
    InsertBlock(look.block[static_cast<std::size_t>(b)], blocks);
  }
}

/// Finds the blocks of J_c and their columns.
void FindColumns(const ParameterLayout& layout, const PointFactor& factor, PointColumns* columns);

/// The columns of the blocks given in columns->blocks.
void PlaceColumns(const ParameterLayout& layout, PointColumns* columns);

/// Finds the places of the blocks in a matrix of the block's pattern, after FindColumns.
[[nodiscard]] PointBlocks FindBlocks(const ParameterLayout& layout,
                                     const BlockPattern& pattern,
                                     PointTerms* terms);

/// The same with the slots of the pattern in place of first values.
[[nodiscard]] PointBlocks FindSlots(const ParameterLayout& layout,
                                    const BlockPattern& pattern,
                                    PointTerms* terms);

/// out (`terms` rows over the columns) += B' J_c, B `terms` columns of row_count rows.
void AddTurnedColumns(const ParameterLayout& layout,
                      const PointFactor& factor,
                      const PointColumns& columns,
                      const double* b,
                      int terms,
                      double* out);

/// What elimination leaves of the equations, after FindColumns: N' J_c and N' e, with the digits of
/// J_c itself, however thin the intersection. The point adds (N' J_c)' (N' J_c) to S. row_count
/// must be 3 at least.
void ProjectToLeftNullSpace(const ParameterLayout& layout,
                            const PointFactor& factor,
                            PointTerms* terms);

/// sum_i a_i b_i over m numbers, four sums side by side: a chain of additions as long as the rows
/// would wait on each of them.
[[nodiscard]] inline double Dot(std::size_t m, const double* a, const double* b) {
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
  std::size_t i = 0;
  for (; i + 4 <= m; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  for (; i < m; ++i) s0 += a[i] * b[i];
  return (s0 + s2) + (s1 + s3);
}

/// J'J and J'e of a point, the two rows of a look side by side.
class PointSums {
 public:
  PointSums() {
    for (Eigen::Array2d& sum : sums_) sum.setZero();
  }
  void Add(const Eigen::Matrix<double, 2, 3>& j, const Eigen::Vector2d& whitened_error) {
    const Eigen::Array2d j0 = j.col(0).array(), j1 = j.col(1).array(), j2 = j.col(2).array();
    const Eigen::Array2d e = whitened_error.array();
    sums_[0] += j0 * j0;
    sums_[1] += j1 * j1;
    sums_[2] += j2 * j2;
    sums_[3] += j0 * j1;
    sums_[4] += j0 * j2;
    sums_[5] += j1 * j2;
    sums_[6] += j0 * e;
    sums_[7] += j1 * e;
    sums_[8] += j2 * e;
  }
  void Add(const CurvedRows& rows) {
    const Eigen::Array2d sign = rows.sign.array();
    const Eigen::Array2d j0 = rows.d_point.col(0).array(), j1 = rows.d_point.col(1).array(),
                         j2 = rows.d_point.col(2).array();
    sums_[0] += sign * j0 * j0;
    sums_[1] += sign * j1 * j1;
    sums_[2] += sign * j2 * j2;
    sums_[3] += sign * j0 * j1;
    sums_[4] += sign * j0 * j2;
    sums_[5] += sign * j1 * j2;
  }
  void AddGradient(const Eigen::Matrix<double, 2, 3>& j, const Eigen::Vector2d& whitened_error) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      sums_[static_cast<std::size_t>(6 + c)] += j.col(c).array() * whitened_error.array();
    }
  }
  /// Rows beyond those of the control are zero.
  void Add(const ControlEvaluation& control) {
    Eigen::Matrix<double, 2, 3> last = Eigen::Matrix<double, 2, 3>::Zero();
    last.row(0) = control.d_point.row(2);
    Add(control.d_point.topRows<2>(), control.residual.head<2>());
    Add(last, {control.residual[2], 0.0});
  }
  [[nodiscard]] Eigen::Vector3d Diagonal() const { return Three(0); }
  /// (0, 1), (0, 2) and (1, 2) of J'J.
  [[nodiscard]] Eigen::Vector3d Above() const { return Three(3); }
  [[nodiscard]] Eigen::Vector3d Gradient() const { return Three(6); }

 private:
  [[nodiscard]] Eigen::Vector3d Three(std::size_t first) const {
    return {sums_[first].sum(), sums_[first + 1].sum(), sums_[first + 2].sum()};
  }
  std::array<Eigen::Array2d, 9> sums_;
};

/// R^-1 of an upper triangle.
[[nodiscard]] inline Eigen::Matrix3d InverseOfUpper(const Eigen::Matrix3d& r) {
  const double r00 = 1.0 / r(0, 0), r11 = 1.0 / r(1, 1), r22 = 1.0 / r(2, 2);
  const double r01 = -r00 * r(0, 1) * r11, r12 = -r11 * r(1, 2) * r22;
  const double r02 = -r00 * (r(0, 1) * r12 + r(0, 2) * r22);
  Eigen::Matrix3d inverse;
  inverse << r00, r01, r02, 0.0, r11, r12, 0.0, 0.0, r22;
  return inverse;
}

/// The parameter blocks of one point after the other, and how much their looks in use have
/// together.
class BlocksOfPoints {
 public:
  explicit BlocksOfPoints(const AdjustmentProblem& problem) : problem_(problem) {
    for (const PassCorrections& pass : problem.layout.passes) {
      const bool one = pass.blocks.size() == 1 && pass.splines.empty();
      only_block_.push_back(one ? pass.blocks[0] : -1);
    }
  }
  /// Ascending. Calls of_look(columns) for each look in use of a pass that has more than one block.
  template <typename OfLook>
  const std::vector<int>& At(std::size_t point, const OfLook& of_look) {
    const Looks& looks = problem_.block.looks;
    const ParameterLayout& layout = problem_.layout;
    blocks_.clear();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem_.look_used[i] == 0) continue;
      ++looks_;
      if (const int only = only_block_[looks.pass[i]]; only >= 0) {
        InsertBlock(only, &blocks_);
        counted_columns_ +=
            static_cast<std::size_t>(layout.blocks[static_cast<std::size_t>(only)].size);
        continue;
      }
      problem_.model.ColumnsOf(i, &columns_);
      InsertBlocks(columns_, &blocks_);
      of_look(columns_);
      counted_columns_ += static_cast<std::size_t>(columns_.column_count);
    }
    return blocks_;
  }
  const std::vector<int>& At(std::size_t point) {
    return At(point, [](const LookColumns&) {});
  }

  /// Looks and columns of all points asked for so far.
  [[nodiscard]] std::size_t looks() const { return looks_; }
  [[nodiscard]] std::size_t columns() const { return counted_columns_; }

 private:
  const AdjustmentProblem& problem_;
  std::vector<int> only_block_;  // of a pass whose looks all have the same one
  std::vector<int> blocks_;
  LookColumns columns_;
  std::size_t looks_ = 0, counted_columns_ = 0;
};

/// A point whose own equations leave a direction open.
struct WeakPoint {
  std::uint32_t point = 0;
  double reciprocal_condition = 0.0;
};

/// Smallest reciprocal condition of a point's scaled Jacobian that still counts as determined.
inline constexpr double kMinPointCondition = 1e-10;

}  // namespace sarblock
