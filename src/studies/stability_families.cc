// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <variant>

#include "core/text.h"
#include "files/block_file.h"
#include "files/correction_options.h"
#include "stability.h"
#include "tables/toml.h"

namespace sarblock {
namespace {

/// Numbers that a formula may name.
using Names = std::map<std::string, double, std::less<>>;

/// A formula of a study file: numbers, names, + - * /, parentheses and functions of one or two
/// numbers.
class Formula {
 public:
  /// `place` is where it stands, for messages.
  Formula(std::string_view text, const Names& names, const TomlValue& place)
      : rest_(text), names_(names), place_(place) {}

  [[nodiscard]] double Value() {
    const double value = Sum();
    if (Next() != '\0') Fail("cannot be read from " + Quoted(std::string(rest_)));
    if (!std::isfinite(value)) Fail("is not a finite number");
    return value;
  }

 private:
  struct Function {
    int arguments;
    double (*of)(double a, double b);
  };

  [[noreturn]] void Fail(const std::string& problem) const {
    const auto value = names_.find("v");
    place_.Fail(problem + (value == names_.end() ? "" : " at v = " + NumberText(value->second)));
  }

  /// The next character that is no blank; 0 at the end.
  char Next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(' '), rest_.size()));
    return rest_.empty() ? '\0' : rest_.front();
  }
  bool Take(char c) {
    if (Next() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void Require(char c) {
    if (!Take(c)) Fail("needs '" + std::string(1, c) + "' before " + Quoted(std::string(rest_)));
  }

  double Sum() {
    double value = Product();
    for (;;) {
      if (Take('+')) {
        value += Product();
      } else if (Take('-')) {
        value -= Product();
      } else {
        return value;
      }
    }
  }
  double Product() {
    double value = Factor();
    for (;;) {
      if (Take('*')) {
        value *= Factor();
      } else if (Take('/')) {
        value /= Factor();
      } else {
        return value;
      }
    }
  }
  double Factor() {
    constexpr int kMaxDepth = 100;
    if (++depth_ > kMaxDepth) Fail("is nested too deeply");
    const double value = Take('-') ? -Factor() : Operand();
    --depth_;
    return value;
  }
  double Operand() {
    if (Take('(')) {
      const double value = Sum();
      Require(')');
      return value;
    }
    double number = 0.0;
    Next();
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), number);
    if (error == std::errc()) {
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      return number;
    }
    const std::size_t length =
        std::min(rest_.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"), rest_.size());
    const std::string name(rest_.substr(0, length));
    rest_.remove_prefix(length);
    return Take('(') ? Call(name) : Named(name);
  }
  double Call(const std::string& name) {
    static const std::map<std::string, Function> kFunctions = {
        {"cos", {1, [](double a, double) { return std::cos(a); }}},
        {"exp", {1, [](double a, double) { return std::exp(a); }}},
        {"log", {1, [](double a, double) { return std::log(a); }}},
        {"max", {2, [](double a, double b) { return std::max(a, b); }}},
        {"min", {2, [](double a, double b) { return std::min(a, b); }}},
        {"sin", {1, [](double a, double) { return std::sin(a); }}},
        {"sqrt", {1, [](double a, double) { return std::sqrt(a); }}},
        {"tan", {1, [](double a, double) { return std::tan(a); }}}};
    const auto found = kFunctions.find(name);
    if (found == kFunctions.end()) RefuseName(name, "function", kFunctions);
    const double a = Sum();
    if (found->second.arguments == 2) Require(',');
    const double b = found->second.arguments == 2 ? Sum() : 0.0;
    Require(')');
    return found->second.of(a, b);
  }
  double Named(const std::string& name) const {
    const auto found = names_.find(name);
    if (found == names_.end()) RefuseName(name, "number", names_);
    return found->second;
  }
  template <typename Map>
  [[noreturn]] void RefuseName(const std::string& name, const char* noun, const Map& known) const {
    if (name.empty()) Fail(std::string("needs a number before ") + Quoted(std::string(rest_)));
    std::vector<std::string> names;
    for (const auto& entry : known) names.push_back(entry.first);
    Fail("has no " + std::string(noun) + " " + Quoted(name) + ", " + Listed(names) + " is allowed" +
         DidYouMean(NearestName(name, names)));
  }

  std::string_view rest_;
  const Names& names_;
  const TomlValue& place_;
  int depth_ = 0;
};

