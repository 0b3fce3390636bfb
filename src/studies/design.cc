// SPDX-License-Identifier: Apache-2.0
#include "design.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "densification.h"
#include "quality/covariance.h"
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sarblock {

// ---- the file

namespace {

constexpr std::array kGoalColumns = {"median_sigma_along_m",
                                     "median_sigma_across_m",
                                     "median_sigma_up_m",
                                     "max_sigma_along_m",
                                     "max_sigma_across_m",
                                     "max_sigma_up_m",
                                     "difference_sigma_along_m",
                                     "difference_sigma_across_m",
                                     "difference_sigma_up_m",
                                     "cost"};

DesignPrices ReadPrices(SceneTable& table) {
  DesignPrices prices;
  table.Text("currency", &prices.currency);
  for (const auto& [key, price] : {std::pair{"pass", &prices.pass},
                                   std::pair{"kilometre", &prices.kilometre},
                                   std::pair{"control_point", &prices.control_point}}) {
    if (const auto taken = table.Take(key)) *price = taken->Positive();
  }
  table.Finish();
  return prices;
}

/// Index of a name among the axes, or of a text among the values of one.
std::size_t IndexOf(const std::string& name,
                    const std::vector<std::string>& known,
                    const FilePlace& place) {
  const auto found = std::find(known.begin(), known.end(), name);
  if (found != known.end()) return static_cast<std::size_t>(found - known.begin());
  throw InputError(place,
                   fmt::format("must be one of '{}', got '{}'", fmt::join(known, "', '"), name));
}

DesignLaw ReadLaw(SceneTable& table, const DesignStudy& study) {
  DesignLaw law;
  std::vector<std::string> names;
  for (const DesignAxis& axis : study.axes) names.push_back(axis.name);
  std::string name = names.size() == 1 ? names.front() : "";
  table.Text("axis", &name);
  law.axis = IndexOf(name, names, table.PlaceOf("axis"));
  for (const CaseChoice& choice : study.choices[law.axis]) {
    if (choice.number > 0.0) continue;
    throw InputError(table.PlaceOf("axis"),
                     fmt::format("'{}' has a value that is no number above 0, '{}'; a case of an "
                                 "axis takes 'number'",
                                 name,
                                 choice.value));
  }
  table.Choice<DesignLaw::Part>(
      "part", {{"paths", DesignLaw::Part::kPaths}, {"all", DesignLaw::Part::kAll}}, &law.part);
  const bool alone = study.axes.size() == 1;
  const std::vector<std::string> others =
      alone ? std::vector<std::string>{""} : study.axes[1 - law.axis].values;
  law.derived.assign(others.size(), {kNotGiven, kNotGiven, kNotGiven});
  for (SceneTable& listed : table.Tables("derived")) {
    std::string of;
    if (!alone) listed.Text("case", &of);
    std::array<double, 3>& exponents =
        law.derived[alone ? 0 : IndexOf(of, others, listed.PlaceOf("case"))];
    for (std::size_t i = 0; i < exponents.size(); ++i) {
      listed.Number(kDesignDirections[i], &exponents[i]);
    }
    listed.Finish();
  }
  table.Finish();
  return law;
}

void ReadGoals(SceneTable& table, DesignStudy* study) {
  if (const auto taken = table.Take("difference_m")) study->difference_m = taken->Positive();
  for (const char* column : kGoalColumns) {
    const auto taken = table.Take(column);
    if (!taken) continue;
    if (std::string_view(column).starts_with("difference") && std::isnan(study->difference_m)) {
      taken->Fail("needs difference_m, the distance of the points");
    }
    study->goals.push_back({column, taken->Positive()});
  }
  table.Finish();
}

}  // namespace

DesignFile ParseDesign(std::string_view text,
                       const std::string& file,
                       const std::vector<std::string>& overrides,
                       const std::function<std::string(const std::string& name)>& scene_text) {
  const toml::table root = ParseToml(text, file, overrides);
  SceneTable table{TomlTable(root, "")};
  DesignFile out;
  DesignStudy& study = out.study;
  study.heading = TakeStudyHeading("design", &table);
  const CaseChoice base = TakeChanges(&table);
  std::vector<CaseAxis> axes;
  for (SceneTable& axis : table.Tables("axis")) axes.push_back(ReadAxis(std::move(axis)));
  if (axes.empty() || axes.size() > 2) {
    throw InputError(
        table.PlaceOf("axis"),
        fmt::format("must be given once or twice, got {} tables [[axis]]", axes.size()));
  }
  CaseMaker maker(file, scene_text);
  for (const CaseChoice& choice : Product(base, axes, table.PlaceOf("axis"))) {
    study.cases.push_back(maker.Make(choice));
  }
  for (const CaseAxis& axis : axes) {
    DesignAxis& made = study.axes.emplace_back();
    made.name = axis.name.empty() ? "case" : axis.name;
    for (const CaseChoice& choice : axis.choices) made.values.push_back(choice.value);
    study.choices.push_back(axis.choices);
  }
  if (auto goal = table.Table("goal")) ReadGoals(*goal, &study);
  if (auto cost = table.Table("cost")) study.prices = ReadPrices(*cost);
  if (auto verify = table.Table("verify")) study.verify = ReadVerification(*verify);
  if (auto law = table.Table("law")) study.law = ReadLaw(*law, study);
  table.Finish();
  for (const DesignGoal& goal : study.goals) {
    if (goal.column != "cost" || study.prices.Given()) continue;
    throw InputError(table.PlaceOf("goal.cost"), "needs prices: a table [cost]");
  }
  CheckVerification(study.verify, study.cases);
  out.identity = TextOf(root);
  for (const auto& [name, scene] : maker.texts()) out.identity += SceneAsComment(name, scene);
  return out;
}

DesignFile ReadDesign(const std::filesystem::path& path,
                      const std::vector<std::string>& overrides) {
  const std::string text = ReadTomlText(path, "a study");
  return ParseDesign(text, path.string(), overrides, ScenesOf(path, text));
}

std::vector<std::string> DesignKeys() {
  std::vector<std::string> keys = {"name", "purpose", "seed", "scene", "flights", "set"};
  keys.emplace_back("goal.difference_m");
  for (const char* column : kGoalColumns) keys.push_back(std::string("goal.") + column);
  for (const char* key : {"currency", "pass", "kilometre", "control_point"}) {
    keys.push_back(std::string("cost.") + key);
  }
  // The reader is asked on an empty table: it asks for every key it knows.
  const toml::table empty;
  SceneTable verify{TomlTable(empty, "verify")};
  static_cast<void>(ReadVerification(verify));
  for (const std::string& key : verify.known()) keys.push_back("verify." + key);
  for (const char* key : {"axis", "part"}) keys.push_back(std::string("law.") + key);
  return keys;
}

// ---- the rows

const std::vector<StudyColumn>& DesignColumns() {
  using Cell = StudyCellKind;
  static const std::vector<StudyColumn> columns = {{"axis_1", Cell::kText, InReport::kNeeded},
                                                   {"value_1", Cell::kText, InReport::kNeeded},
                                                   {"number_1"},
                                                   {"axis_2", Cell::kText},
                                                   {"value_2", Cell::kText},
                                                   {"number_2", Cell::kNumber, InReport::kNo},
                                                   {"median_sigma_along_m"},
                                                   {"median_sigma_across_m"},
                                                   {"median_sigma_up_m"},
                                                   {"max_sigma_along_m"},
                                                   {"max_sigma_across_m"},
                                                   {"max_sigma_up_m"},
                                                   {"worst_point", Cell::kText},
                                                   {"passes", Cell::kInteger},
                                                   {"control_points", Cell::kInteger},
                                                   {"points", Cell::kInteger, InReport::kNo},
                                                   {"looks_per_point"},
                                                   {"redundancy"},
                                                   {"flight_km"},
                                                   {"cost"},
                                                   {"reached", Cell::kInteger},
                                                   {"traded", Cell::kText},
                                                   {"pareto", Cell::kInteger},
                                                   {"determined", Cell::kInteger},
                                                   {"message", Cell::kText},
                                                   {"median_path_sigma_along_m"},
                                                   {"median_path_sigma_across_m"},
                                                   {"median_path_sigma_up_m"},
                                                   {"max_path_sigma_along_m"},
                                                   {"max_path_sigma_across_m"},
                                                   {"max_path_sigma_up_m"},
                                                   {"rms_sigma_along_m"},
                                                   {"rms_sigma_across_m"},
                                                   {"rms_sigma_up_m"},
                                                   {"montecarlo_rms_along_m"},
                                                   {"montecarlo_rms_across_m"},
                                                   {"montecarlo_rms_up_m"},
                                                   {"nees"},
                                                   {"nees_lower"},
                                                   {"nees_upper"},
                                                   {"runs", Cell::kInteger},
                                                   {"agrees", Cell::kInteger},
                                                   {"difference_m"},
                                                   {"difference_sigma_along_m"},
                                                   {"difference_sigma_across_m"},
                                                   {"difference_sigma_up_m"}};
  return columns;
}

std::vector<std::size_t> DesignPlaces(const DesignStudy& study, std::size_t index) {
  std::vector<std::size_t> place(study.axes.size());
  for (std::size_t axis = place.size(); axis-- > 0;) {
    place[axis] = index % study.axes[axis].values.size();
    index /= study.axes[axis].values.size();
  }
  return place;
}

namespace {

/// Horizontal direction of the first look's track at a point, east and north; nothing where no
/// look has a time on its path.
std::optional<Eigen::Vector2d> TrackAt(const Block& block,
                                       std::uint32_t point,
                                       const Eigen::Vector3d& p_m) {
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    Motion motion;
    if (!block.passes[block.looks.pass[i]].path.Evaluate(block.looks.time_s[i], &motion)) continue;
    return (block.frame.EnuFromFrame(p_m) * motion.velocity_mps).head<2>().normalized();
  }
  return std::nullopt;
}

/// Length of the flights within their strips.
double FlightLength_m(const Block& block) {
  double length_m = 0.0;
  for (const Pass& pass : block.passes) {
    const double middle_s = 0.5 * (pass.start_s + pass.end_s);
    const std::optional<Motion> motion = pass.path.At(middle_s);
    if (motion) length_m += motion->velocity_mps.norm() * (pass.end_s - pass.start_s);
  }
  return length_m;
}

void SetSigmas(const SimulatedBlock& planned, const AdjustResult& predicted, StudyRowMaker* row) {
  const std::vector<SymmetricEnu>& by_looks_m2 = predicted.points.fixed_path_covariance_m2;
  std::array<std::vector<double>, 3> sigmas_m, path_sigmas_m;
  std::array<double, 3> square_sum_m2{};
  double worst_m = 0.0;
  std::uint32_t worst = 0;
  for (const std::uint32_t point : PointsCounted(planned.block, predicted.points)) {
    const auto track = TrackAt(planned.block, point, planned.truth.points_m[point]);
    if (!track) continue;
    const auto all_m2 = AlongAcrossUp(predicted.points.covariance_m2[point], *track);
    for (std::size_t axis = 0; axis < all_m2.size(); ++axis) {
      sigmas_m[axis].push_back(std::sqrt(all_m2[axis]));
      square_sum_m2[axis] += all_m2[axis];
    }
    if (!by_looks_m2.empty()) {  // there are corrections
      const auto looks_m2 = AlongAcrossUp(by_looks_m2[point], *track);
      for (std::size_t axis = 0; axis < all_m2.size(); ++axis) {
        path_sigmas_m[axis].push_back(std::sqrt(std::max(0.0, all_m2[axis] - looks_m2[axis])));
      }
    }
    if (sigmas_m[2].back() > worst_m) {
      worst_m = sigmas_m[2].back();
      worst = point;
    }
  }
  if (sigmas_m[0].empty()) throw UndeterminedError("no point but control is determined", {});
  row->Set("worst_point", std::string(planned.block.points.ids[worst]))
      .Count("points", sigmas_m[0].size());
  for (std::size_t axis = 0; axis < kDesignDirections.size(); ++axis) {
    const auto set = [&](const std::string& name, const std::vector<double>& values_m) {
      if (values_m.empty()) return;
      row->Set("max_" + name, *std::max_element(values_m.begin(), values_m.end()))
          .Set("median_" + name, MedianOf(values_m));
    };
    set(fmt::format("sigma_{}_m", kDesignDirections[axis]), sigmas_m[axis]);
    set(fmt::format("path_sigma_{}_m", kDesignDirections[axis]), path_sigmas_m[axis]);
    row->Set(fmt::format("rms_sigma_{}_m", kDesignDirections[axis]),
             std::sqrt(square_sum_m2[axis] / static_cast<double>(sigmas_m[axis].size())));
  }
}

/// Sets the figures of differences of points about as far apart as asked: the worse of pairs along
/// and across the track.
void SetDifferences(const std::vector<DifferenceClass>& differences,
                    double distance_m,
                    StudyRowMaker* row) {
  std::array<double, 4> worst{};  // distance, along, across, up
  for (const bool along : {true, false}) {
    const DifferenceClass* nearest = nullptr;
    const auto off = [&](const DifferenceClass& of) {
      return std::abs(std::log(of.distance_m / distance_m));
    };
    for (const DifferenceClass& of : differences) {
      if (of.along != along || (nearest != nullptr && off(of) >= off(*nearest))) continue;
      nearest = &of;
    }
    if (nearest == nullptr || off(*nearest) > std::log(2.0)) continue;
    worst = {std::max(worst[0], nearest->distance_m),
             std::max(worst[1], nearest->sigma_along_m),
             std::max(worst[2], nearest->sigma_across_m),
             std::max(worst[3], nearest->sigma_up_m)};
  }
  if (worst[0] == 0.0) {
    throw InputError("goal.difference_m",
                     fmt::format("no points of the block are about {:g} m apart, a distance within "
                                 "it is allowed",
                                 distance_m));
  }
  row->Set("difference_m", worst[0])
      .Set("difference_sigma_along_m", worst[1])
      .Set("difference_sigma_across_m", worst[2])
      .Set("difference_sigma_up_m", worst[3]);
}

/// Draws the case and compares errors along, across and up.
Verification VerifyDesign(const DesignStudy& study,
                          std::size_t index,
                          const SimulatedBlock& planned,
                          const AdjustOptions& options,
                          const AdjustResult& predicted,
                          ProgressSink* progress) {
  return Verify(SceneToDraw(study.cases[index], study.verify),
                planned,
                options,
                predicted,
                study.verify.runs,
                MixStream(study.heading.seed, index),
                study.verify.LevelOfOne(study.cases.size()),
                progress,
                [&](std::uint32_t point) {
                  const auto track = TrackAt(planned.block, point, planned.truth.points_m[point]);
                  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
                  if (!track) return axes;
                  axes.topLeftCorner<2, 2>() << track->x(), track->y(), -track->y(), track->x();
                  return axes;
                });
}

void SetCost(const DesignPrices& prices, const Block& block, StudyRowMaker* row) {
  const auto control = static_cast<std::size_t>(
      std::count(block.points.role.begin(), block.points.role.end(), PointRole::kControl));
  const double flight_km = 1e-3 * FlightLength_m(block);
  const std::size_t points = block.points.size();
  row->Count("passes", block.passes.size())
      .Count("control_points", control)
      .Set("looks_per_point", static_cast<double>(block.looks.size()) / static_cast<double>(points))
      .Set("flight_km", flight_km);
  if (!prices.Given()) return;
  row->Set("cost",
           prices.pass * static_cast<double>(block.passes.size()) + prices.kilometre * flight_km +
               prices.control_point * static_cast<double>(control));
}

/// The value of a column of a row of design.csv; NaN where it is empty.
double ValueOf(const StudyRow& row, std::string_view column) {
  return StudyTable(DesignColumns(), {row}).Number(0, column);
}

bool ReachesAll(const std::vector<DesignGoal>& goals, const StudyRow& row) {
  return std::all_of(goals.begin(), goals.end(), [&](const DesignGoal& goal) {
    return ValueOf(row, goal.column) <= goal.limit;
  });
}

std::vector<StudyRow> ComputeDesign(const DesignStudy& study,
                                    std::size_t index,
                                    ProgressSink* progress) {
  StudyRowMaker row(DesignColumns());
  const std::vector<std::size_t> place = DesignPlaces(study, index);
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    const std::string end = "_" + std::to_string(axis + 1);
    const CaseChoice& choice = study.choices[axis][place[axis]];
    row.Set("axis" + end, study.axes[axis].name)
        .Set("value" + end, choice.value)
        .Set("number" + end, choice.number);
  }
  row.Set("traded", DesignQuantity(study));
  const StudyCase& of = study.cases[index];
  AdjustOptions options = of.adjust;
  options.threads = AvailableCores();  // all that the caller may use
  options.covariance = CovarianceLevel::kBlock;
  if (!std::isnan(study.difference_m)) options.pairs = PairChoice::kDistances;
  try {
    const SimulatedBlock planned = PlannedBlock(of.scene);
    SetCost(study.prices, planned.block, &row);
    const AdjustResult predicted = Predict(planned.block, options, planned.truth.points_m);
    SetSigmas(planned, predicted, &row);
    if (!std::isnan(study.difference_m)) {
      SetDifferences(predicted.assessment.differences, study.difference_m, &row);
    }
    row.Set("redundancy", predicted.redundancy()).Count("determined", 1);
    if (study.verify.Covers(index)) {
      SetVerification(VerifyDesign(study, index, planned, options, predicted, progress),
                      {kDesignDirections[0], kDesignDirections[1], kDesignDirections[2]},
                      &row);
    }
  } catch (const UndeterminedError& error) {
    row.Count("determined", 0).Message(error.what());
  } catch (const InputError& error) {  // a scene that the swept value spoils
    row.Count("determined", 0).Message(error.what());
  }
  if (!study.goals.empty()) row.Count("reached", ReachesAll(study.goals, row.row()) ? 1 : 0);
  return {row.row()};
}

}  // namespace

