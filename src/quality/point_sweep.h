// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/problem.h"
#include "normals/back.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// R^-1 of a point, and Y = (R^-1 T)' spread over all n corrections (n x 3), unless `full` has no
/// column: with C the covariance of the corrections, cov(p_a, p_b) = Y_a' C Y_b for a != b and
/// cov(p_a) = R^-1 R^-T + Y_a' C Y_a (docs/theory/covariance.md). `factor` and `columns` are
/// storage, reused from point to point.
[[nodiscard]] Eigen::Matrix3d PointSensitivity(const AdjustmentProblem& problem,
                                               const BlockState& state,
                                               std::size_t point,
                                               PointFactor* factor,
                                               PointColumns* columns,
                                               Eigen::Ref<Eigen::MatrixXd> full);

/// A covariance in frame axes [m2] as east, north, up at p.
[[nodiscard]] SymmetricEnu ToEnu(const Frame& frame,
                                 const Eigen::Vector3d& p_m,
                                 const Eigen::Matrix3d& covariance_m2);

/// One look at the solution, its two components in units of their standard deviations.
struct LookCovariance {
  std::size_t look = 0;
  Eigen::Vector2d whitened_error = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> information;  ///< its rows of Q
  Eigen::Matrix2d adjusted_covariance;      ///< covariance of the adjusted look
  Eigen::Matrix<double, 3, 2> shift_m;      ///< of the point by one sigma in each
};

/// Residuals of one point in the measured components, each in units of its standard deviation, and
/// their exact covariance in the whole adjustment: range and azimuth of every look, in the order of
/// the block, then the rows of its known position (whitened by its covariance).
///
/// With J_p = Q1 R, B = Q2' J_c and C the covariance of the corrections,
///     Q_vv = Q2 (I - B C B') Q2'        (docs/theory/quality.md, eq. (4))
struct PointResiduals {
  std::vector<std::uint64_t> looks;
  std::size_t looks_of_point = 0;  ///< that take part
  Eigen::VectorXd v;
  Eigen::MatrixXd q_vv;
  /// The part of the residuals that the corrections, and so other points, absorb: Q2 B C B' Q2'.
  Eigen::MatrixXd corrections_share;
  /// Q1: what each observation adds to the information on the point, corrections fixed; the rows'
  /// squares add to I.
  Eigen::MatrixX3d information;
  /// Shift of the point by one sigma in each observation, 3 rows, frame axes [m].
  Eigen::Matrix3Xd shift_m;

  [[nodiscard]] Eigen::Index size() const { return v.size(); }
  /// v / sqrt(r); NaN where there is no redundancy.
  [[nodiscard]] double w(Eigen::Index i) const;
  /// Correlation of w(i) and w(k).
  [[nodiscard]] double Correlation(Eigen::Index i, Eigen::Index k) const;
};

/// One point at the solution, its equations evaluated and factored once (normals/point.h) for all
/// figures computed from them. Storage is reused from point to point.
class PointLinearization {
 public:
  using Complements =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>,
                 Eigen::Unaligned,
                 Eigen::OuterStride<>>;

  /// `inverse`: C of the system at this state; null without corrections or for fixed flight paths.
  /// Without `quality` only covariances and Information() are asked for. `kept`: factors of the
  /// same state and weights, which give the same results to the bit.
  PointLinearization(const AdjustmentProblem& problem,
                     const BlockState& state,
                     const CorrectionCovariance* inverse,
                     bool quality = true,
                     const KeptFactors* kept = nullptr);

  /// Goes to a point that takes part.
  PointLinearization& At(std::size_t point);

