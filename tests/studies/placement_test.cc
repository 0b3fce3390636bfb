// SPDX-License-Identifier: Apache-2.0
#include "studies/placement.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/threads.h"
#include "quality/point_sweep.h"
#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

/// A shipped scene as planned, with its options and their prediction.
struct Planned {
  SimulatedBlock simulated;
  AdjustOptions options;
  AdjustResult predicted;

  Planned(const std::string& name, const std::vector<std::string>& overrides)
      : Planned(name, SceneOf(name, overrides)) {}
  Planned(const std::string& name, const Scene& scene) : simulated(Simulate(scene)) {
    std::vector<std::string> passes;
    for (const Pass& pass : simulated.block.passes) passes.push_back(pass.id);
    options = files::ReadAdjustTable(scene.adjust_toml, name, passes);
    options.threads = AvailableCores();
    options.pairs = PairChoice::kNeighbours;
    Predict();
  }
  static Scene SceneOf(const std::string& name, const std::vector<std::string>& overrides) {
    return files::ReadScene(std::string(SARBLOCK_DATASETS) + "/scenes/" + name + ".toml",
                            overrides);
  }
  void Predict() {
    predicted = sarblock::Predict(simulated.block, options, simulated.truth.points_m);
  }
  [[nodiscard]] BlockCovariance Covariance() const {
    return {simulated.block, options, simulated.truth.points_m, predicted.points.status};
  }
  /// The covariance of control with these standard deviations at a point, frame axes.
  [[nodiscard]] Eigen::Matrix3d Sigma(std::uint32_t point, double sigma_m) const {
    const Eigen::Matrix3d enu = simulated.block.frame.EnuFromFrame(simulated.truth.points_m[point]);
    const Eigen::Vector3d square_m2(sigma_m * sigma_m, sigma_m * sigma_m, 4.0 * sigma_m * sigma_m);
    return enu.transpose() * square_m2.asDiagonal() * enu;
  }
  /// Makes a tie point control, in the block itself.
  void MakeControl(std::uint32_t point, double sigma_m) {
    Points& points = simulated.block.points;
    points.role[point] = PointRole::kControl;
    points.given_m[point] = simulated.truth.points_m[point];
    KnownPosition known;
    known.point = point;
    known.fixed = {true, true, true};
    known.covariance_enu_m2.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m,
        4.0 * sigma_m * sigma_m;
    const auto at = std::find_if(points.known.begin(), points.known.end(), [&](const auto& other) {
      return other.point > point;
    });
    points.known.insert(at, known);
  }
};

const std::vector<std::string> kSmall = {"points.count=14", "check.count=0", "control.count=1"};

void ExpectSame(const SymmetricEnu& a, const SymmetricEnu& b) {
  const double size = a[0] + a[1] + a[2];
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(a[i], b[i], 1e-8 * size);
}

SymmetricEnu EnuOf(const Planned& planned, std::uint32_t at, const Eigen::Matrix3d& covariance) {
  return ToEnu(planned.simulated.block.frame, planned.simulated.truth.points_m[at], covariance);
}

// Two routes inside: dense products here, selected inverse there.
TEST(PlacementTest, TheWholeCovarianceHasThePredictedBlocks) {
  for (const char* scene : {"earth-asc-desc", "cross-wise"}) {
    const Planned planned(scene, kSmall);
    const BlockCovariance covariance = planned.Covariance();
    ASSERT_GE(covariance.points().size(), 10u);
    std::vector<std::size_t> index(planned.simulated.block.points.size());
    for (std::size_t i = 0; i < covariance.points().size(); ++i) {
      const std::uint32_t point = covariance.points()[i];
      index[point] = i;
      ExpectSame(EnuOf(planned, point, covariance.Point(i)),
                 planned.predicted.points.covariance_m2[point]);
    }
    for (const PairResult& pair : planned.predicted.pairs) {
      const std::size_t a = index[pair.a], b = index[pair.b];
      ExpectSame(EnuOf(planned, pair.a, covariance.Difference(a, b)), pair.covariance_m2);
      const Eigen::Matrix3d sum = covariance.Point(a) + covariance.Point(b) -
                                  covariance.Between(a, b) - covariance.Between(b, a);
      ExpectSame(EnuOf(planned, pair.a, sum), pair.covariance_m2);
    }
  }
}

