// SPDX-License-Identifier: Apache-2.0
// Families of blocks from their file, and the blocks that are made of a plan.
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "block/read_recorded.h"
#include "core/text.h"
#include "files/block_file.h"
#include "files/correction_options.h"
#include "simulate/true_path.h"
#include "stability.h"
#include "tables/toml.h"
#include <Eigen/Geometry>

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

namespace {

using Eigen::Vector3d;

/// What all paths of a plan are relative to.
struct Ground {
  Frame frame;
  Vector3d middle_m;
  Eigen::Matrix3d enu;
};

Ground GroundOf(const StabilityPlan& plan) {
  if (!plan.orbit) return {Frame::Local(), plan.origin_m, Eigen::Matrix3d::Identity()};
  const Frame frame =
      Frame::Geocentric(plan.body_radius_m > 0.0 ? Ellipsoid{"sphere", plan.body_radius_m, 0.0}
                                                 : NamedEllipsoid("WGS84"));
  const Vector3d middle_m = frame.FrameFromGeodetic({0.713, 0.219, 0.0});
  return {frame, middle_m, frame.EnuFromFrame(middle_m)};
}

Vector3d Direction(double heading_rad) {
  return {std::cos(heading_rad), std::sin(heading_rad), 0.0};
}

/// Flight along a straight line past the middle, with a swing that spans the path once.
StateVector StraightState(const StabilityPlan& plan,
                          const PlannedPass& pass,
                          const Ground& ground,
                          double t_s,
                          double half_s) {
  const Vector3d u = Direction(pass.heading_rad), left(-u.y(), u.x(), 0.0);
  const double rate = 2.9 / half_s, phase = 1.3 * pass.heading_rad + 1e-4 * pass.height_m;
  const double side = static_cast<double>(pass.side);
  StateVector state;
  state.time_s = plan.time_origin_s + t_s;
  state.position_m =
      ground.middle_m + u * (plan.speed_mps * t_s) +
      left * (-side * pass.ground_range_m + plan.swing_m * std::sin(rate * t_s + phase)) +
      Vector3d::UnitZ() * (pass.height_m + 0.7 * plan.swing_m * std::cos(rate * t_s - phase));
  state.velocity_mps =
      u * plan.speed_mps + left * (plan.swing_m * rate * std::cos(rate * t_s + phase)) -
      Vector3d::UnitZ() * (0.7 * plan.swing_m * rate * std::sin(rate * t_s - phase));
  return state;
}

/// Circular orbit abeam of the middle of the area at t = 0, in inertial axes.
StateVector OrbitState(const StabilityPlan& plan,
                       const PlannedPass& pass,
                       const Ground& ground,
                       double t_s) {
  const Vector3d n = ground.middle_m.normalized();
  Vector3d u = ground.enu.transpose() * Direction(pass.heading_rad);
  u = (u - u.dot(n) * n).normalized();
  const double radius_m = ground.middle_m.norm(), r_m = radius_m + pass.height_m;
  const double angle = -static_cast<double>(pass.side) * pass.ground_range_m / radius_m;
  const Vector3d s = std::cos(angle) * n + std::sin(angle) * n.cross(u);
  const double rate = plan.speed_mps / r_m;
  StateVector state;
  state.time_s = plan.time_origin_s + t_s;
  state.position_m = r_m * (std::cos(rate * t_s) * s + std::sin(rate * t_s) * u);
  state.velocity_mps = r_m * rate * (std::cos(rate * t_s) * u - std::sin(rate * t_s) * s);
  return state;
}

/// States from before the first to after the last look, the time zero beside the middle.
FlightPath MakePath(const StabilityPlan& plan, const PlannedPass& pass, const Ground& ground) {
  const double distance_m = std::hypot(pass.ground_range_m, pass.height_m);
  // A straight path is long enough for its swing to turn it by a few degrees at most.
  const double reach_m =
      1.3 * std::hypot(plan.along_m, plan.across_m) + (plan.orbit ? 0.02 : 0.2) * distance_m;
  const double tangent = std::tan(pass.squint_rad);
  // The antenna of a squinted look is behind its point by the distance times the tangent.
  const double middle_s = -distance_m * tangent / plan.speed_mps;
  const double half_s =
      (reach_m * (1.0 + std::abs(tangent)) + 1.3 * plan.relief_m * std::abs(tangent)) /
          plan.speed_mps +
      plan.time_margin_s;
  std::vector<StateVector> states;
  const auto pieces = static_cast<double>(plan.states - 1);
  for (std::size_t k = 0; k < plan.states; ++k) {
    const double t_s = middle_s + half_s * (2.0 * static_cast<double>(k) / pieces - 1.0);
    states.push_back(plan.orbit ? OrbitState(plan, pass, ground, t_s)
                                : StraightState(plan, pass, ground, t_s, half_s));
  }
  return FlightPath(std::move(states));
}

/// Refuses flights whose states would take the memory of a large block.
void RequireFewStates(const Pass& pass, double rate_hz) {
  constexpr double kMostStates = 1e6;
  const double span_s =
      std::max(pass.path.end_s(), pass.end_s) - std::min(pass.path.start_s(), pass.start_s);
  if (!(span_s * rate_hz <= kMostStates)) {
    throw InputError("recorder", "a flight would be more than a million states");
  }
}

constexpr double kFlownSpacing_s = 0.01;

/// The flight with its trajectory error, as states so close that cubics follow it to nanometres.
FlightPath FlownPath(const Frame& frame,
                     const FlightPath& planned,
                     const TrajectoryError& trajectory_error) {
  const auto pieces =
      static_cast<std::size_t>(std::ceil((planned.end_s() - planned.start_s()) / kFlownSpacing_s));
  std::vector<StateVector> states;
  for (std::size_t k = 0; k <= pieces; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(pieces);
    const double time_s = std::lerp(planned.start_s(), planned.end_s(), part);
    const Motion motion = *FlownMotion(frame, planned, &trajectory_error, time_s);
    states.push_back({time_s, motion.position_m, motion.velocity_mps});
  }
  return FlightPath(std::move(states));
}

/// Puts what the recorder wrote in place of the flight, and reads it as the plan asks for.
void Record(const StabilityPlan& plan, Block* block) {
  for (std::size_t i = 0; i < block->passes.size(); ++i) {
    Pass& pass = block->passes[i];
    const SceneRecorder& recorder = *plan.recorder;
    RequireFewStates(pass, recorder.rate_hz);
    pass.path =
        RecordFlight(block->frame, recorder, 1.0 / recorder.rate_hz, pass, nullptr, i, plan.seed);
    pass.recorded.asked = recorder.reading;
  }
  static_cast<void>(ReadRecordedFlights(block));
}

/// Time and range at which a pass sees a point, to the rounding of the coordinates: Newton within
/// the bracket, for as long as it moves.
std::array<double, 2> Measure(const Pass& pass, const Vector3d& p_m, const Cone& cone) {
  double low_s = pass.path.start_s(), high_s = pass.path.end_s();
  const auto error_m = [&](double at_s) {
    return EvaluateCone(*pass.path.At(at_s), p_m, cone).doppler_error_m;
  };
  if (!(error_m(low_s) >= 0.0 && error_m(high_s) <= 0.0)) {
    throw InputError("pass " + pass.id, "does not see its area");
  }
  double time_s = 0.5 * (low_s + high_s);
  for (int i = 0; i < 200; ++i) {
    const ConeValue at = EvaluateCone(*pass.path.At(time_s), p_m, cone);
    (at.doppler_error_m > 0.0 ? low_s : high_s) = time_s;
    double next_s = time_s - at.doppler_error_m / at.rate_mps;
    if (!(next_s > low_s && next_s < high_s)) next_s = 0.5 * (low_s + high_s);
    if (next_s == time_s || next_s == low_s || next_s == high_s) break;
    time_s = next_s;
  }
  return {time_s, (p_m - pass.path.At(time_s)->position_m).norm()};
}

void AddControl(const StabilityPlan& plan, Block* block, const std::vector<Vector3d>& truth_m) {
  const std::array<double, 3>& sigma_m = plan.control_sigma_m;
  for (const std::size_t point : plan.control_points) {
    block->points.role[point] = PointRole::kControl;
    block->points.given_m[point] = truth_m[point];
    KnownPosition known;
    known.point = static_cast<std::uint32_t>(point);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      known.fixed[i] = true;
      known.covariance_enu_m2(k, k) = sigma_m[i] * sigma_m[i];
    }
    known.covariance_enu_m2(0, 1) = known.covariance_enu_m2(1, 0) =
        plan.control_correlation * sigma_m[0] * sigma_m[1];
    block->points.known.push_back(known);
  }
}

