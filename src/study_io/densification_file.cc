// SPDX-License-Identifier: Apache-2.0
#include "study_io/densification_file.h"

#include "sarblock/files/adjust_options.h"
#include "sarblock/files/scene_file.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "study_file.h"
#include "tables/toml.h"

namespace sarblock {
namespace {

/// What one value of an axis, or a listed case, changes in the scene.
struct Choice {
  std::string label;  ///< empty: not told (control layout and count have columns of their own)
  std::optional<std::string> scene;
  std::optional<std::vector<std::string>> flights;
  std::vector<std::string> set;
  FilePlace place;

  /// The other's changes after these.
  void Add(const Choice& other) {
    if (!other.label.empty()) label += (label.empty() ? "" : ", ") + other.label;
    if (other.scene) scene = other.scene;
    if (other.flights) flights = other.flights;
    set.insert(set.end(), other.set.begin(), other.set.end());
    place = other.place;
  }
};

std::vector<std::string> TakeTexts(const std::string& key, SceneTable* table) {
  std::vector<std::string> texts;
  if (const auto taken = table->Take(key)) {
    for (const TomlValue& entry : taken->Entries()) texts.push_back(entry.Text());
  }
  return texts;
}

/// `set`, `scene` and `flights` of a table.
Choice TakeChanges(SceneTable* table) {
  Choice choice;
  choice.place = table->PlaceOf("set");
  if (const auto set = table->Take("set")) {
    choice.place = set->Place();
    for (const TomlValue& entry : set->Entries()) {
      choice.set.push_back(entry.Text());
      if (choice.set.back().find_first_of("\r\n") != std::string::npos) {
        entry.Fail("must be KEY=VALUE on one line");
      }
    }
  }
  std::string scene;
  table->Text("scene", &scene);
  if (!scene.empty()) choice.scene = scene;
  if (table->Has("flights")) choice.flights = TakeTexts("flights", table);
  return choice;
}

/// A TOML value as text on the right of `=`.
std::string ValueText(const TomlValue& value) {
  std::ostringstream stream;
  toml::table holder;
  value.node().visit([&holder](const auto& node) { holder.insert("v", node); });
  if (toml::table* inner = holder.get("v")->as_table()) inner->is_inline(true);
  stream << holder;
  const std::string text = stream.str();
  return text.substr(text.find('=') + 1);
}

/// The values of one [[axis]].
std::vector<Choice> ReadAxis(SceneTable table) {
  std::string name, key;
  table.Text("key", &key);
  name = key;
  table.Text("name", &name);
  const bool own_columns = key == "control.layout" || key == "control.count";
  const bool labelled = table.Has("labels");
  const std::vector<std::string> labels = TakeTexts("labels", &table);
  std::vector<Choice> choices;
  if (const auto values = table.Take("values")) {
    if (key.empty()) throw InputError(table.PlaceOf("key"), "must be given beside values");
    for (const TomlValue& value : values->Entries()) {
      Choice choice;
      choice.place = value.Place();
      const std::string text = ValueText(value);
      choice.set.push_back(key + "=" + text);
      if (labelled && choices.size() < labels.size()) {
        choice.label = labels[choices.size()];
      } else if (!own_columns) {
        const std::string shown = value.IsText() ? value.Text() : text;
        choice.label =
            name + " " + shown.substr(std::min(shown.find_first_not_of(' '), shown.size()));
      }
      choices.push_back(std::move(choice));
    }
    if (labelled && labels.size() != choices.size()) {
      throw InputError(table.PlaceOf("labels"), "must be as many as values");
    }
  } else if (labelled) {
    throw InputError(table.PlaceOf("labels"), "stand beside values only; a case has a name");
  }
  for (SceneTable& entry : table.Tables("case")) {
    std::string label;
    entry.Text("name", &label);
    if (label.empty()) throw InputError(entry.PlaceOf("name"), "must be given");
    Choice choice = TakeChanges(&entry);
    choice.label = label;
    entry.Finish();
    choices.push_back(std::move(choice));
  }
  table.Finish();
  if (choices.empty()) throw InputError(table.PlaceOf("values"), "must not be empty");
  return choices;
}

const char* NameOf(SceneControl::Layout layout) {
  using Layout = SceneControl::Layout;
  switch (layout) {
    case Layout::kNone:
      return "none";
    case Layout::kCorners:
      return "corners";
    case Layout::kPerimeter:
      return "perimeter";
    case Layout::kGrid:
      return "grid";
    case Layout::kChain:
      return "chain";
    case Layout::kRandom:
      return "random";
    case Layout::kPlaces:
      break;
  }
  return "places";
}

/// Makes cases of choices: reads each scene once, applies the overrides, checks.
class CaseMaker {
 public:
  CaseMaker(std::string file, std::function<std::string(const std::string&)> scene_text)
      : file_(std::move(file)), scene_text_(std::move(scene_text)) {}

  [[nodiscard]] const std::map<std::string, std::string>& texts() const { return texts_; }

