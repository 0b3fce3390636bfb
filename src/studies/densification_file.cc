// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <variant>

#include "cases.h"
#include "densification.h"
#include "model/priors.h"
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

VerificationOptions ReadVerification(SceneTable& table) {
  using Navigation = VerificationOptions::Navigation;
  VerificationOptions verify;
  if (const auto runs = table.Take("runs")) verify.runs = runs->Integer(0, 1000000);
  table.Count("every", &verify.every);
  if (verify.every == 0) throw InputError(table.PlaceOf("every"), "must be 1 at least");
  table.Number("level", &verify.level);
  if (!(verify.level > 0.0 && verify.level < 1.0)) {
    throw InputError(table.PlaceOf("level"), "must lie between 0 and 1");
  }
  table.Choice<Navigation>("navigation",
                           {{"priors", Navigation::kPriors}, {"scene", Navigation::kScene}},
                           &verify.navigation);
  table.Finish();
  return verify;
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
  if (out.study.verify.navigation == VerificationOptions::Navigation::kPriors) {
    for (std::size_t i = 0; i < out.study.cases.size(); i += out.study.verify.every) {
      if (out.study.verify.runs == 0) break;
      static_cast<void>(
          NavigationFromPriors(out.study.cases[i].adjust, out.study.cases[i].scene.navigation));
    }
  }
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

[[noreturn]] void Refuse(const CorrectionGroup& group, const std::string& why) {
  throw InputError("verify.navigation",
                   "'priors' cannot draw the corrections '" + group.name + "' (" + why +
                       "); 'scene' draws the scene's [navigation]");
}

/// Prior, or what the scene has where there is none.
double Or(double prior, double scene) { return std::isnan(prior) ? scene : prior; }

void Take(const CorrectionGroup& group,
          const PositionCorrection& position,
          const SceneNavigation& scene,
          SceneNavigation* drawn) {
  using Process = PositionCorrection::Process;
  if (position.basis == PositionCorrection::Basis::kSpline) {
    if (position.process == Process::kWhite) Refuse(group, "splines of independent coefficients");
    if (drawn->process != SceneNavigation::Process::kNone) Refuse(group, "several splines");
  }
  if (position.axes != PositionCorrection::Axes::kTrack) Refuse(group, "frame axes");
  if (position.degree > 2) Refuse(group, "a degree above 2");
  if (group.shared) Refuse(group, "shared by passes");
  const std::array<std::array<double, 3> SceneNavigation::*, 3> members = {
      &SceneNavigation::constant_sigma_m,
      &SceneNavigation::drift_sigma_m,
      &SceneNavigation::curvature_sigma_m};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!position.components[axis]) continue;
    const std::vector<double>& prior = position.prior_sigma_m[axis];
    if (position.basis == PositionCorrection::Basis::kSpline) {
      const bool walk = position.process == Process::kRandomWalk;
      drawn->process =
          walk ? SceneNavigation::Process::kRandomWalk : SceneNavigation::Process::kGaussMarkov;
      drawn->knot_spacing_s = position.knot_spacing_s;
      drawn->correlation_time_s = position.correlation_time_s;
      drawn->process_sigma_m[axis] = prior.empty() ? scene.process_sigma_m[axis] : prior.front();
      // A walk that starts anywhere is one from zero and a constant.
      if (walk && !prior.empty()) drawn->constant_sigma_m[axis] = position.start_sigma_m[axis];
      continue;
    }
    for (std::size_t degree = 0; degree <= static_cast<std::size_t>(position.degree); ++degree) {
      const double sigma_m = prior.empty()       ? kNotGiven
                             : prior.size() == 1 ? prior[0]
                                                 : prior[degree];
      (drawn->*members[degree])[axis] = Or(sigma_m, (scene.*members[degree])[axis]);
    }
  }
}

/// Which of the corrections that are not shared have joint priors, in the order of the groups.
std::set<int> JointParameters(const AdjustOptions& options) {
  const JointPriorBindings bindings = BindJointPriors({"pass"}, options.groups, options.priors);
  for (const JointPrior& prior : options.priors) {
    if (prior.passes.empty()) continue;
    throw InputError("verify.navigation",
                     "'priors' cannot draw " + KeyOf(prior) +
                         " (single passes); 'scene' draws the scene's [navigation]");
  }
  if (bindings.problem) throw InputError("adjust.prior", bindings.problem->problem);
  std::set<int> joint;
  for (const JointPriorBinding& binding : bindings.bound) {
    joint.insert(binding.parameters.begin(), binding.parameters.end());
  }
  return joint;
}

}  // namespace

