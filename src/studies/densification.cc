// SPDX-License-Identifier: Apache-2.0
#include "densification.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cases.h"
#include "core/threads.h"
#include "placement.h"
#include "quality/point_sweep.h"
#include "study.h"
#include "tables/toml.h"

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

namespace {

/// "control.count=9" of a choice, the last one; nothing where it is not set.
std::optional<std::string> LastSet(const CaseChoice& choice, const std::string& key) {
  for (auto entry = choice.set.rbegin(); entry != choice.set.rend(); ++entry) {
    if (entry->starts_with(key + "=")) return entry->substr(key.size() + 1);
  }
  return std::nullopt;
}

/// Corners with more than four points: a place of the product where there is no layout.
bool IsNoLayout(const CaseChoice& choice) {
  const auto layout = LastSet(choice, "control.layout");
  const auto count = LastSet(choice, "control.count");
  if (!layout || !count || layout->find("corners") == std::string::npos) return false;
  return std::atol(count->c_str()) > 4;
}

/// All of a placement but the case it starts from.
PlacementCase ReadPlacementKeys(SceneTable* from) {
  using Candidates = PlacementCase::Candidates;
  SceneTable& table = *from;
  PlacementCase placement;
  table.Choice<PlacementCriterion>("criterion",
                                   {{"mean-variance", PlacementCriterion::kMeanVariance},
                                    {"worst-point", PlacementCriterion::kWorstPoint},
                                    {"mean-differences", PlacementCriterion::kMeanDifferences}},
                                   &placement.criterion);
  table.Count("count", &placement.count);
  table.Choice<Candidates>(
      "candidates",
      {{"tie", Candidates::kTie}, {"check", Candidates::kCheck}, {"all", Candidates::kAll}},
      &placement.candidates);
  table.Choice<PlacementCase::Exchange>(
      "exchange",
      {{"on", PlacementCase::Exchange::kOn}, {"off", PlacementCase::Exchange::kOff}},
      &placement.exchange);
  table.Numbers("sigma_m", &placement.sigma_m);
  return placement;
}

PlacementCase ReadPlacement(SceneTable table, CaseChoice base, CaseMaker* maker) {
  PlacementCase placement = ReadPlacementKeys(&table);
  for (const double sigma_m : placement.sigma_m) {
    if (!(sigma_m > 0.0)) {
      throw InputError(table.PlaceOf("sigma_m"), "must be given, three positive numbers");
    }
  }
  std::string name;
  table.Text("name", &name);
  CaseChoice choice = TakeChanges(&table);
  choice.label = name;
  base.Add(choice);
  table.Finish();
  placement.start = maker->Make(base);
  return placement;
}

DensificationGoal ReadGoal(SceneTable& table) {
  DensificationGoal goal;
  for (const auto& [key, value] :
       {std::pair{"sigma_h_m", &goal.sigma_h_m}, std::pair{"sigma_u_m", &goal.sigma_u_m}}) {
    if (const auto taken = table.Take(key)) *value = taken->Positive();
  }
  table.Choice<DensificationGoal::Of>(
      "of",
      {{"worst", DensificationGoal::Of::kWorstPoint}, {"median", DensificationGoal::Of::kMedian}},
      &goal.of);
  table.Finish();
  return goal;
}

}  // namespace