bool IsFormula(const toml::node& node) {
  const auto* const text = node.as_string();
  return text != nullptr && (*text)->starts_with('=');
}

/// A number, or that of a formula.
double NumberOf(const TomlValue& value, const Names& names) {
  if (!IsFormula(value.node())) return value.Number();
  const std::string text = value.Text();
  return Formula(std::string_view(text).substr(1), names, value).Value();
}

/// Puts numbers in place of the formulas of a table or a list, but for those of each pass: what
/// reads it afterwards finds numbers where the file has formulas, at the same lines.
template <typename Container>
void Evaluate(const std::string& key, const Names& names, Container* container) {
  const auto evaluate = [&](const std::string& name, toml::node& node, const auto& replace) {
    if (toml::table* table = node.as_table()) {
      Evaluate(name, names, table);
    } else if (toml::array* array = node.as_array()) {
      Evaluate(name, names, array);
    } else if (IsFormula(node)) {
      const TomlValue value(node, name);
      const double number = NumberOf(value, names);
      const bool whole = number == std::floor(number) && std::abs(number) < 1e15;
      // Parsed below as many lines, since only what is parsed has a place.
      toml::table parsed = toml::parse(
          std::string(std::max<std::size_t>(value.Place().line, 1) - 1, '\n') + "v = " +
              (whole ? std::to_string(static_cast<std::int64_t>(number)) : NumberText(number)),
          value.Place().file);
      parsed.get("v")->visit([&](auto& placed) { replace(std::move(placed)); });
    }
  };
  if constexpr (std::is_same_v<Container, toml::table>) {
    for (auto&& [name, node] : *container) {
      if (name.str() == "each_pass") continue;
      evaluate(key + "." + std::string(name.str()), node, [&, &at = name](auto&& placed) {
        container->insert_or_assign(at, std::forward<decltype(placed)>(placed));
      });
    }
  } else {
    for (std::size_t i = 0; i < container->size(); ++i) {
      evaluate(key + "[" + std::to_string(i) + "]", (*container)[i], [&](auto&& placed) {
        container->replace(container->cbegin() + static_cast<std::ptrdiff_t>(i),
                           std::forward<decltype(placed)>(placed));
      });
    }
  }
}

/// Bounds that keep a step within the seconds and the memory that a study of small blocks means.
constexpr int kMaxPasses = 1000, kMaxPoints = 1000, kMaxStates = 100000;
constexpr std::size_t kMaxValues = 1000, kMaxStatesOfAllPasses = 2000000;

/// The keys of a pass over what it is; formulas may name its own numbers.
void ReadPass(SceneTable table, Names names, PlannedPass* pass) {
  table.Choice<LookSide>(
      "look", {{"left", LookSide::kLeft}, {"right", LookSide::kRight}}, &pass->side);
  const std::array<std::pair<const char*, double*>, 5> numbers = {
      {{"heading_rad", &pass->heading_rad},
       {"ground_range_m", &pass->ground_range_m},
       {"height_m", &pass->height_m},
       {"squint_rad", &pass->squint_rad},
       {"range_sigma_factor", &pass->range_sigma_factor}}};
  for (const auto& [key, number] : numbers) names.emplace(key, *number);
  for (const auto& [key, number] : numbers) {
    if (const auto given = table.Take(key)) *number = NumberOf(*given, names);
  }
  if (!(pass->range_sigma_factor > 0.0)) {
    throw InputError(table.PlaceOf("range_sigma_factor"), "must be above 0");
  }
  table.Finish();
}

