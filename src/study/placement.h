// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "study/block_covariance.h"
#include <Eigen/Core>

namespace sarblock {

/// What a control point is added for.
enum class PlacementCriterion {
  kMeanVariance,     ///< mean of tr(cov) over the points
  kWorstPoint,       ///< largest tr(cov) of a point
  kMeanDifferences,  ///< mean of tr(cov) over the differences of neighbours
};
[[nodiscard]] const char* NameOf(PlacementCriterion criterion);  ///< "mean-variance", ...

/// A criterion and what it looks at, in the indices of a BlockCovariance.
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
/// there is no candidate left); each becomes control in `covariance`, of the covariance that stands
/// beside it in `sigma_m2` (frame axes). `after` is called once a point is in.
///
/// A greedy choice is best at each step, not for the number reached. A step costs O(n^3 + (m + k)
/// n^2) for n corrections, m points, k candidates; kWorstPoint O(k m n).
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
/// single exchange improves what is left, and it is never worse than what was given. That is not
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