DensificationFile ParseDensification(
    std::string_view text,
    const std::string& file,
    const std::vector<std::string>& overrides,
    const std::function<std::string(const std::string& name)>& scene_text) {
  const toml::table root = ParseToml(text, file, overrides);
  SceneTable table{TomlTable(root, "")};
  DensificationFile out;
  out.study.heading = TakeStudyHeading("densification", &table);
  const CaseChoice base = TakeChanges(&table);
  std::vector<CaseAxis> axes;
  for (SceneTable& axis : table.Tables("axis")) axes.push_back(ReadAxis(std::move(axis)));
  std::vector<CaseChoice> choices;
  if (!axes.empty()) choices = Product(base, axes, table.PlaceOf("axis"));
  for (SceneTable& listed : table.Tables("case")) {
    std::string name;
    listed.Text("name", &name);
    CaseChoice choice = TakeChanges(&listed);
    choice.label = name;
    listed.Finish();
    choices.push_back(base);
    choices.back().Add(choice);
  }
  CaseMaker maker(file, scene_text);
  std::set<std::pair<std::string, std::string>> without_control;
  for (const CaseChoice& choice : choices) {
    if (IsNoLayout(choice)) continue;
    StudyCase made = maker.Make(choice);
    // Zero points of every layout are one and the same block.
    if (made.layout == "none" && !without_control.emplace(made.variant, *choice.scene).second) {
      continue;
    }
    out.study.cases.push_back(std::move(made));
  }
  for (SceneTable& placement : table.Tables("placement")) {
    out.study.placements.push_back(ReadPlacement(std::move(placement), base, &maker));
  }
  if (auto verify = table.Table("verify")) out.study.verify = ReadVerification(*verify);
  if (auto goal = table.Table("goal")) out.study.goal = ReadGoal(*goal);
  table.Finish();
  if (out.study.cases.empty() && out.study.placements.empty()) {
    throw InputError(table.PlaceOf("axis"), "must be given: [[axis]], [[case]] or [[placement]]");
  }
  CheckVerification(out.study.verify, out.study.cases);
  out.identity = TextOf(root);
  for (const auto& [name, scene] : maker.texts()) out.identity += SceneAsComment(name, scene);
  return out;
}

DensificationFile ReadDensification(const std::filesystem::path& path,
                                    const std::vector<std::string>& overrides) {
  const std::string text = ReadTomlText(path, "a study");
  return ParseDensification(text, path.string(), overrides, ScenesOf(path, text));
}

std::vector<std::string> DensificationKeys() {
  std::vector<std::string> keys = {"name", "purpose", "seed", "scene", "flights", "set"};
  const toml::table empty;
  // The readers are asked on an empty table: they ask for every key they know.
  const auto add = [&](const std::string& name, const auto& read) {
    SceneTable asked{TomlTable(empty, name)};
    read(asked);
    for (const std::string& key : asked.known()) keys.push_back(name + "." + key);
  };
  add("verify", [](SceneTable& table) { static_cast<void>(ReadVerification(table)); });
  add("goal", [](SceneTable& table) { static_cast<void>(ReadGoal(table)); });
  add("placement.0", [](SceneTable& table) { static_cast<void>(ReadPlacementKeys(&table)); });
  return keys;
}

namespace {

std::string Metres(double value_m) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), "%.3g m", value_m);
  return text.data();
}

std::string Figure(double value) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), "%.3f", value);
  return text.data();
}

bool IsExchange(const StudyTable& table, std::size_t row) {
  return table.Text(row, "layout").starts_with("exchange ");
}

bool IsPlacement(const StudyTable& table, std::size_t row) {
  return table.Text(row, "layout").starts_with("greedy ") || IsExchange(table, row);
}

/// What exchanging points after the placement whose last row is `last` did.
std::string DescribeExchange(const StudyTable& table, std::size_t last) {
  const std::size_t row = last + 1;
  if (row >= table.size() || !IsExchange(table, row)) return {};
  const std::string exchanged = table.Text(row, "message");
  if (exchanged.empty()) return "; no exchange of one of them lowers the criterion";
  const double before = table.Number(last, "criterion_m2");
  const double after = table.Number(row, "criterion_m2");
  return "; exchanging " + exchanged + " lowers the criterion from " + Figure(before) + " m2 to " +
         Figure(after) + " m2 (" + Figure(100.0 * (1.0 - after / before)) +
         " percent), then no exchange of one does";
}