void ReadPasses(SceneTable* table, const Names& names, StabilityPlan* plan) {
  if (table->Has("passes")) plan->passes.clear();
  for (SceneTable& given : table->Tables("passes")) {
    ReadPass(given, names, &plan->passes.emplace_back());
  }
  if (plan->passes.empty()) throw InputError(table->PlaceOf("passes"), "has no pass");
  if (const auto count = table->Take("pass_count")) {
    const std::vector<PlannedPass> listed = plan->passes;
    plan->passes.resize(static_cast<std::size_t>(count->Integer(1, kMaxPasses)));
    for (std::size_t i = listed.size(); i < plan->passes.size(); ++i) {
      plan->passes[i] = listed[i % listed.size()];
    }
  }
  if (const auto first = table->Table("first_pass")) ReadPass(*first, names, &plan->passes[0]);
  const auto each = table->Table("each_pass");
  Names of_pass = names;
  for (std::size_t i = 0; each && i < plan->passes.size(); ++i) {
    of_pass["i"] = static_cast<double>(i);
    ReadPass(*each, of_pass, &plan->passes[i]);
  }
}

void ReadSigmas(SceneTable* table, LookSigma* sigma) {
  if (const auto given = table->Take("range_sigma_m")) sigma->range_m = given->Positive();
  constexpr std::array<std::pair<const char*, AzimuthUnit>, 3> kAzimuth = {
      {{"azimuth_sigma_m", AzimuthUnit::kMetres},
       {"azimuth_sigma_s", AzimuthUnit::kSeconds},
       {"doppler_sigma_hz", AzimuthUnit::kHertz}}};
  bool taken = false;
  for (const auto& [key, unit] : kAzimuth) {
    const auto given = table->Take(key);
    if (!given) continue;
    if (std::exchange(taken, true)) given->Fail("excludes another sigma of azimuth; give one");
    sigma->azimuth = given->Positive();
    sigma->azimuth_unit = unit;
  }
}

void ReadControl(SceneTable* table, StabilityPlan* plan) {
  table->Numbers("control_sigma_m", &plan->control_sigma_m);
  for (const double sigma_m : plan->control_sigma_m) {
    if (!(sigma_m > 0.0)) throw InputError(table->PlaceOf("control_sigma_m"), "must be above 0");
  }
  table->Number("control_correlation", &plan->control_correlation);
  if (!(std::abs(plan->control_correlation) < 1.0)) {
    throw InputError(table->PlaceOf("control_correlation"), "must lie between -1 and 1");
  }
  const auto given = table->Take("control_points");
  if (given) plan->control_points.clear();
  for (const TomlValue& point : given ? given->Entries() : std::vector<TomlValue>()) {
    const int index = point.Integer(0, kMaxPoints - 1);
    if (plan->IsControl(static_cast<std::size_t>(index))) point.Fail("is given twice");
    plan->control_points.push_back(static_cast<std::size_t>(index));
  }
  for (const std::size_t point : plan->control_points) {
    if (point >= plan->points) {
      throw InputError(table->PlaceOf("control_points"),
                       "names point " + std::to_string(point) + ", the block has " +
                           std::to_string(plan->points) + ", counted from 0");
    }
  }
}