void ShiftFirstPath(double shift_m, Block* block) {
  std::vector<StateVector> states = block->passes.front().path.states();
  for (StateVector& state : states) state.position_m += Vector3d::Constant(shift_m);
  block->passes.front().path = FlightPath(std::move(states));
}

}  // namespace

bool StabilityPlan::IsControl(std::size_t point) const {
  return std::find(control_points.begin(), control_points.end(), point) != control_points.end();
}

std::string StabilityPassId(std::size_t pass) { return "A" + std::to_string(pass + 1); }

Block MakeStabilityBlock(const StabilityPlan& plan) {
  Block block;
  block.name = "stability";
  const Ground ground = GroundOf(plan);
  block.frame = ground.frame;
  for (std::size_t i = 0; i < plan.passes.size(); ++i) {
    Pass pass;
    pass.id = StabilityPassId(i);
    pass.side = plan.passes[i].side;
    if (plan.doppler_wavelength_m > 0.0) pass.wavelength_m = plan.doppler_wavelength_m;
    pass.path = MakePath(plan, plan.passes[i], ground);
    if (plan.trajectory_error.Given()) {
      pass.start_s = pass.path.start_s();
      pass.end_s = pass.path.end_s();
      RequireFewStates(pass, 1.0 / kFlownSpacing_s);
      pass.path = FlownPath(
          block.frame, pass.path, TrajectoryError(plan.trajectory_error, pass, i, plan.seed));
    }
    pass.sigma = plan.sigma;
    pass.sigma.range_m *= plan.passes[i].range_sigma_factor;
    block.passes.push_back(std::move(pass));
  }
  std::vector<Vector3d> truth_m;
  Looks& looks = block.looks;
  for (std::size_t j = 0; j < plan.points; ++j) {
    RandomStream random(plan.seed, j);
    Vector3d place((2.0 * random.Uniform() - 1.0) * plan.along_m,
                   (2.0 * random.Uniform() - 1.0) * plan.across_m,
                   0.0);
    double height_m = random.Uniform() * plan.relief_m;
    if (plan.control_spread < 1.0 && plan.IsControl(j)) {
      place *= plan.control_spread;
      height_m *= plan.control_spread;
    }
    const Vector3d p_m =
        plan.orbit
            ? ground.frame.AtHeight(ground.middle_m + ground.enu.transpose() * place, height_m)
            : Vector3d(ground.middle_m + place + height_m * Vector3d::UnitZ());
    truth_m.push_back(p_m);
    block.points.ids.Append("P" + std::to_string(j + 1));
    block.points.role.push_back(PointRole::kTie);
    Vector3d given_m = Vector3d::Constant(kNotGiven);
    if (plan.start_error_m > 0.0) {
      given_m = p_m + plan.start_error_m * Vector3d(0.61, -0.53, 0.59);
    }
    block.points.given_m.push_back(given_m);
    for (std::size_t i = 0; i < plan.passes.size(); ++i) {
      const Pass& pass = block.passes[i];
      Cone cone;
      cone.squint_rad = plan.passes[i].squint_rad;
      double given = cone.squint_rad;
      if (plan.doppler_wavelength_m > 0.0) {
        given = 2.0 * plan.speed_mps * std::sin(cone.squint_rad) / plan.doppler_wavelength_m;
        cone = {Cone::Kind::kDoppler, 0.0, 0.5 * plan.doppler_wavelength_m * given};
      }
      auto [time_s, range_m] = Measure(pass, p_m, cone);
      RandomStream noise(plan.seed + 1, MixStream(j, i));
      double azimuth_sigma = plan.sigma.azimuth;
      if (plan.sigma.azimuth_unit == AzimuthUnit::kMetres) {
        const Motion at = *pass.path.At(time_s);
        azimuth_sigma /=
            LookTimeRates(p_m, at.position_m, at.velocity_mps, at.acceleration_mps2, cone)
                .along_mps;
      }
      range_m += plan.noise * pass.sigma.range_m * noise.Normal();
      const bool exact_time = plan.sigma.azimuth_unit == AzimuthUnit::kHertz;
      (exact_time ? given : time_s) += plan.noise * azimuth_sigma * noise.Normal();
      if (i == 0 && j == 1) range_m += plan.blunder * pass.sigma.range_m;
      looks.pass.push_back(static_cast<std::uint32_t>(i));
      looks.flags.push_back(plan.doppler_wavelength_m > 0.0 ? std::uint8_t{Looks::kDoppler}
                                                            : std::uint8_t{0});
      looks.time_s.push_back(time_s);
      looks.range_m.push_back(range_m);
      looks.cone.push_back(given);
    }
    looks.offsets.push_back(looks.pass.size());
  }
  AddControl(plan, &block, truth_m);
  std::vector<std::optional<std::array<double, 2>>> spans(block.passes.size());
  SetStripSpans(spans, &block);
  if (plan.strip_factor > 0.0) {
    for (Pass& pass : block.passes) {
      const double middle_s = 0.5 * (pass.start_s + pass.end_s);
      const double half_s = 0.5 * plan.strip_factor * (pass.end_s - pass.start_s);
      pass.start_s = middle_s - half_s;
      pass.end_s = middle_s + half_s;
    }
  }
  if (plan.recorder) Record(plan, &block);
  if (plan.path_error_m != 0.0) ShiftFirstPath(plan.path_error_m, &block);
  return block;
}

std::vector<double> Ratios(double from, double to, int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) {
    const double power = std::log10(from) + std::log10(to / from) * i / (count - 1);
    out.push_back(std::pow(10.0, power));
  }
  return out;
}

}  // namespace sarblock