// Two routes inside: updates of rank 3 against the prediction of a block that has the control.
TEST(PlacementTest, AddedControlIsWhatItsOwnPredictionSays) {
  Planned planned("earth-asc-desc", kSmall);
  BlockCovariance covariance = planned.Covariance();
  for (const std::size_t i : {std::size_t{3}, std::size_t{9}, std::size_t{4}}) {
    const std::uint32_t point = covariance.points()[i];
    covariance.AddControl(i, planned.Sigma(point, 0.37));
    planned.MakeControl(point, 0.37);
  }
  planned.Predict();
  for (std::size_t i = 0; i < covariance.points().size(); ++i) {
    const std::uint32_t point = covariance.points()[i];
    ExpectSame(EnuOf(planned, point, covariance.Point(i)),
               planned.predicted.points.covariance_m2[point]);
  }
}

/// The criterion from a prediction alone.
double Criterion(PlacementCriterion criterion,
                 const Planned& planned,
                 const std::vector<std::uint32_t>& points,
                 const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  const auto trace = [](const SymmetricEnu& q) { return q[0] + q[1] + q[2]; };
  double sum = 0.0, worst = 0.0;
  if (criterion == PlacementCriterion::kMeanDifferences) {
    AdjustOptions options = planned.options;
    options.pairs = PairChoice::kList;
    const AdjustResult listed =
        Predict(planned.simulated.block, options, planned.simulated.truth.points_m, pairs);
    for (const PairResult& pair : listed.pairs) sum += trace(pair.covariance_m2);
    return sum / static_cast<double>(pairs.size());
  }
  for (const std::uint32_t point : points) {
    const double of = trace(planned.predicted.points.covariance_m2[point]);
    sum += of;
    worst = std::max(worst, of);
  }
  return criterion == PlacementCriterion::kWorstPoint ? worst
                                                      : sum / static_cast<double>(points.size());
}

// Two routes inside: every candidate made control and predicted anew, at each of three steps.
TEST(PlacementTest, GreedyPlacementIsWhatBruteForceFinds) {
  for (const PlacementCriterion criterion : {PlacementCriterion::kMeanVariance,
                                             PlacementCriterion::kWorstPoint,
                                             PlacementCriterion::kMeanDifferences}) {
    Planned planned("earth-asc-desc", kSmall);
    BlockCovariance covariance = planned.Covariance();
    PlacementObjective objective;
    objective.criterion = criterion;
    std::vector<std::uint32_t> points;
    std::vector<std::size_t> index(planned.simulated.block.points.size());
    std::vector<Eigen::Matrix3d> sigma_m2;
    for (std::size_t i = 0; i < covariance.points().size(); ++i) {
      const std::uint32_t point = covariance.points()[i];
      index[point] = i;
      if (planned.simulated.block.points.role[point] == PointRole::kControl) continue;
      points.push_back(point);
      objective.points.push_back(i);
      sigma_m2.push_back(planned.Sigma(point, 0.37));
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const PairResult& pair : planned.predicted.pairs) {
      pairs.emplace_back(pair.a, pair.b);
      objective.pairs.emplace_back(index[pair.a], index[pair.b]);
    }
    EXPECT_NEAR(ValueOf(objective, covariance),
                Criterion(criterion, planned, points, pairs),
                1e-8 * ValueOf(objective, covariance));
    const std::vector<PlacementStep> steps =
        PlaceGreedily(objective, objective.points, sigma_m2, 3, &covariance);
    ASSERT_EQ(steps.size(), 3u);
    std::vector<std::uint32_t> candidates = points;
    for (const PlacementStep& step : steps) {
      double best = std::numeric_limits<double>::infinity();
      std::uint32_t chosen = 0;
      for (const std::uint32_t candidate : candidates) {
        Planned trial = planned;
        trial.MakeControl(candidate, 0.37);
        trial.Predict();
        const double value = Criterion(criterion, trial, points, pairs);
        if (value >= best) continue;
        best = value;
        chosen = candidate;
      }
      EXPECT_EQ(covariance.points()[step.point], chosen) << NameOf(criterion);
      EXPECT_NEAR(step.value_m2, best, 1e-7 * best) << NameOf(criterion);
      planned.MakeControl(chosen, 0.37);
      planned.Predict();
      candidates.erase(std::find(candidates.begin(), candidates.end(), chosen));
    }
  }
}