StudyPlan PlanDesign(const DesignStudy& study) {
  StudyPlan plan;
  plan.columns = DesignColumns();
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    plan.tasks.push_back({study.cases[i].variant, [&study, i](ProgressSink* progress) {
                            return ComputeDesign(study, i, progress);
                          }});
  }
  return plan;
}

std::string DesignQuantity(const DesignStudy& study) {
  for (const char* column : {"max_sigma_up_m",
                             "max_sigma_across_m",
                             "max_sigma_along_m",
                             "median_sigma_up_m",
                             "median_sigma_across_m",
                             "median_sigma_along_m"}) {
    const auto wanted = [column](const DesignGoal& goal) { return goal.column == column; };
    if (std::any_of(study.goals.begin(), study.goals.end(), wanted)) return column;
  }
  return "max_sigma_up_m";
}

StudyTable MarkPareto(const DesignStudy& study, const StudyTable& table) {
  std::vector<StudyRow> rows = table.rows();
  if (!study.prices.Given()) return table;
  const std::string quantity = DesignQuantity(study);
  const std::size_t column = static_cast<std::size_t>(
      std::find_if(table.columns().begin(),
                   table.columns().end(),
                   [](const StudyColumn& known) { return known.name == "pareto"; }) -
      table.columns().begin());
  // By cost, the more accurate first: what is no more accurate than a cheaper one is beaten.
  struct Case {
    double cost, sigma;
    std::size_t row;
  };
  std::vector<Case> determined;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    rows[row][column] = std::int64_t{0};
    if (!IsDetermined(table, row)) continue;
    determined.push_back({table.Number(row, "cost"), table.Number(row, quantity), row});
  }
  std::sort(determined.begin(), determined.end(), [](const Case& a, const Case& b) {
    return std::tie(a.cost, a.sigma) < std::tie(b.cost, b.sigma);
  });
  double best_sigma = std::numeric_limits<double>::infinity(), best_cost = best_sigma;
  for (const Case& of : determined) {
    const bool equal = of.sigma == best_sigma && of.cost == best_cost;
    if (!(of.sigma < best_sigma) && !equal) continue;
    best_sigma = of.sigma;
    best_cost = of.cost;
    rows[of.row][column] = std::int64_t{1};
  }
  return {table.columns(), std::move(rows)};
}