std::string ControlOf(const StudyTable& table, std::size_t row) {
  const auto count = static_cast<long>(table.Number(row, "control_points"));
  const std::string layout = table.Text(row, "layout");
  return count == 0   ? "no control"
         : count == 1 ? "one control point (" + layout + ")"
                      : std::to_string(count) + " control points (" + layout + ")";
}

/// The two figures that the goal speaks of.
struct Reached {
  double sigma_h_m;
  double sigma_u_m;
};
Reached ReachedBy(const DensificationGoal& goal, const StudyTable& table, std::size_t row) {
  const std::string of = goal.of == DensificationGoal::Of::kMedian ? "median" : "max";
  return {table.Number(row, of + "_sigma_h_m"), table.Number(row, of + "_sigma_u_m")};
}

/// How far from the goal, 1 or less where it is reached.
double Excess(const DensificationGoal& goal, const Reached& reached) {
  double excess = 0.0;
  if (!std::isnan(goal.sigma_h_m)) excess = reached.sigma_h_m / goal.sigma_h_m;
  if (!std::isnan(goal.sigma_u_m)) excess = std::max(excess, reached.sigma_u_m / goal.sigma_u_m);
  return excess;
}

std::string Describe(const DensificationGoal& goal) {
  std::string text;
  if (!std::isnan(goal.sigma_h_m)) text = "sigma_h " + Metres(goal.sigma_h_m);
  if (!std::isnan(goal.sigma_u_m)) {
    text += (text.empty() ? "sigma_u " : " and sigma_u ") + Metres(goal.sigma_u_m);
  }
  return text + (goal.of == DensificationGoal::Of::kMedian ? " in the median" : " everywhere");
}

/// Variants of the cases that are no placements, in the order of the table.
std::vector<std::string> VariantsOf(const StudyTable& table) {
  std::vector<std::string> variants;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string variant = table.Text(row, "variant");
    if (!IsPlacement(table, row) &&
        std::find(variants.begin(), variants.end(), variant) == variants.end()) {
      variants.push_back(variant);
    }
  }
  return variants;
}

/// Determined cases of a variant.
std::vector<std::size_t> RowsOf(const StudyTable& table, const std::string& variant) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (IsPlacement(table, row) || !IsDetermined(table, row)) continue;
    if (table.Text(row, "variant") == variant) rows.push_back(row);
  }
  return rows;
}

/// "with 4 control points (corners): 2.1 m, 3.4 m".
std::string With(const StudyTable& table, std::size_t row, const Reached& reached) {
  const bool none = table.Number(row, "control_points") == 0.0;
  return (none ? "without control" : "with " + ControlOf(table, row)) + ": sigma_h " +
         Metres(reached.sigma_h_m) + ", sigma_u " + Metres(reached.sigma_u_m);
}

/// The fewest points that reach the goal, of several layouts the best.
std::string DescribeGoal(const DensificationGoal& goal,
                         const StudyTable& table,
                         const std::vector<std::size_t>& rows) {
  std::optional<std::size_t> fewest, nearest;
  const auto excess = [&](std::size_t row) { return Excess(goal, ReachedBy(goal, table, row)); };
  const auto points = [&](std::size_t row) { return table.Number(row, "control_points"); };
  for (const std::size_t row : rows) {
    if (!nearest || excess(row) < excess(*nearest)) nearest = row;
    if (excess(row) > 1.0) continue;
    if (!fewest || points(row) < points(*fewest) ||
        (points(row) == points(*fewest) && excess(row) < excess(*fewest))) {
      fewest = row;
    }
  }
  if (!fewest) {
    return Describe(goal) + " is missed by all layouts; the nearest is " +
           With(table, *nearest, ReachedBy(goal, table, *nearest));
  }
  const std::string with = With(table, *fewest, ReachedBy(goal, table, *fewest));
  return Describe(goal) + " is reached " + with +
         (points(*fewest) > 0.0 ? "; no smaller layout of the study does" : "");
}