// Round trip: control added and taken back, in another order.
TEST(PlacementTest, ControlThatIsTakenBackLeavesTheBlockAsItWas) {
  const Planned planned("earth-asc-desc", kSmall);
  const BlockCovariance before = planned.Covariance();
  BlockCovariance covariance = before;
  for (const std::size_t i : {std::size_t{3}, std::size_t{9}, std::size_t{4}}) {
    covariance.AddControl(i, planned.Sigma(covariance.points()[i], 0.37));
  }
  BlockCovariance one = before;
  one.AddControl(9, planned.Sigma(covariance.points()[9], 0.37));
  const auto expect_same = [&](const BlockCovariance& a, const BlockCovariance& b) {
    for (std::size_t i = 0; i < a.points().size(); ++i) {
      const std::size_t j = (i + 1) % a.points().size();
      EXPECT_LT((a.Point(i) - b.Point(i)).norm(), 1e-9 * b.Point(i).norm());
      EXPECT_LT((a.Between(i, j) - b.Between(i, j)).norm(), 1e-9 * b.Point(i).norm());
    }
  };
  for (const std::size_t i : {std::size_t{3}, std::size_t{4}}) {
    covariance.RemoveControl(i, planned.Sigma(covariance.points()[i], 0.37));
  }
  expect_same(covariance, one);
  covariance.RemoveControl(9, planned.Sigma(covariance.points()[9], 0.37));
  expect_same(covariance, before);
  EXPECT_THROW(covariance.RemoveControl(9, planned.Sigma(covariance.points()[9], 1e-6)),
               InputError);
}

/// The criterion with these points as control, from the start again.
double ValueWith(const PlacementObjective& objective,
                 BlockCovariance covariance,
                 const std::vector<std::size_t>& points,
                 const std::vector<Eigen::Matrix3d>& sigma_by_point_m2) {
  for (const std::size_t i : points) covariance.AddControl(i, sigma_by_point_m2[i]);
  return ValueOf(objective, covariance);
}