// ---- the words

namespace {

/// "worst point up", "median across", "cost".
std::string PhraseOf(const std::string& column) {
  if (column == "cost") return "cost";
  const bool median = column.starts_with("median_");
  const std::size_t begin = column.find("sigma_") + 6;
  const std::string axis = column.substr(begin, column.size() - begin - 2);
  if (column.starts_with("difference_")) return "difference " + axis;
  return (median ? "median " : "worst point ") + axis;
}

std::string UnitOf(const DesignStudy& study, const std::string& column) {
  if (column != "cost") return " m";
  return study.prices.currency.empty() ? "" : " " + study.prices.currency;
}

/// "18.2 m", "123456 EUR".
std::string ShownValue(const DesignStudy& study, const std::string& column, double value) {
  return Digits(value, column == "cost" ? 8 : 3) + UnitOf(study, column);
}

std::string CaseName(const DesignStudy& study, std::size_t index) {
  const std::vector<std::size_t> place = DesignPlaces(study, index);
  std::string name;
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    name += (axis == 0 ? "" : ", ") + study.axes[axis].name + " " +
            study.axes[axis].values[place[axis]];
  }
  return name;
}

/// A cell of a matrix, with a star where all goals are reached.
std::string Cell(const StudyTable& table, std::size_t row, const std::string& column) {
  if (!IsDetermined(table, row)) return "-";
  const double value = table.Number(row, column);
  return Digits(value, column == "cost" ? 6 : 3) +
         (table.Number(row, "reached") == 1.0 ? "*" : " ");
}

