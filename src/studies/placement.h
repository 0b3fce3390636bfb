// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/adjust.h"
#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
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
  static constexpr std::size_t kMaxNumbers = 200'000'000;

  /// Covariance of the block as Predict() takes it: geometry and weights alone, flight paths
  /// nominal. `status` says which points take part, as Predict() answers it. Throws
  /// UndeterminedError where the corrections are not determined, InputError where the matrices
  /// would be larger than kMaxNumbers.
  BlockCovariance(const Block& block,
                  const AdjustOptions& options,
                  const std::vector<Eigen::Vector3d>& positions_m,
                  const std::vector<PointStatus>& status);

  /// Points that take part, as indices of the block, ascending. All functions below count in these.
  [[nodiscard]] const std::vector<std::uint32_t>& points() const { return points_; }
  [[nodiscard]] Eigen::Index corrections() const { return c_.rows(); }

  [[nodiscard]] Eigen::Matrix3d Point(std::size_t i) const;                   ///< cov(p_i) [m2]
  [[nodiscard]] Eigen::Matrix3d Between(std::size_t i, std::size_t j) const;  ///< i != j [m2]
  [[nodiscard]] Eigen::Matrix3d Difference(std::size_t i, std::size_t j) const;

  /// Makes point i control with this covariance (positive definite) [m2].
  void AddControl(std::size_t i, const Eigen::Matrix3d& sigma_m2);
  /// Takes control that AddControl() made of point i back. Loses about the digits by which the
  /// variances had fallen. Throws InputError where the point had no such control.
  void RemoveControl(std::size_t i, const Eigen::Matrix3d& sigma_m2);

  /// Independent squares that sum e_i' Q_i^-1 e_i over `chosen` points is worth, errors normal with
  /// this covariance: its mean is 3 m, its variance 2 sum_ij tr(Q_i^-1 Q_ij Q_j^-1 Q_ji); the
  /// chi-square of the same mean and variance, scaled, has this many degrees (Satterthwaite 1946).
  [[nodiscard]] double SquareFreedom(const std::vector<std::size_t>& chosen) const;

  /// Sum of tr(cov) over the points or differences of a criterion, and its decrease by a control
  /// point. `pairs`: differences p_b - p_a; `points`: positions.
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
  /// By candidate: the largest remaining tr(cov) among `chosen` if it became control [m2].
  /// O(candidates m n).
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

/// Criterion by which control points are added.
enum class PlacementCriterion {
  kMeanVariance,     ///< mean of tr(cov) over the points
  kWorstPoint,       ///< largest tr(cov) of a point
  kMeanDifferences,  ///< mean of tr(cov) over the differences of neighbours
};
[[nodiscard]] const char* NameOf(PlacementCriterion criterion);  ///< "mean-variance", ...

/// A criterion and the points or pairs that it counts, as indices of a BlockCovariance.
struct PlacementObjective {
  PlacementCriterion criterion = PlacementCriterion::kMeanVariance;
  std::vector<std::size_t> points;  ///< not empty, unless kMeanDifferences
  BlockCovariance::Pairs pairs;     ///< of kMeanDifferences, not empty
};

/// The criterion's value [m2].
[[nodiscard]] double ValueOf(const PlacementObjective& objective,
                             const BlockCovariance& covariance);

/// The value by candidate if that one became control, by formulas, not by adjustments [m2].
[[nodiscard]] std::vector<double> ValuesAfter(const PlacementObjective& objective,
                                              const BlockCovariance& covariance,
                                              const std::vector<std::size_t>& candidates,
                                              const std::vector<Eigen::Matrix3d>& sigma_m2);

struct PlacementStep {
  std::size_t point = 0;  ///< of the covariance
  double value_m2 = 0.0;  ///< of the criterion with it
};

/// Adds the candidate with the smallest value, the first of equal ones, `count` times (or until
/// there is no candidate left); each becomes control in `covariance`, with its covariance from
/// `sigma_m2` (frame axes). `after` is called after each point.
///
/// A greedy choice is the best one at each step, but not always the best set of that size. A step
/// costs O(n^3 + (m + k) n^2) for n corrections, m points, k candidates; kWorstPoint O(k m n).
[[nodiscard]] std::vector<PlacementStep> PlaceGreedily(
    const PlacementObjective& objective,
    std::vector<std::size_t> candidates,
    std::vector<Eigen::Matrix3d> sigma_m2,
    std::size_t count,
    BlockCovariance* covariance,
    const std::function<void(const PlacementStep&)>& after = {});

/// One point of a placement given up for another.
struct PlacementExchange {
  std::size_t removed = 0, added = 0;  ///< of the covariance
  double value_m2 = 0.0;               ///< of the criterion after it
};

/// Exchanges one of the `chosen` points for the candidate with the smallest value, one chosen point
/// after the other, as long as some exchange lowers the criterion (docs/theory/placement.md): no
/// single exchange improves the final set, and it is never worse than the given one. It is not
/// always the best of all sets of this size. `candidates` holds the chosen points too, each with
/// the covariance beside it in `sigma_m2`, and all `chosen` are control in `covariance` by those.
/// `before` is called before each point is tried, at the cost of a step of PlaceGreedily() each.
[[nodiscard]] std::vector<PlacementExchange> ExchangePlacement(
    const PlacementObjective& objective,
    const std::vector<std::size_t>& candidates,
    const std::vector<Eigen::Matrix3d>& sigma_m2,
    std::vector<std::size_t>* chosen,
    BlockCovariance* covariance,
    const std::function<void()>& before = {});

}  // namespace sarblock