/// The keys of a block or of a family over what it is.
void ReadPlan(const TomlTable& toml, const Names& names, SceneTable* table, StabilityPlan* plan) {
  table->Truth("orbit", &plan->orbit);
  ReadPasses(table, names, plan);
  if (const auto count = table->Take("points")) {
    plan->points = static_cast<std::size_t>(count->Integer(1, kMaxPoints));
  }
  if (const auto count = table->Take("states")) {
    plan->states = static_cast<std::size_t>(count->Integer(2, kMaxStates));
  }
  if (plan->states * plan->passes.size() > kMaxStatesOfAllPasses) {
    throw InputError(table->PlaceOf("states"),
                     "are more than " + std::to_string(kMaxStatesOfAllPasses) + " of all passes");
  }
  if (const auto speed = table->Take("speed_mps")) plan->speed_mps = speed->Positive();
  table->Number("body_radius_m", &plan->body_radius_m);
  table->Number("along_m", &plan->along_m);
  table->Number("across_m", &plan->across_m);
  table->Number("relief_m", &plan->relief_m);
  table->Number("swing_m", &plan->swing_m);
  table->Number("doppler_wavelength_m", &plan->doppler_wavelength_m);
  table->Number("noise", &plan->noise);
  table->Number("control_spread", &plan->control_spread);
  std::array<double, 3> origin_m{};
  if (table->Numbers("origin_m", &origin_m)) plan->origin_m = Eigen::Vector3d(origin_m.data());
  table->Number("time_origin_s", &plan->time_origin_s);
  table->Number("time_margin_s", &plan->time_margin_s);
  table->Number("strip_factor", &plan->strip_factor);
  table->Number("start_error_m", &plan->start_error_m);
  table->Number("blunder", &plan->blunder);
  table->Number("path_error_m", &plan->path_error_m);
  ReadSigmas(table, &plan->sigma);
  ReadControl(table, plan);
  if (auto recorder = table->Table("recorder")) {
    plan->recorder = files::ReadRecorder(*recorder);
    if (!(plan->recorder->rate_hz > 0.0)) {
      throw InputError(recorder->PlaceOf("rate_hz"), "must be given, above 0");
    }
  }
  if (auto wander = table->Table("wander")) {
    plan->trajectory_error = files::ReadTrajectoryError(*wander, nullptr);
    if (!plan->recorder) {
      throw InputError(wander->PlaceOf("rms_m"), "is of recorded flights, give recorder");
    }
  }
  if (table->Take("adjust")) {
    std::vector<std::string> ids;
    for (std::size_t i = 0; i < plan->passes.size(); ++i) ids.push_back(StabilityPassId(i));
    const files::AdjustTable adjust = files::ReadAdjust(toml, ids);
    if (!adjust.rejections_file.empty() || !adjust.pairs_file.empty()) {
      throw InputError(table->PlaceOf("adjust"), "names files, which these blocks do not have");
    }
    plan->options = adjust;
  }
  // [adjust] has it in degrees, which not every number of radians is.
  if (const auto sigma = table->Take("squint_bias_sigma_rad")) {
    for (const CorrectionGroup& group : plan->options.groups) {
      if (std::holds_alternative<SquintCorrection>(group.model)) {
        sigma->Fail("excludes adjust.correction.squint; give one");
      }
    }
    plan->options.corrections = CorrectionChoice::kGiven;
    plan->options.groups.push_back({"squint", SquintCorrection{sigma->Positive()}, {}, false});
  }
}

const FamilyText& OfTheProgram() {
  constexpr char kFile[] = "stability_families.toml";
  static const FamilyText kText{std::string(FamiliesText(kFile)), kFile, {}};
  return kText;
}

/// Plans of blocks and families as the tables of a study say.
class PlanReader {
 public:
  PlanReader(const FamilyText& study, double value)
      : roots_{study.Parsed(), OfTheProgram().Parsed()},
        names_{{"v", value}, {"deg", kRadPerDeg}, {"ppm", 1e-6}} {}

  [[nodiscard]] StabilityPlan Family(std::size_t index) {
    toml::table* table = roots_[0].get("family")->as_array()->get(index)->as_table();
    return Read("family." + std::to_string(index),
                {"name", "parameter", "about", "values", "whole"},
                table);
  }

 private:
  StabilityPlan Block(const TomlValue& name) {
    std::vector<std::string> names;
    for (toml::table& root : roots_) {
      toml::table* const blocks = root["block"].as_table();
      if (blocks == nullptr) continue;
      for (auto&& [key, node] : *blocks) {
        names.emplace_back(key.str());
        if (names.back() != name.Text() || !node.is_table()) continue;
        if (!open_.insert(names.back()).second) name.Fail("is based on itself");
        return Read("block." + names.back(), {}, node.as_table());
      }
    }
    name.Fail("the block " + Quoted(name.Text()) + " does not exist" +
              DidYouMean(NearestName(name.Text(), names)));
  }