/// Without a goal: the fewest control points and the best layout.
std::string DescribeRange(const StudyTable& table, const std::vector<std::size_t>& rows) {
  const auto of = [&](std::size_t row) {
    return Reached{table.Number(row, "max_sigma_h_m"), table.Number(row, "max_sigma_u_m")};
  };
  std::size_t fewest = rows.front(), best = rows.front();
  for (const std::size_t row : rows) {
    const double count = table.Number(row, "control_points");
    const double least = table.Number(fewest, "control_points");
    if (count < least || (count == least && of(row).sigma_u_m < of(fewest).sigma_u_m)) fewest = row;
    if (of(row).sigma_u_m < of(best).sigma_u_m) best = row;
  }
  std::string text = "the worst point has " + With(table, fewest, of(fewest));
  if (best != fewest) text += "; best " + With(table, best, of(best));
  return text;
}

/// One sentence a variant.
void DescribeVariants(const DensificationStudy& study,
                      const StudyTable& table,
                      std::vector<std::string>* words) {
  const bool goal = !std::isnan(study.goal.sigma_h_m) || !std::isnan(study.goal.sigma_u_m);
  for (const std::string& variant : VariantsOf(table)) {
    const std::vector<std::size_t> rows = RowsOf(table, variant);
    const std::string found = rows.empty() ? "no layout of the study determines the block"
                              : goal       ? DescribeGoal(study.goal, table, rows)
                                           : DescribeRange(table, rows);
    words->push_back((variant.empty() ? "" : variant + ": ") + found);
  }
}

/// Where the points of each placement went and what they were worth.
void DescribePlacements(const StudyTable& table, std::vector<std::string>* words) {
  for (std::size_t begin = 0; begin < table.size(); ++begin) {
    if (!IsPlacement(table, begin) || IsExchange(table, begin)) continue;
    if (!table.Text(begin, "added_point").empty()) continue;
    const std::string variant = table.Text(begin, "variant");
    std::string text = (variant.empty() ? "" : variant + ": ") + table.Text(begin, "layout");
    if (!IsDetermined(table, begin)) {
      words->push_back(text + ": " + table.Text(begin, "message"));
      continue;
    }
    text += " placement from " + ControlOf(table, begin) + ":";
    std::size_t last = begin;
    for (std::size_t row = begin + 1; row < table.size(); ++row) {
      if (!IsPlacement(table, row) || table.Text(row, "added_point").empty()) break;
      text += (last == begin ? " " : ", ") + table.Text(row, "added_point") + " at (" +
              std::to_string(std::lround(table.Number(row, "added_east_m"))) + ", " +
              std::to_string(std::lround(table.Number(row, "added_north_m"))) + ")";
      last = row;
    }
    words->push_back(text + "; the worst point goes from sigma_h " +
                     Metres(table.Number(begin, "max_sigma_h_m")) + ", sigma_u " +
                     Metres(table.Number(begin, "max_sigma_u_m")) + " to " +
                     Metres(table.Number(last, "max_sigma_h_m")) + ", " +
                     Metres(table.Number(last, "max_sigma_u_m")) + DescribeExchange(table, last));
  }
}

}  // namespace

std::vector<std::string> DescribeDensification(const DensificationStudy& study,
                                               const StudyTable& table) {
  std::vector<std::string> words;
  DescribeVariants(study, table, &words);
  DescribePlacements(table, &words);
  for (std::string& sentence : DescribeVerification(study.verify, table, [&](std::size_t row) {
         return ControlOf(table, row) + " " + table.Text(row, "variant");
       })) {
    words.push_back(std::move(sentence));
  }
  const auto undetermined = [&] {
    std::size_t count = 0;
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (!IsDetermined(table, row)) ++count;
    }
    return count;
  }();
  if (undetermined > 0) {
    words.push_back(std::to_string(undetermined) + " of " + std::to_string(table.size()) +
                    " blocks cannot be determined with their control; see the column message");
  }
  return words;
}

}  // namespace sarblock