// Brute force over all sets of three and of two: never worse than greedy, no exchange left, and
// near the best set of all.
TEST(PlacementTest, ExchangesEndWhereNoneHelpsNearTheBestSetOfASmallBlock) {
  int improved = 0;
  for (const char* scene : {"earth-asc-desc", "cross-wise"}) {
    const Planned planned(scene, kSmall);
    const BlockCovariance start = planned.Covariance();
    PlacementObjective objective;
    std::vector<Eigen::Matrix3d> sigma_m2, of_candidates_m2;
    for (std::size_t i = 0; i < start.points().size(); ++i) {
      sigma_m2.push_back(planned.Sigma(start.points()[i], 0.37));
      if (planned.simulated.block.points.role[start.points()[i]] == PointRole::kControl) continue;
      objective.points.push_back(i);
      of_candidates_m2.push_back(sigma_m2.back());
      if (objective.points.size() > 1)
        objective.pairs.emplace_back(objective.points.rbegin()[1], i);
    }
    for (const PlacementCriterion criterion : {PlacementCriterion::kMeanVariance,
                                               PlacementCriterion::kWorstPoint,
                                               PlacementCriterion::kMeanDifferences}) {
      SCOPED_TRACE(std::string(scene) + " " + NameOf(criterion));
      objective.criterion = criterion;
      for (const std::size_t count : {std::size_t{2}, std::size_t{3}}) {
        BlockCovariance covariance = start;
        std::vector<std::size_t> chosen;
        double greedy_m2 = 0.0;
        for (const PlacementStep& step :
             PlaceGreedily(objective, objective.points, of_candidates_m2, count, &covariance)) {
          chosen.push_back(step.point);
          greedy_m2 = step.value_m2;
        }
        const auto exchanges =
            ExchangePlacement(objective, objective.points, of_candidates_m2, &chosen, &covariance);
        const double value_m2 = ValueWith(objective, start, chosen, sigma_m2);
        EXPECT_NEAR(ValueOf(objective, covariance), value_m2, 1e-7 * value_m2);
        EXPECT_LE(value_m2, greedy_m2 * (1.0 + 1e-9));
        if (!exchanges.empty()) {
          ++improved;
          EXPECT_LT(value_m2, greedy_m2);
          EXPECT_NEAR(exchanges.back().value_m2, value_m2, 1e-7 * value_m2);
        }
        for (std::size_t k = 0; k < count; ++k) {
          for (const std::size_t other : objective.points) {
            std::vector<std::size_t> trial = chosen;
            if (std::find(trial.begin(), trial.end(), other) != trial.end()) continue;
            trial[k] = other;
            EXPECT_GE(ValueWith(objective, start, trial, sigma_m2), value_m2 * (1.0 - 1e-7));
          }
        }
        double best_m2 = value_m2;
        const std::size_t m = objective.points.size();
        for (std::size_t a = 0; a < m; ++a) {
          for (std::size_t b = a + 1; b < m; ++b) {
            for (std::size_t c = count == 3 ? b + 1 : m - 1; c < m; ++c) {
              std::vector<std::size_t> set = {objective.points[a], objective.points[b]};
              if (count == 3) set.push_back(objective.points[c]);
              best_m2 = std::min(best_m2, ValueWith(objective, start, set, sigma_m2));
            }
          }
        }
        EXPECT_LT(value_m2, 1.1 * best_m2);
      }
    }
  }
  EXPECT_GE(improved, 1);  // else nothing was tested
}

// Brute force: of one candidate more than points to place, any set is one exchange from any other,
// so that the end of the exchanges is the best set, whatever they began with.
TEST(PlacementTest, ExchangesFindTheBestSetWhereItIsOneExchangeAway) {
  const Planned planned("earth-asc-desc", kSmall);
  const BlockCovariance start = planned.Covariance();
  PlacementObjective objective;
  std::vector<Eigen::Matrix3d> sigma_m2;
  for (std::size_t i = 0; i < start.points().size(); ++i) {
    sigma_m2.push_back(planned.Sigma(start.points()[i], 0.37));
    objective.points.push_back(i);
  }
  const std::vector<std::size_t> candidates = {1, 3, 4, 8, 9};
  std::vector<Eigen::Matrix3d> of_candidates_m2;
  for (const std::size_t i : candidates) of_candidates_m2.push_back(sigma_m2[i]);
  for (const PlacementCriterion criterion :
       {PlacementCriterion::kMeanVariance, PlacementCriterion::kWorstPoint}) {
    objective.criterion = criterion;
    const auto without = [&](std::size_t left_out) {
      std::vector<std::size_t> set = candidates;
      set.erase(set.begin() + static_cast<std::ptrdiff_t>(left_out));
      return set;
    };
    double best_m2 = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      best_m2 = std::min(best_m2, ValueWith(objective, start, without(k), sigma_m2));
    }
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      BlockCovariance covariance = start;
      std::vector<std::size_t> chosen = without(k);
      for (const std::size_t i : chosen) covariance.AddControl(i, sigma_m2[i]);
      static_cast<void>(
          ExchangePlacement(objective, candidates, of_candidates_m2, &chosen, &covariance));
      EXPECT_NEAR(ValueOf(objective, covariance), best_m2, 1e-7 * best_m2) << k;
    }
  }
}

