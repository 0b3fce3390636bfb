// SPDX-License-Identifier: Apache-2.0
#include "cases.h"

#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "simulate/scene.h"

namespace sarblock {
namespace {

std::vector<std::string> TakeTexts(const std::string& key, SceneTable* table) {
  std::vector<std::string> texts;
  if (const auto taken = table->Take(key)) {
    for (const TomlValue& entry : taken->Entries()) texts.push_back(entry.Text());
  }
  return texts;
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

/// The number, or that of a list all of whose entries are one number; else NaN.
double NumberOf(const TomlValue& value) {
  if (value.IsNumber()) return value.Number();
  if (!value.IsArray()) return kNotGiven;
  double number = kNotGiven;
  for (const TomlValue& entry : value.Entries()) {
    if (!entry.IsNumber() || (!std::isnan(number) && entry.Number() != number)) return kNotGiven;
    number = entry.Number();
  }
  return number;
}

/// `key`, or `keys`, of an axis.
std::vector<std::string> TakeKeys(SceneTable* table) {
  std::string key;
  table->Text("key", &key);
  const auto several = table->Take("keys");
  if (!several) return key.empty() ? std::vector<std::string>() : std::vector<std::string>{key};
  if (!key.empty()) several->Fail("excludes key; give one of both");
  std::vector<std::string> keys;
  for (const TomlValue& entry : several->Entries()) keys.push_back(entry.Text());
  return keys;
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

void KeepFlights(const std::vector<std::string>& ids, Scene* scene) {
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

}  // namespace

void CaseChoice::Add(const CaseChoice& other) {
  if (!other.label.empty()) label += (label.empty() ? "" : ", ") + other.label;
  if (other.scene) scene = other.scene;
  if (other.flights) flights = other.flights;
  set.insert(set.end(), other.set.begin(), other.set.end());
  place = other.place;
}

CaseChoice TakeChanges(SceneTable* table) {
  CaseChoice choice;
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

CaseAxis ReadAxis(SceneTable table) {
  const std::vector<std::string> keys = TakeKeys(&table);
  CaseAxis axis;
  if (!keys.empty()) axis.name = keys.front();
  table.Text("name", &axis.name);
  const bool own_columns = keys == std::vector<std::string>{"control.layout"} ||
                           keys == std::vector<std::string>{"control.count"};
  const bool labelled = table.Has("labels");
  const std::vector<std::string> labels = TakeTexts("labels", &table);
  std::vector<CaseChoice>& choices = axis.choices;
  if (const auto values = table.Take("values")) {
    if (keys.empty()) throw InputError(table.PlaceOf("key"), "must be given beside values");
    for (const TomlValue& value : values->Entries()) {
      CaseChoice choice;
      choice.place = value.Place();
      choice.number = NumberOf(value);
      const std::string text = ValueText(value);
      for (const std::string& key : keys) choice.set.push_back(key + "=" + text);
      const std::string shown = value.IsText() ? value.Text() : text;
      choice.value = shown.substr(std::min(shown.find_first_not_of(' '), shown.size()));
      if (labelled && choices.size() < labels.size()) {
        choice.label = choice.value = labels[choices.size()];
      } else if (!own_columns) {
        choice.label = axis.name + " " + choice.value;
      }
      choices.push_back(std::move(choice));
    }
    if (labelled && labels.size() != choices.size()) {
      throw InputError(table.PlaceOf("labels"), "must be as many as values");
    }
  } else if (labelled) {
    throw InputError(table.PlaceOf("labels"), "go with values only; a case has a name");
  }
  for (SceneTable& entry : table.Tables("case")) {
    std::string label;
    entry.Text("name", &label);
    if (label.empty()) throw InputError(entry.PlaceOf("name"), "must be given");
    CaseChoice choice = TakeChanges(&entry);
    choice.label = choice.value = label;
    entry.Number("number", &choice.number);
    entry.Finish();
    choices.push_back(std::move(choice));
  }
  table.Finish();
  if (choices.empty()) throw InputError(table.PlaceOf("values"), "must not be empty");
  return axis;
}

std::vector<CaseChoice> Product(const CaseChoice& base,
                                const std::vector<CaseAxis>& axes,
                                const FilePlace& place) {
  std::vector<CaseChoice> cases = {base};
  for (const CaseAxis& axis : axes) {
    if (cases.size() * axis.choices.size() > kMaxStudyCases) {
      throw InputError(place,
                       "give more than " + std::to_string(kMaxStudyCases) +
                           " cases together, fewer are allowed");
    }
    std::vector<CaseChoice> longer;
    for (const CaseChoice& first : cases) {
      for (const CaseChoice& second : axis.choices) {
        longer.push_back(first);
        longer.back().Add(second);
      }
    }
    cases = std::move(longer);
  }
  return cases;
}

StudyCase CaseMaker::Make(const CaseChoice& choice) {
  try {
    return MakeUnnamed(choice);
  } catch (const InputError& error) {
    FilePlace place = choice.place;
    place.file = file_;
    throw InputError(place,
                     "cannot be applied" + (choice.label.empty() ? "" : " (" + choice.label + ")") +
                         ": " + error.what());
  }
}

StudyCase CaseMaker::MakeUnnamed(const CaseChoice& choice) {
  if (!choice.scene) throw InputError("scene", "must be given, the path of a scene file");
  auto found = texts_.find(*choice.scene);
  if (found == texts_.end()) {
    found = texts_.emplace(*choice.scene, scene_text_(*choice.scene)).first;
  }
  StudyCase made;
  made.variant = choice.label;
  made.scene = files::ParseScene(found->second, *choice.scene, choice.set);
  if (choice.flights) KeepFlights(*choice.flights, &made.scene);
  made.layout = NameOf(made.scene.control.layout);
  std::vector<std::string> passes;
  for (const SceneFlight& flight : made.scene.flights) {
    for (std::size_t p = 0; p < flight.count * flight.segments; ++p) {
      passes.push_back(PassId(flight, p / flight.segments, p % flight.segments));
    }
  }
  made.adjust = files::ReadAdjustTable(made.scene.adjust_toml, *choice.scene, passes);
  if (made.adjust.corrections == CorrectionChoice::kAuto) {
    throw InputError("adjust.corrections", "'auto' needs measured values; 'given' is allowed");
  }
  if (made.adjust.covariance_method == CovarianceMethod::kCeres) {
    throw InputError("adjust.covariance_method", "'ceres' is not offered in a study");
  }
  return made;
}

bool IsDetermined(const StudyTable& table, std::size_t row) {
  return table.Number(row, "determined") == 1.0;
}

SimulatedBlock PlannedBlock(const Scene& scene) {
  SimulatedBlock planned = Simulate(scene);
  if (!planned.planned.empty()) planned.block.passes = planned.planned;
  planned.block.looks.time_s = planned.exact.nominal_time_s;
  std::fill(planned.block.looks.range_m.begin(), planned.block.looks.range_m.end(), kNotGiven);
  return planned;
}

}  // namespace sarblock