constexpr std::size_t kLine = 80, kCell = 8;

std::size_t LabelWidth(const DesignAxis& axis) {
  std::size_t width = axis.name.size();
  for (const std::string& value : axis.values) width = std::max(width, value.size());
  return std::min<std::size_t>(width, 30);
}

/// All sigmas of one axis, a line a value.
void AddTable(const DesignStudy& study, const StudyTable& table, std::vector<std::string>* words) {
  const DesignAxis& axis = study.axes.front();
  const std::size_t width = LabelWidth(axis);
  const bool cost = study.prices.Given();
  words->push_back(fmt::format(
      "{:<{}}{:>{}}{:>{}}", "sigma [m]", width, "median", 3 * kCell, "worst point", 3 * kCell));
  std::string head = fmt::format("{:<{}}", axis.name, width);
  for (std::size_t i = 0; i < 6; ++i) {
    head += fmt::format("{:>{}}", std::array{"along", "across", "up"}[i % 3], kCell);
  }
  if (cost) head += fmt::format("{:>{}}", "cost", kCell + 1);
  words->push_back(std::move(head));
  for (std::size_t row = 0; row < table.size(); ++row) {
    std::string line = fmt::format("{:<{}}", axis.values[row], width);
    for (std::size_t i = 0; i < 6; ++i) {
      const double value = table.Number(row, kGoalColumns[i]);
      line += fmt::format("{:>{}}", std::isnan(value) ? "-" : Digits(value, 3), kCell);
    }
    if (cost) line += fmt::format("{:>{}}", Digits(table.Number(row, "cost"), 8), kCell + 1);
    words->push_back(line + (table.Number(row, "reached") == 1.0 ? " *" : ""));
  }
}