// Hand arithmetic of the definition, pair by pair.
TEST(PlacementTest, TheFreedomOfASumOfSquaresIsThatOfItsVariance) {
  const Planned planned("earth-asc-desc", kSmall);
  const BlockCovariance covariance = planned.Covariance();
  const std::vector<std::size_t> chosen = {1, 2, 5, 8};
  double sum = 0.0;
  for (const std::size_t i : chosen) {
    for (const std::size_t j : chosen) {
      const Eigen::Matrix3d cross = i == j ? covariance.Point(i) : covariance.Between(i, j);
      const Eigen::Matrix3d a = covariance.Point(i).ldlt().solve(cross);
      const Eigen::Matrix3d b = covariance.Point(j).ldlt().solve(cross.transpose());
      sum += (a * b).trace();
    }
  }
  EXPECT_NEAR(covariance.SquareFreedom(chosen), 144.0 / sum, 1e-9 * 144.0 / sum);
  EXPECT_LT(covariance.SquareFreedom(chosen), 12.0);
  EXPECT_NEAR(covariance.SquareFreedom({3}), 3.0, 1e-9);
}

/// What four points, placed greedily and where need be exchanged, leave of the criterion on the
/// block of twelve strips, as part of what four corners of the same quality leave.
double AgainstCorners(PlacementCriterion criterion, std::size_t flights) {
  const std::string name = "block-12-strips";
  const auto planned = [&](const std::string& layout) {
    Scene scene = Planned::SceneOf(
        name, {"check.count=0", "control.sigma_m=[0.3, 0.3, 0.6]", "control.count=4", layout});
    scene.flights.resize(flights);
    return Planned(name, scene);
  };
  const Planned corners = planned("control.layout=corners");
  const Planned none = planned("control.layout=none");
  std::vector<std::uint32_t> points;
  for (std::uint32_t i = 0; i < corners.simulated.block.points.size(); ++i) {
    if (corners.simulated.block.points.role[i] != PointRole::kControl) points.push_back(i);
  }
  BlockCovariance covariance = none.Covariance();
  PlacementObjective objective;
  objective.criterion = criterion;
  std::vector<Eigen::Matrix3d> sigma_m2;
  for (std::size_t i = 0; i < covariance.points().size(); ++i) {
    objective.points.push_back(i);
    sigma_m2.push_back(none.Sigma(covariance.points()[i], 0.3));
  }
  EXPECT_EQ(objective.points.size(), points.size());
  std::vector<std::size_t> chosen;
  double greedy_m2 = 0.0;
  for (const PlacementStep& step :
       PlaceGreedily(objective, objective.points, sigma_m2, 4, &covariance)) {
    chosen.push_back(step.point);
    greedy_m2 = step.value_m2;
  }
  EXPECT_NEAR(greedy_m2, ValueOf(objective, covariance), 1e-6 * greedy_m2);
  if (criterion == PlacementCriterion::kWorstPoint || flights == 1) {  // greedy is enough there
    return greedy_m2 / Criterion(criterion, corners, points, {});
  }
  static_cast<void>(ExchangePlacement(objective, objective.points, sigma_m2, &chosen, &covariance));
  const double value_m2 = ValueOf(objective, covariance);
  EXPECT_LE(value_m2, greedy_m2 * (1.0 + 1e-9));
  return value_m2 / Criterion(criterion, corners, points, {});
}

// Another layout as the yardstick: four corners, the same number and quality of control.
TEST(PlacementTest, PlacementBeatsCornersOnTwelveStrips) {
  EXPECT_LT(AgainstCorners(PlacementCriterion::kMeanVariance, 1), 0.99);
  EXPECT_LT(AgainstCorners(PlacementCriterion::kWorstPoint, 1), 0.99);
  // Two tie strips: greedy alone is 0.4 percent behind the corners here.
  EXPECT_LT(AgainstCorners(PlacementCriterion::kMeanVariance, 3), 1.0);
  EXPECT_LT(AgainstCorners(PlacementCriterion::kWorstPoint, 3), 0.99);  // with two tie strips
}

}  // namespace
}  // namespace sarblock