  StabilityPlan Read(const std::string& key,
                     const std::vector<const char*>& also,
                     toml::table* toml) {
    Evaluate(key, names_, toml);
    const TomlTable given(*toml, key);
    SceneTable table(given);
    StabilityPlan plan;
    if (const auto block = table.Take("block")) plan = Block(*block);
    ReadPlan(given, names_, &table, &plan);
    for (const char* other : also) static_cast<void>(table.Take(other));
    table.Finish();
    return plan;
  }

  std::array<toml::table, 2> roots_;  ///< of the study, of the program
  Names names_;
  std::set<std::string> open_;  ///< blocks that are being read
};

/// `values` as a list, or with equal ratios from one to another, after a first one if given.
std::vector<double> ReadFamilyValues(const TomlValue& given) {
  std::vector<double> values;
  if (given.IsArray()) {
    for (const TomlValue& entry : given.Entries()) values.push_back(entry.Number());
    if (values.empty()) given.Fail("must not be empty");
  } else {
    SceneTable table{TomlTable(given)};
    if (const auto first = table.Take("first")) values.push_back(first->Number());
    const auto from = table.Take("from"), to = table.Take("to"), count = table.Take("count");
    if (!from || !to || !count) given.Fail("needs from, to and count, or is a list");
    const int most = static_cast<int>(kMaxValues) - 1;
    for (const double value : Ratios(from->Positive(), to->Positive(), count->Integer(2, most))) {
      values.push_back(value);
    }
    table.Finish();
  }
  if (values.size() > kMaxValues) {
    given.Fail("are more than " + std::to_string(kMaxValues));
  }
  return values;
}

StabilityFamily ReadFamily(SceneTable* table,
                           std::size_t index,
                           const std::shared_ptr<const FamilyText>& study) {
  StabilityFamily family;
  for (const auto& [key, text] :
       {std::pair{"name", &family.name}, std::pair{"parameter", &family.parameter}}) {
    const auto given = table->Take(key);
    if (!given) throw InputError(table->PlaceOf(key), "must be given");
    *text = given->Text();
    if (text->empty() || text->find_first_of("\r\n") != std::string::npos) {
      given->Fail("must be one line, not empty");
    }
  }
  table->Text("about", &family.about);
  table->Truth("whole", &family.whole);
  const auto values = table->Take("values");
  if (!values) throw InputError(table->PlaceOf("values"), "must be given");
  family.values = ReadFamilyValues(*values);
  family.plan = [study, index](double value) { return PlanReader(*study, value).Family(index); };
  return family;
}

}  // namespace

toml::table FamilyText::Parsed() const { return ParseToml(text, file, overrides); }

StabilityFamily FamilyOfStudy(SceneTable* table,
                              std::size_t index,
                              const std::shared_ptr<const FamilyText>& study) {
  StabilityFamily family = ReadFamily(table, index, study);
  for (const double value : family.values) {
    const StabilityPlan plan = family.plan(value);
    try {
      static_cast<void>(MakeStabilityBlock(plan));
    } catch (const InputError& error) {
      throw InputError(table->PlaceOf("values"),
                       "give no block at v = " + NumberText(value) + ": " + error.what());
    }
  }
  return family;
}

const std::vector<StabilityFamily>& StabilityFamilies() {
  static const std::vector<StabilityFamily> kFamilies = [] {
    const std::shared_ptr<const FamilyText> text(&OfTheProgram(), [](const FamilyText*) {});
    const toml::table root = text->Parsed();
    std::vector<StabilityFamily> out;
    for (SceneTable& table : SceneTable{TomlTable(root, "")}.Tables("family")) {
      out.push_back(ReadFamily(&table, out.size(), text));
    }
    return out;
  }();
  return kFamilies;
}

}  // namespace sarblock