  /// With the factorisation of the point and T = Q' J_c, frame axes [m2]:
  ///
  ///     cov(p) = R^-1 (I + T C T') R^-T
  ///
  /// docs/theory/covariance.md, eqs. (22) to (24).
  [[nodiscard]] Eigen::Matrix3d Covariance() const {
    return r_inverse_ * core_ * r_inverse_.transpose();
  }
  /// R^-1 R^-T: covariance by the noise of its own looks and its control, if the corrections were
  /// known.
  [[nodiscard]] Eigen::Matrix3d FixedPathCovariance() const {
    return r_inverse_ * r_inverse_.transpose();
  }
  /// The k-th of its looks.
  [[nodiscard]] LookCovariance Look(int k);
  /// Not allowed for a point of the border, which has too many rows for a covariance of all pairs
  /// (use ResidualsOf).
  [[nodiscard]] PointResiduals Residuals();
  /// The residuals of one of its looks alone.
  [[nodiscard]] PointResiduals ResidualsOf(std::uint64_t look);
  /// Looks, residuals and information, the rest empty: forms nothing of the size of its rows
  /// squared.
  [[nodiscard]] PointResiduals Information() const;

  [[nodiscard]] const PointFactor& factor() const { return factor_; }
  [[nodiscard]] const PointColumns& columns() const { return terms_.columns; }
  /// (I - Q Q') J_c over these columns, row by row; with corrections.
  [[nodiscard]] Complements Complement();

 private:
  /// A Y' and A C A' of rows A over the corrections.
  template <int Rows>
  struct Products {
    Eigen::Matrix<double, Rows, 3> with_point;
    Eigen::Matrix<double, Rows, Rows> own;
  };

  void GatherBorder();
  void MultiplyByInverse();
  [[nodiscard]] Products<2> ProductsOf(const WhitenedLook& look) const;
  template <int Rows>
  [[nodiscard]] Products<Rows> ComplementProducts(int first, int rows);

  const AdjustmentProblem& problem_;
  const BlockState& state_;
  const CorrectionCovariance* inverse_;
  bool quality_;
  const KeptFactors* kept_;
  PointFactor factor_;
  PointTerms terms_;
  const double* t_ = nullptr;  // T, 3 x width, row by row
  std::vector<double> y_;      // Y = T C, 3 x width, row by row
  int border_row_ = -1;        // CorrectionCovariance::t_c
  Eigen::Matrix3d r_inverse_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d core_ = Eigen::Matrix3d::Identity();  // I + T C T'
  bool complement_formed_ = false;
};

/// Results of a sweep over the points at the solution, all from one evaluation of every look.
struct PointSweep {
  std::vector<SymmetricEnu> covariance_m2;  ///< by point; NaN where not solved
  LookQuality quality;                      ///< empty unless asked for
  /// By point, were the corrections known exactly; like quality.
  std::vector<SymmetricEnu> fixed_path_covariance_m2;
  std::vector<double> redundancy;  ///< by point, the sum over its looks; like quality
};

/// Covariance of every solved point in east-north-up at the point, exact marginals of the whole
/// adjustment. C = S^-1 on the pattern of S (`inverse`) has every block a point needs. Without
/// corrections (`inverse` null) or for fixed flight paths: R^-1 R^-T.
///
/// With `quality` the reliability of every look as well (docs/theory/quality.md), from the same
/// products: the covariance of the adjusted look i is
///
///     a_i C a_i' = q_i (I + T C T') q_i' - 2 (j_i C T') q_i' + j_i C j_i'
///
/// in a form that keeps its digits where flight paths are weakly determined. Parallel over points.
/// `kept`: as of PointLinearization.
[[nodiscard]] PointSweep SweepPoints(const AdjustmentProblem& problem,
                                     const BlockState& state,
                                     const CorrectionCovariance* inverse,
                                     bool quality,
                                     ProgressSink* progress,
                                     const KeptFactors* kept = nullptr);

/// Reliability of the fixed components of control points, from their covariances.
[[nodiscard]] std::vector<ControlQuality> ControlQualities(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<SymmetricEnu>& covariance_m2);

/// Warns of looks whose standard deviations are finer than the rounding of coordinates in double
/// precision: compared are one rounding of the largest coordinate in an equation (point, antenna,
/// range; with a time bias the way flown in one rounding of the time) and its standard deviation. A
/// ratio above a ten-thousandth may move the point by a thousandth of its sigma. Control may be as
/// tight as wanted: it fixes its point to the given coordinates themselves.
void WarnOfRounding(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result);

}  // namespace sarblock