SceneNavigation NavigationFromPriors(const AdjustOptions& options, const SceneNavigation& scene) {
  SceneNavigation drawn;
  drawn.shared_biases = scene.shared_biases;
  if (options.corrections != CorrectionChoice::kGiven) return drawn;
  drawn.joint = options.priors;
  const std::set<int> joint = JointParameters(options);
  int next = 0;  // parameter that is not shared
  for (const CorrectionGroup& group : options.groups) {
    if (!group.passes.empty()) Refuse(group, "single passes");
    if (!group.shared) {
      const auto parameters = static_cast<int>(ParametersOf(group).size());
      const auto of_joint =
          std::distance(joint.lower_bound(next), joint.lower_bound(next + parameters));
      next += parameters;
      if (of_joint > 0 && of_joint == parameters) continue;
      if (of_joint > 0) Refuse(group, "a joint prior for a part of its parameters");
    }
    if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
      Take(group, *position, scene, &drawn);
      continue;
    }
    if (group.shared != scene.shared_biases) {
      Refuse(group, "shared where navigation.shared_biases is not, or the other way round");
    }
    if (const auto* range = std::get_if<RangeCorrection>(&group.model)) {
      if (range->bias) {
        drawn.range_bias_sigma_m = Or(range->bias_prior_sigma_m, scene.range_bias_sigma_m);
      }
      if (range->scale) {
        drawn.range_scale_sigma = Or(range->scale_prior_sigma, scene.range_scale_sigma);
      }
    } else if (const auto* time = std::get_if<TimeCorrection>(&group.model)) {
      drawn.time_bias_sigma_s = Or(time->bias_prior_sigma_s, scene.time_bias_sigma_s);
    } else if (const auto* squint = std::get_if<SquintCorrection>(&group.model)) {
      drawn.squint_bias_sigma_rad = Or(squint->bias_prior_sigma_rad, scene.squint_bias_sigma_rad);
    } else {
      Refuse(group, "velocity or troposphere");
    }
  }
  return drawn;
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
  return count == 0   ? "no control at all"
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

/// One sentence a variant: the fewest points that reach the goal, of several layouts the best.
void DescribeGoal(const DensificationStudy& study,
                  const StudyTable& table,
                  std::vector<std::string>* words) {
  const DensificationGoal& goal = study.goal;
  if (std::isnan(goal.sigma_h_m) && std::isnan(goal.sigma_u_m)) return;
  std::vector<std::string> variants;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string variant = table.Text(row, "variant");
    if (!IsPlacement(table, row) &&
        std::find(variants.begin(), variants.end(), variant) == variants.end()) {
      variants.push_back(variant);
    }
  }
  for (const std::string& variant : variants) {
    std::optional<std::size_t> fewest, nearest;
    const auto excess = [&](std::size_t row) { return Excess(goal, ReachedBy(goal, table, row)); };
    const auto points = [&](std::size_t row) { return table.Number(row, "control_points"); };
    for (std::size_t row = 0; row < table.size(); ++row) {
      if (IsPlacement(table, row) || !IsDetermined(table, row)) continue;
      if (table.Text(row, "variant") != variant) continue;
      if (!nearest || excess(row) < excess(*nearest)) nearest = row;
      if (excess(row) > 1.0) continue;
      if (!fewest || points(row) < points(*fewest) ||
          (points(row) == points(*fewest) && excess(row) < excess(*fewest))) {
        fewest = row;
      }
    }
    const std::string begin = variant.empty() ? "" : variant + ": ";
    if (fewest) {
      const Reached reached = ReachedBy(goal, table, *fewest);
      words->push_back(begin + ControlOf(table, *fewest) +
                       (points(*fewest) > 1.0 ? " reach " : " reaches ") + Describe(goal) + " (" +
                       Metres(reached.sigma_h_m) + ", " + Metres(reached.sigma_u_m) +
                       "), no smaller layout of the study does");
    } else if (nearest) {
      const Reached reached = ReachedBy(goal, table, *nearest);
      words->push_back(begin + "no layout of the study reaches " + Describe(goal) +
                       "; the nearest is " + ControlOf(table, *nearest) + " with " +
                       Metres(reached.sigma_h_m) + " and " + Metres(reached.sigma_u_m));
    } else {
      words->push_back(begin + "no layout of the study determines the block");
    }
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

void DescribeVerification(const DensificationStudy& study,
                          const StudyTable& table,
                          std::vector<std::string>* words) {
  std::size_t verified = 0, agree = 0;
  double least = 1e300, most = 0.0;
  std::string not_agreeing;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (std::isnan(table.Number(row, "agrees"))) continue;
    ++verified;
    least = std::fmin(least, table.Number(row, "nees"));
    most = std::fmax(most, table.Number(row, "nees"));
    if (table.Number(row, "agrees") == 1.0) {
      ++agree;
    } else {
      not_agreeing += "; not " + ControlOf(table, row) + " " + table.Text(row, "variant") + " (" +
                      Figure(table.Number(row, "nees")) + ", allowed " +
                      Figure(table.Number(row, "nees_lower")) + " to " +
                      Figure(table.Number(row, "nees_upper")) + ")";
    }
  }
  if (verified == 0) return;
  words->push_back("Monte Carlo agrees with the prediction in " + std::to_string(agree) + " of " +
                   std::to_string(verified) + " verified rows, " +
                   std::to_string(study.verify.runs) + " runs each: normalised errors squared " +
                   Figure(least) + " to " + Figure(most) + not_agreeing);
}

}  // namespace

std::vector<std::string> DescribeDensification(const DensificationStudy& study,
                                               const StudyTable& table) {
  std::vector<std::string> words;
  DescribeGoal(study, table, &words);
  DescribePlacements(table, &words);
  DescribeVerification(study, table, &words);
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