/// One quantity by two axes, as many columns side by side as a terminal shows.
void AddMatrix(const DesignStudy& study, const StudyTable& table, std::vector<std::string>* words) {
  const DesignAxis &down = study.axes[0], &right = study.axes[1];
  const std::string quantity = DesignQuantity(study);
  words->push_back(
      fmt::format("{} [m] by {} (down) and {} (right)", PhraseOf(quantity), down.name, right.name));
  std::size_t width = 0, cell = kCell;
  for (const std::string& value : down.values) width = std::max(width, value.size());
  for (const std::string& value : right.values) cell = std::max(cell, value.size() + 3);
  width = std::min<std::size_t>(width, 30);
  const std::size_t columns = std::max<std::size_t>(1, (kLine - width) / cell);
  for (std::size_t first = 0; first < right.values.size(); first += columns) {
    const std::size_t last = std::min(first + columns, right.values.size());
    std::string head(width, ' ');
    for (std::size_t j = first; j < last; ++j) {
      head += fmt::format("{:>{}}{}", right.values[j], cell - 1, j + 1 < last ? " " : "");
    }
    words->push_back(std::move(head));
    for (std::size_t i = 0; i < down.values.size(); ++i) {
      std::string line = fmt::format("{:<{}}", down.values[i], width);
      for (std::size_t j = first; j < last; ++j) {
        line += fmt::format("{:>{}}", Cell(table, i * right.values.size() + j, quantity), cell);
      }
      line.erase(line.find_last_not_of(' ') + 1);
      words->push_back(std::move(line));
    }
  }
}

