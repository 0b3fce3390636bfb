// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "cases.h"
#include "densification.h"
#include "study.h"
#include "tables/toml.h"

namespace sarblock {
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
