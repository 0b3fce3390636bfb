// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/adjust.h"
#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// The whole covariance of a block, between any two points, and how it changes as points become
/// control: no new adjustment, a rank-3 update each (docs/theory/placement.md).
///
/// With B_j = R_j^-1 R_j^-T (point j for known corrections), Y_j the n x 3 matrix (R_j^-1 T_j)'
/// spread over all n corrections, C their covariance (docs/theory/covariance.md):
///
///     cov(p_j) = B_j + Y_j' C Y_j,    cov(p_j, p_k) = Y_j' C Y_k
///
/// Control of covariance Sigma at point k, G = cov(p_k) + Sigma (Sherman-Morrison-Woodbury):
///
///     C   <- C - C Y_k G^-1 Y_k' C
///     B_k <- B_k - B_k (B_k + Sigma)^-1 B_k,    Y_k <- Y_k (B_k + Sigma)^-1 Sigma
///
/// Taken back, with B_k, Y_k and C as that left them:
///
///     N = Sigma (Sigma - B_k)^-1 Sigma  (B_k + Sigma of before),   Y_k <- Y_k Sigma^-1 N
///     B_k <- N - Sigma,    C <- C + C Y_k (N - Y_k' C Y_k)^-1 Y_k' C
///
/// Memory 8 (n^2 + 3 n m) bytes for m points. Frame axes throughout.
class BlockCovariance {
 public:
  /// Most numbers that C and all Y together may have: 1.6 GB.
  static constexpr std::size_t kMostNumbers = 200'000'000;

  /// Of the block as Predict() takes it: geometry and weights alone, flight paths nominal. `status`
  /// says which points take part, as Predict() answers it. Throws UndeterminedError where the
  /// corrections are not determined, InputError where the matrices would be larger than
  /// kMostNumbers.
  BlockCovariance(const Block& block,
                  const AdjustOptions& options,
                  const std::vector<Eigen::Vector3d>& positions_m,
                  const std::vector<PointStatus>& status);

  /// Points that take part, as indices of the block, ascending. All functions below count in these.
  [[nodiscard]] const std::vector<std::uint32_t>& points() const { return points_; }
  [[nodiscard]] Eigen::Index corrections() const { return c_.rows(); }

  [[nodiscard]] Eigen::Matrix3d Of(std::size_t i) const;                      ///< cov(p_i) [m2]
  [[nodiscard]] Eigen::Matrix3d Between(std::size_t i, std::size_t j) const;  ///< i != j [m2]
  [[nodiscard]] Eigen::Matrix3d OfDifference(std::size_t i, std::size_t j) const;

  /// Makes point i control with this covariance (positive definite) [m2].
  void AddControl(std::size_t i, const Eigen::Matrix3d& sigma_m2);
  /// Takes control that AddControl() made of point i back. Loses about the digits by which the
  /// variances had fallen. Throws InputError where the point had no such control.
  void RemoveControl(std::size_t i, const Eigen::Matrix3d& sigma_m2);

  /// Independent squares that sum e_i' Q_i^-1 e_i over `chosen` points is worth, errors normal with
  /// this covariance: its mean is 3 m, its variance 2 sum_ij tr(Q_i^-1 Q_ij Q_j^-1 Q_ji); the
  /// chi-square of the same mean and variance, scaled, has this many degrees (Satterthwaite 1946).
  [[nodiscard]] double SquareFreedom(const std::vector<std::size_t>& chosen) const;

  /// tr(cov) summed over what a criterion looks at, and what a control point would take off it.
  /// `pairs`: differences p_b - p_a; `points`: positions.
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  [[nodiscard]] double SumOfVariances(const std::vector<std::size_t>& chosen) const;
  [[nodiscard]] double SumOfVariances(const Pairs& pairs) const;

  /// By candidate: how much SumOfVariances falls if it became control of covariance sigma_m2 [m2].
  /// O(n^3 + (m + candidates) n^2).
  [[nodiscard]] std::vector<double> Gains(const std::vector<std::size_t>& candidates,
                                          const std::vector<Eigen::Matrix3d>& sigma_m2,
                                          const std::vector<std::size_t>& chosen) const;
  [[nodiscard]] std::vector<double> Gains(const std::vector<std::size_t>& candidates,
                                          const std::vector<Eigen::Matrix3d>& sigma_m2,
                                          const Pairs& pairs) const;
  /// By candidate: the largest tr(cov) among `chosen` that would be left [m2]. O(candidates m n).
  [[nodiscard]] std::vector<double> WorstAfter(const std::vector<std::size_t>& candidates,
                                               const std::vector<Eigen::Matrix3d>& sigma_m2,
                                               const std::vector<std::size_t>& chosen) const;

 private:
  [[nodiscard]] auto Y(std::size_t i) const {
    return y_.middleCols(3 * static_cast<Eigen::Index>(i), 3);
  }
  std::vector<std::uint32_t> points_;
  std::vector<Eigen::Matrix3d> b_;
  Eigen::MatrixXd y_;  // n x 3 m
  Eigen::MatrixXd c_;  // n x n
};

}  // namespace sarblock
