// SPDX-License-Identifier: Apache-2.0
#include "study/placement.h"

#include <algorithm>

namespace sarblock {

const char* NameOf(PlacementCriterion criterion) {
  switch (criterion) {
    case PlacementCriterion::kWorstPoint:
      return "worst-point";
    case PlacementCriterion::kMeanDifferences:
      return "mean-differences";
    case PlacementCriterion::kMeanVariance:
      break;
  }
  return "mean-variance";
}

double ValueOf(const PlacementObjective& objective, const BlockCovariance& covariance) {
  switch (objective.criterion) {
    case PlacementCriterion::kWorstPoint: {
      double worst_m2 = 0.0;
      for (const std::size_t i : objective.points) {
        worst_m2 = std::max(worst_m2, covariance.Of(i).trace());
      }
      return worst_m2;
    }
    case PlacementCriterion::kMeanDifferences:
      return covariance.SumOfVariances(objective.pairs) /
             static_cast<double>(objective.pairs.size());
    case PlacementCriterion::kMeanVariance:
      break;
  }
  return covariance.SumOfVariances(objective.points) / static_cast<double>(objective.points.size());
}

std::vector<double> ValuesAfter(const PlacementObjective& objective,
                                const BlockCovariance& covariance,
                                const std::vector<std::size_t>& candidates,
                                const std::vector<Eigen::Matrix3d>& sigma_m2) {
  if (objective.criterion == PlacementCriterion::kWorstPoint) {
    return covariance.WorstAfter(candidates, sigma_m2, objective.points);
  }
  const bool differences = objective.criterion == PlacementCriterion::kMeanDifferences;
  const double now_m2 = ValueOf(objective, covariance);
  const auto count =
      static_cast<double>(differences ? objective.pairs.size() : objective.points.size());
  std::vector<double> values = differences
                                   ? covariance.Gains(candidates, sigma_m2, objective.pairs)
                                   : covariance.Gains(candidates, sigma_m2, objective.points);
  for (double& value : values) value = now_m2 - value / count;
  return values;
}

std::vector<PlacementStep> PlaceGreedily(const PlacementObjective& objective,
                                         std::vector<std::size_t> candidates,
                                         std::vector<Eigen::Matrix3d> sigma_m2,
                                         std::size_t count,
                                         BlockCovariance* covariance,
                                         const std::function<void(const PlacementStep&)>& after) {
  std::vector<PlacementStep> steps;
  while (steps.size() < count && !candidates.empty()) {
    const std::vector<double> values_m2 = ValuesAfter(objective, *covariance, candidates, sigma_m2);
    const auto best = std::min_element(values_m2.begin(), values_m2.end()) - values_m2.begin();
    steps.push_back({candidates[static_cast<std::size_t>(best)], *(values_m2.begin() + best)});
    covariance->AddControl(steps.back().point, *(sigma_m2.begin() + best));
    candidates.erase(candidates.begin() + best);
    sigma_m2.erase(sigma_m2.begin() + best);
    if (after) after(steps.back());
  }
  return steps;
}

std::vector<PlacementExchange> ExchangePlacement(const PlacementObjective& objective,
                                                 const std::vector<std::size_t>& candidates,
                                                 const std::vector<Eigen::Matrix3d>& sigma_m2,
                                                 std::vector<std::size_t>* chosen,
                                                 BlockCovariance* covariance,
                                                 const std::function<void()>& before) {
  // A smaller part than this is rounding, and could go back and forth for ever.
  constexpr double kLeastDrop_1 = 1e-9;
  std::vector<PlacementExchange> exchanges;
  const auto sigma_of = [&](std::size_t point) -> const Eigen::Matrix3d& {
    const auto at = std::find(candidates.begin(), candidates.end(), point);
    return sigma_m2[static_cast<std::size_t>(at - candidates.begin())];
  };
  std::size_t kept = 0;  // points in a row that nothing is better than
  for (std::size_t k = 0; kept < chosen->size(); k = (k + 1) % chosen->size()) {
    if (before) before();
    const std::size_t old = (*chosen)[k];
    covariance->RemoveControl(old, sigma_of(old));
    std::vector<std::size_t> open = {old};
    std::vector<Eigen::Matrix3d> open_m2 = {sigma_of(old)};
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (std::find(chosen->begin(), chosen->end(), candidates[i]) != chosen->end()) continue;
      open.push_back(candidates[i]);
      open_m2.push_back(sigma_m2[i]);
    }
    const std::vector<double> values_m2 = ValuesAfter(objective, *covariance, open, open_m2);
    auto best = std::min_element(values_m2.begin(), values_m2.end());
    if (!(*best < values_m2.front() * (1.0 - kLeastDrop_1))) best = values_m2.begin();
    const auto at = static_cast<std::size_t>(best - values_m2.begin());
    covariance->AddControl(open[at], open_m2[at]);
    (*chosen)[k] = open[at];
    if (at == 0) {
      ++kept;
    } else {
      exchanges.push_back({old, open[at], *best});
      kept = 1;
    }
  }
  return exchanges;
}

}  // namespace sarblock