/// How far a case is from the goals, 1 or less where it reaches them.
double DesignExcess(const DesignStudy& study, const StudyTable& table, std::size_t row) {
  double excess = 0.0;
  for (const DesignGoal& goal : study.goals) {
    excess = std::max(excess, table.Number(row, goal.column) / goal.limit);
  }
  return excess;
}

/// "worst point up 20.1 m, goal 20 m: missed".
std::string Verdict(const DesignStudy& study,
                    const StudyTable& table,
                    std::size_t row,
                    const DesignGoal& goal) {
  const double value = table.Number(row, goal.column);
  const bool reached = value <= goal.limit;
  // A miss must not read as equal to the goal.
  std::string shown = ShownValue(study, goal.column, value);
  const std::string limit = ShownValue(study, goal.column, goal.limit);
  if (!reached && shown == limit) shown = Digits(value, 8) + UnitOf(study, goal.column);
  return fmt::format(
      "{} {}, goal {}: {}", PhraseOf(goal.column), shown, limit, reached ? "reached" : "missed");
}

void DescribeGoals(const DesignStudy& study,
                   const StudyTable& table,
                   std::vector<std::string>* words) {
  if (study.goals.empty()) return;
  std::optional<std::size_t> cheapest, nearest;
  std::size_t reached = 0;
  // Without prices the first of the cases that reach all goals with the worst accuracy is named:
  // what is no better than it has to be.
  const auto price = [&](std::size_t row) {
    return study.prices.Given() ? table.Number(row, "cost") : -DesignExcess(study, table, row);
  };
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (!IsDetermined(table, row)) continue;
    if (!nearest || DesignExcess(study, table, row) < DesignExcess(study, table, *nearest))
      nearest = row;
    if (table.Number(row, "reached") != 1.0) continue;
    ++reached;
    if (!cheapest || price(row) < price(*cheapest)) cheapest = row;
  }
  if (!nearest) {
    words->push_back("no case of the study is determined");
    return;
  }
  const std::size_t shown = cheapest ? *cheapest : *nearest;
  std::string text =
      cheapest
          ? fmt::format("{} of {} cases reach all goals; {} is {}",
                        reached,
                        table.size(),
                        study.prices.Given() ? "the cheapest" : "the one that just does",
                        CaseName(study, shown))
          : fmt::format("no case reaches all goals; the nearest is {}", CaseName(study, shown));
  for (const DesignGoal& goal : study.goals) {
    text += (&goal == &study.goals.front() ? ": " : "; ") + Verdict(study, table, shown, goal);
  }
  words->push_back(std::move(text));
}

