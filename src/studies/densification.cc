// SPDX-License-Identifier: Apache-2.0
#include "densification.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "placement.h"
#include "quality/point_sweep.h"

namespace sarblock {

double MedianOf(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t middle = values.size() / 2;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(middle);
  std::nth_element(values.begin(), at, values.end());
  if (values.size() % 2 == 1) return *at;
  return 0.5 * (*at + *std::max_element(values.begin(), at));
}

Accuracy SummariseAccuracy(const std::vector<SymmetricEnu>& points_m2,
                           const std::vector<SymmetricEnu>& differences_m2,
                           const std::vector<double>& distances_m) {
  Accuracy out;
  const auto sigmas = [](const std::vector<SymmetricEnu>& covariances_m2, std::size_t axis) {
    std::vector<double> values;
    for (const SymmetricEnu& q : covariances_m2) values.push_back(std::sqrt(q[axis]));
    return values;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.median_sigma_m[axis] = MedianOf(sigmas(points_m2, axis));
    double sum = 0.0;
    for (const SymmetricEnu& q : points_m2) sum += q[axis];
    out.rms_sigma_m[axis] = std::sqrt(sum / static_cast<double>(points_m2.size()));
    out.median_difference_sigma_m[axis] = MedianOf(sigmas(differences_m2, axis));
  }
  std::vector<double> horizontal_m;
  for (const SymmetricEnu& q : points_m2) {
    horizontal_m.push_back(std::sqrt(q[0] + q[1]));
    out.max_sigma_h_m = std::max(out.max_sigma_h_m, horizontal_m.back());
    out.max_sigma_u_m = std::max(out.max_sigma_u_m, std::sqrt(q[2]));
  }
  out.median_sigma_h_m = MedianOf(std::move(horizontal_m));
  out.median_distance_m = MedianOf(distances_m);
  return out;
}

const std::vector<StudyColumn>& DensificationColumns() {
  using Kind = StudyCellKind;
  static const std::vector<StudyColumn> columns = {
      {"layout", Kind::kText, InReport::kNeeded},
      {"control_points", Kind::kInteger, InReport::kNeeded},
      {"tie_points", Kind::kInteger},
      {"passes", Kind::kInteger},
      {"median_sigma_e_m"},
      {"median_sigma_n_m"},
      {"median_sigma_u_m"},
      {"max_sigma_h_m"},
      {"max_sigma_u_m"},
      {"montecarlo_rms_e_m"},
      {"montecarlo_rms_n_m"},
      {"montecarlo_rms_u_m"},
      {"nees"},
      {"runs", Kind::kInteger},
      {"determined", Kind::kInteger},
      {"variant", Kind::kText},
      {"looks", Kind::kInteger, InReport::kNo},
      {"median_sigma_h_m", Kind::kNumber, InReport::kNo},
      {"rms_sigma_e_m", Kind::kNumber, InReport::kNo},
      {"rms_sigma_n_m", Kind::kNumber, InReport::kNo},
      {"rms_sigma_u_m"},
      {"neighbour_distance_m", Kind::kNumber, InReport::kNo},
      {"median_difference_sigma_e_m", Kind::kNumber, InReport::kNo},
      {"median_difference_sigma_n_m", Kind::kNumber, InReport::kNo},
      {"median_difference_sigma_u_m", Kind::kNumber, InReport::kNo},
      {"nees_lower", Kind::kNumber, InReport::kNo},
      {"nees_upper", Kind::kNumber, InReport::kNo},
      {"agrees", Kind::kInteger, InReport::kNo},
      {"added_point", Kind::kText, InReport::kNo},
      {"added_east_m", Kind::kNumber, InReport::kNo},
      {"added_north_m", Kind::kNumber, InReport::kNo},
      {"message", Kind::kText, InReport::kNo},
      {"criterion_m2", Kind::kNumber, InReport::kNo},
  };
  return columns;
}

namespace {

void SetAccuracy(const Accuracy& accuracy, StudyRowMaker* row) {
  const std::array<std::string, 3> axes = {"e", "n", "u"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    row->Set("median_sigma_" + axes[axis] + "_m", accuracy.median_sigma_m[axis]);
    row->Set("rms_sigma_" + axes[axis] + "_m", accuracy.rms_sigma_m[axis]);
    row->Set("median_difference_sigma_" + axes[axis] + "_m",
             accuracy.median_difference_sigma_m[axis]);
  }
  row->Set("median_sigma_h_m", accuracy.median_sigma_h_m)
      .Set("max_sigma_h_m", accuracy.max_sigma_h_m)
      .Set("max_sigma_u_m", accuracy.max_sigma_u_m)
      .Set("neighbour_distance_m", accuracy.median_distance_m);
}

void SetBlock(const StudyCase& of, const Block& block, StudyRowMaker* row) {
  std::size_t control = 0, tie = 0;
  for (const PointRole role : block.points.role) {
    control += role == PointRole::kControl ? 1 : 0;
    tie += role == PointRole::kTie ? 1 : 0;
  }
  row->Set("layout", of.layout)
      .Set("variant", of.variant)
      .Count("control_points", control)
      .Count("tie_points", tie)
      .Count("passes", block.passes.size())
      .Count("looks", block.looks.size());
}

AdjustOptions OptionsOf(const StudyCase& of) {
  AdjustOptions options = of.adjust;
  options.threads = AvailableCores();  // all that the caller may use
  options.covariance = CovarianceLevel::kBlock;
  options.pairs = PairChoice::kNeighbours;
  return options;
}

Accuracy AccuracyOf(const SimulatedBlock& planned, const AdjustResult& predicted) {
  std::vector<SymmetricEnu> points_m2, differences_m2;
  for (const std::uint32_t point : PointsCounted(planned.block, predicted.points)) {
    points_m2.push_back(predicted.points.covariance_m2[point]);
  }
  std::vector<double> distances_m;
  for (const PairResult& pair : predicted.pairs) {
    if (planned.block.points.role[pair.a] == PointRole::kControl ||
        planned.block.points.role[pair.b] == PointRole::kControl) {
      continue;
    }
    differences_m2.push_back(pair.covariance_m2);
    distances_m.push_back(pair.difference_enu_m.norm());
  }
  return SummariseAccuracy(points_m2, differences_m2, distances_m);
}

std::vector<StudyRow> ComputeCase(const DensificationStudy& study,
                                  std::size_t index,
                                  ProgressSink* progress) {
  const StudyCase& of = study.cases[index];
  const bool verify = study.verify.Covers(index);
  const Scene scene = verify ? SceneToDraw(of, study.verify) : of.scene;
  const AdjustOptions options = OptionsOf(of);
  const SimulatedBlock planned = PlannedBlock(scene);
  StudyRowMaker row(DensificationColumns());
  SetBlock(of, planned.block, &row);
  try {
    const AdjustResult predicted = Predict(planned.block, options, planned.truth.points_m);
    row.Count("determined", 1).Count("runs", 0);
    SetAccuracy(AccuracyOf(planned, predicted), &row);
    if (verify) {
      SetVerification(Verify(scene,
                             planned,
                             options,
                             predicted,
                             study.verify.runs,
                             MixStream(study.heading.seed, index),
                             study.verify.LevelOfOne(study.cases.size()),
                             progress),
                      {"e", "n", "u"},
                      &row);
    }
  } catch (const UndeterminedError& error) {
    row.Count("determined", 0).Count("runs", 0).Message(error.what());
  }
  return {row.row()};
}

/// Accuracy with the control placed so far.
Accuracy AccuracyOf(const SimulatedBlock& planned,
                    const BlockCovariance& covariance,
                    const std::vector<std::size_t>& points,
                    const BlockCovariance::Pairs& pairs) {
  const std::vector<Eigen::Vector3d>& at_m = planned.truth.points_m;
  const Frame& frame = planned.block.frame;
  std::vector<SymmetricEnu> points_m2, differences_m2;
  std::vector<double> distances_m;
  for (const std::size_t i : points) {
    points_m2.push_back(ToEnu(frame, at_m[covariance.points()[i]], covariance.Point(i)));
  }
  for (const auto& [a, b] : pairs) {
    const Eigen::Vector3d& a_m = at_m[covariance.points()[a]];
    differences_m2.push_back(ToEnu(frame, a_m, covariance.Difference(a, b)));
    distances_m.push_back((at_m[covariance.points()[b]] - a_m).norm());
  }
  return SummariseAccuracy(points_m2, differences_m2, distances_m);
}

/// Where a point lies in the scene plane, but for the curvature of verticals.
Eigen::Vector2d PlaneOf(const Scene& scene, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d origin_m = FrameFromPlane(scene, Eigen::Vector2d::Zero(), 0.0);
  return (scene.frame.EnuFromFrame(origin_m) * (p_m - origin_m)).head<2>();
}

bool IsCandidate(PlacementCase::Candidates candidates, PointRole role) {
  switch (candidates) {
    case PlacementCase::Candidates::kTie:
      return role == PointRole::kTie;
    case PlacementCase::Candidates::kCheck:
      return role == PointRole::kCheck;
    case PlacementCase::Candidates::kAll:
      break;
  }
  return role != PointRole::kControl;
}

std::vector<StudyRow> ComputePlacement(const DensificationStudy& study,
                                       std::size_t index,
                                       ProgressSink* progress) {
  const PlacementCase& of = study.placements[index];
  const AdjustOptions options = OptionsOf(of.start);
  const SimulatedBlock planned = PlannedBlock(of.start.scene);
  const Block& block = planned.block;
  StudyRowMaker first(DensificationColumns());
  SetBlock(of.start, block, &first);
  first.Set("layout", std::string("greedy ") + NameOf(of.criterion)).Count("runs", 0);
  try {
    const AdjustResult predicted = Predict(block, options, planned.truth.points_m);
    BlockCovariance covariance(block, options, planned.truth.points_m, predicted.points.status);
    PlacementObjective objective;
    objective.criterion = of.criterion;
    std::vector<std::size_t> index_of(block.points.size()), candidates;
    std::vector<Eigen::Matrix3d> sigma_m2;
    for (std::size_t i = 0; i < covariance.points().size(); ++i) {
      const std::uint32_t point = covariance.points()[i];
      index_of[point] = i;
      const PointRole role = block.points.role[point];
      if (role != PointRole::kControl) objective.points.push_back(i);
      if (!IsCandidate(of.candidates, role)) continue;
      const Eigen::Matrix3d enu = block.frame.EnuFromFrame(planned.truth.points_m[point]);
      const Eigen::Vector3d square_m2(of.sigma_m[0] * of.sigma_m[0],
                                      of.sigma_m[1] * of.sigma_m[1],
                                      of.sigma_m[2] * of.sigma_m[2]);
      candidates.push_back(i);
      sigma_m2.push_back(enu.transpose() * square_m2.asDiagonal() * enu);
    }
    for (const PairResult& pair : predicted.pairs) {
      if (block.points.role[pair.a] == PointRole::kControl ||
          block.points.role[pair.b] == PointRole::kControl) {
        continue;
      }
      objective.pairs.emplace_back(index_of[pair.a], index_of[pair.b]);
    }
    if (objective.points.empty() || objective.pairs.empty()) {
      throw InputError("placement", "needs a block with points other than control");
    }
    first.Count("determined", 1);
    const auto control = static_cast<std::size_t>(
        std::count(block.points.role.begin(), block.points.role.end(), PointRole::kControl));
    std::vector<StudyRow> rows;
    const auto tell = [&](StudyRowMaker row) {
      if (progress != nullptr && progress->Cancelled()) throw Interrupted("study");
      SetAccuracy(AccuracyOf(planned, covariance, objective.points, objective.pairs), &row);
      row.Set("criterion_m2", ValueOf(objective, covariance));
      rows.push_back(row.Count("control_points", control + rows.size()).row());
    };
    tell(first);
    const auto place_of = [&](std::size_t i) {
      return PlaneOf(of.start.scene, planned.truth.points_m[covariance.points()[i]]);
    };
    const auto id_of = [&](std::size_t i) {
      return std::string(block.points.ids[covariance.points()[i]]);
    };
    std::vector<std::size_t> chosen;
    static_cast<void>(PlaceGreedily(
        objective, candidates, sigma_m2, of.count, &covariance, [&](const PlacementStep& step) {
          chosen.push_back(step.point);
          const Eigen::Vector2d plane_m = place_of(step.point);
          StudyRowMaker row = first;
          row.Set("added_point", id_of(step.point))
              .Set("added_east_m", plane_m.x())
              .Set("added_north_m", plane_m.y());
          tell(row);
        }));
    if (of.exchange == PlacementCase::Exchange::kOff || chosen.size() < 2) return rows;
    std::string reported;
    for (const PlacementExchange& exchange :
         ExchangePlacement(objective, candidates, sigma_m2, &chosen, &covariance, [progress] {
           if (progress != nullptr && progress->Cancelled()) throw Interrupted("study");
         })) {
      const Eigen::Vector2d at_m = place_of(exchange.added);
      reported += (reported.empty() ? "" : ", ") + id_of(exchange.removed) + " for " +
                  id_of(exchange.added) + " at (" + std::to_string(std::lround(at_m.x())) + ", " +
                  std::to_string(std::lround(at_m.y())) + ")";
    }
    StudyRowMaker last = first;
    last.Set("layout", std::string("exchange ") + NameOf(of.criterion)).Message(reported);
    SetAccuracy(AccuracyOf(planned, covariance, objective.points, objective.pairs), &last);
    last.Set("criterion_m2", ValueOf(objective, covariance))
        .Count("control_points", control + chosen.size());
    rows.push_back(last.row());
    return rows;
  } catch (const UndeterminedError& error) {
    return {first.Count("determined", 0).Message(error.what()).row()};
  }
}

}  // namespace

StudyPlan PlanDensification(const DensificationStudy& study) {
  StudyPlan plan;
  plan.columns = DensificationColumns();
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    const StudyCase& of = study.cases[i];
    plan.tasks.push_back(
        {of.layout + " " + std::to_string(of.scene.control.count),
         [&study, i](ProgressSink* progress) { return ComputeCase(study, i, progress); }});
  }
  for (std::size_t i = 0; i < study.placements.size(); ++i) {
    plan.tasks.push_back(
        {std::string("greedy ") + NameOf(study.placements[i].criterion),
         [&study, i](ProgressSink* progress) { return ComputePlacement(study, i, progress); }});
  }
  return plan;
}

}  // namespace sarblock