  DensificationCase Make(const Choice& choice) {
    try {
      return MakeUnnamed(choice);
    } catch (const InputError& error) {
      FilePlace place = choice.place;
      place.file = file_;
      throw InputError(place,
                       "cannot be applied" +
                           (choice.label.empty() ? "" : " (" + choice.label + ")") + ": " +
                           error.what());
    }
  }

 private:
  DensificationCase MakeUnnamed(const Choice& choice) {
    if (!choice.scene) throw InputError("scene", "must be given, the path of a scene file");
    auto found = texts_.find(*choice.scene);
    if (found == texts_.end()) {
      found = texts_.emplace(*choice.scene, scene_text_(*choice.scene)).first;
    }
    DensificationCase made;
    made.variant = choice.label;
    made.scene = ParseScene(found->second, *choice.scene, choice.set);
    if (choice.flights) KeepFlights(*choice.flights, &made.scene);
    made.layout = NameOf(made.scene.control.layout);
    std::vector<std::string> passes;
    for (const SceneFlight& flight : made.scene.flights) {
      for (std::size_t p = 0; p < flight.count * flight.segments; ++p) {
        passes.push_back(PassId(flight, p / flight.segments, p % flight.segments));
      }
    }
    made.adjust = ReadAdjustTable(made.scene.adjust_toml, *choice.scene, passes);
    if (made.adjust.corrections == CorrectionChoice::kAuto) {
      throw InputError("adjust.corrections", "'auto' needs measured values; 'given' is allowed");
    }
    if (made.adjust.covariance_method == CovarianceMethod::kCeres) {
      throw InputError("adjust.covariance_method", "'ceres' is not offered in a study");
    }
    return made;
  }

  static void KeepFlights(const std::vector<std::string>& ids, Scene* scene) {
    std::vector<SceneFlight> kept;
    for (const std::string& id : ids) {
      const auto found = std::find_if(scene->flights.begin(),
                                      scene->flights.end(),
                                      [&](const SceneFlight& flight) { return flight.id == id; });
      if (found == scene->flights.end()) {
        throw InputError("flights", "'" + id + "' is no flight of the scene");
      }
      kept.push_back(*found);
      scene->flights.erase(found);  // a second time it is unknown
    }
    if (kept.empty()) throw InputError("flights", "must name one at least");
    scene->flights = std::move(kept);
  }

  std::string file_;
  std::function<std::string(const std::string&)> scene_text_;
  std::map<std::string, std::string> texts_;
};

/// The product of the axes, the last one fastest.
std::vector<Choice> Product(const Choice& base,
                            const std::vector<std::vector<Choice>>& axes,
                            const FilePlace& place) {
  std::vector<Choice> cases = {base};
  for (const std::vector<Choice>& axis : axes) {
    if (cases.size() * axis.size() > kMostStudyCases) {
      throw InputError(place,
                       "give more than " + std::to_string(kMostStudyCases) +
                           " cases together, fewer are allowed");
    }
    std::vector<Choice> longer;
    for (const Choice& first : cases) {
      for (const Choice& second : axis) {
        longer.push_back(first);
        longer.back().Add(second);
      }
    }
    cases = std::move(longer);
  }
  return cases;
}

/// "control.count=9" of a choice, the last one; nothing where it is not set.
std::optional<std::string> LastSet(const Choice& choice, const std::string& key) {
  for (auto entry = choice.set.rbegin(); entry != choice.set.rend(); ++entry) {
    if (entry->starts_with(key + "=")) return entry->substr(key.size() + 1);
  }
  return std::nullopt;
}

/// Corners with more than four points: a place of the product where there is no layout.
bool IsNoLayout(const Choice& choice) {
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

PlacementCase ReadPlacement(SceneTable table, Choice base, CaseMaker* maker) {
  PlacementCase placement = ReadPlacementKeys(&table);
  for (const double sigma_m : placement.sigma_m) {
    if (!(sigma_m > 0.0)) {
      throw InputError(table.PlaceOf("sigma_m"), "must be given, three positive numbers");
    }
  }
  std::string name;
  table.Text("name", &name);
  Choice choice = TakeChanges(&table);
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
  const Choice base = TakeChanges(&table);
  std::vector<std::vector<Choice>> axes;
  for (SceneTable& axis : table.Tables("axis")) axes.push_back(ReadAxis(std::move(axis)));
  std::vector<Choice> choices;
  if (!axes.empty()) choices = Product(base, axes, table.PlaceOf("axis"));
  for (SceneTable& listed : table.Tables("case")) {
    std::string name;
    listed.Text("name", &name);
    Choice choice = TakeChanges(&listed);
    choice.label = name;
    listed.Finish();
    choices.push_back(base);
    choices.back().Add(choice);
  }
  CaseMaker maker(file, scene_text);
  std::set<std::pair<std::string, std::string>> without_control;
  for (const Choice& choice : choices) {
    if (IsNoLayout(choice)) continue;
    DensificationCase made = maker.Make(choice);
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

}  // namespace sarblock