/// The case with the best of the quantity that is traded.
void DescribeBest(const DesignStudy& study,
                  const StudyTable& table,
                  std::vector<std::string>* words) {
  const std::string quantity = DesignQuantity(study);
  std::optional<std::size_t> best;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (!IsDetermined(table, row)) continue;
    if (!best || table.Number(row, quantity) < table.Number(*best, quantity)) best = row;
  }
  if (!best) return;
  words->push_back(fmt::format("the best, {} {}, is {}",
                               PhraseOf(quantity),
                               ShownValue(study, quantity, table.Number(*best, quantity)),
                               CaseName(study, *best)));
}

void AddPareto(const DesignStudy& study,
               const StudyTable& marked,
               std::vector<std::string>* words) {
  if (!study.prices.Given()) return;
  const std::string quantity = DesignQuantity(study);
  std::vector<std::size_t> best;
  for (std::size_t row = 0; row < marked.size(); ++row) {
    if (marked.Number(row, "pareto") == 1.0) best.push_back(row);
  }
  std::stable_sort(best.begin(), best.end(), [&](std::size_t a, std::size_t b) {
    return marked.Number(a, "cost") < marked.Number(b, "cost");
  });
  words->push_back(fmt::format("nothing is cheaper and better ({}) than:", PhraseOf(quantity)));
  for (const std::size_t row : best) {
    words->push_back(fmt::format("    {:>14}   {:>8}   {}",
                                 ShownValue(study, "cost", marked.Number(row, "cost")),
                                 ShownValue(study, quantity, marked.Number(row, quantity)),
                                 CaseName(study, row)));
  }
}

}  // namespace

std::vector<std::string> DesignTables(const DesignStudy& study, const StudyTable& table) {
  std::vector<std::string> lines;
  if (study.axes.size() == 1) {
    AddTable(study, table, &lines);
  } else {
    AddMatrix(study, table, &lines);
  }
  if (!study.goals.empty()) lines.emplace_back("*: reaches all goals");
  AddPareto(study, table, &lines);
  return lines;
}

std::vector<std::string> DescribeDesign(const DesignStudy& study, const StudyTable& table) {
  std::vector<std::string> words;
  DescribeGoals(study, table, &words);
  DescribeBest(study, table, &words);
  std::size_t lost = 0;
  for (std::size_t row = 0; row < table.size(); ++row) lost += IsDetermined(table, row) ? 0U : 1U;
  if (lost > 0) {
    words.push_back(
        fmt::format("{} of {} cases give no block that is determined; see the column message",
                    lost,
                    table.size()));
  }
  for (std::string& sentence : DescribeVerification(
           study.verify, table, [&](std::size_t row) { return CaseName(study, row); })) {
    words.push_back(std::move(sentence));
  }
  return words;
}

}  // namespace sarblock
