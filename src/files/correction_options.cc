// SPDX-License-Identifier: Apache-2.0
#include "correction_options.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/files/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

#include "core/text.h"
#include "model/priors.h"
#include "tables/json.h"
#include <nlohmann/json.hpp>

namespace sarblock::files {
namespace {

// clang-format off
constexpr std::array kCorrectionOptions = std::to_array<AdjustOption>({
  {"correction.position.basis", "text", "polynomial, spline", "polynomial",
   "Functions of time of the antenna's displacement: Legendre polynomials or a cubic B-spline."},
  {"correction.position.degree", "integer", "0 to 15", "0", "Highest Legendre degree."},
  {"correction.position.knot_spacing_s", "number", "above 0", "none, a spline needs it",
   "Time between the knots of the spline."},
  {"correction.position.process", "text", "white, random-walk, gauss-markov", "white",
   "Prior of the coefficients of a spline, one after the other: independent, each the one before "
   "plus a step (sigma_m: gained over the strip), or a first-order Gauss-Markov process (sigma_m: "
   "stationary)."},
  {"correction.position.correlation_time_s", "number", "above 0", "none, gauss-markov needs it",
   "Time in which correlations of the process fall to 1/e."},
  {"correction.position.start_sigma_m", "number or list", "above 0", "none, random-walk needs it",
   "Prior standard deviation of the first coefficient; one number, or one a component."},
  {"correction.position.axes", "text", "track, frame", "track", "Axes of the displacement."},
  {"correction.position.components", "list", "along, across, up, or x, y, z in frame axes", "all",
   "Axes that are estimated."},
  {"correction.position.sigma_m", "number or list", "above 0, or none", "no prior",
   "Prior standard deviation: one number, or one entry a component, each a number, none, or a "
   "list with one number a degree."},
  {"correction.position.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.position.shared", "flag", "true, false", "false",
   "One set of parameters for all these passes."},
  {"correction.velocity.components", "list", "across, up", "all", "Axes that are estimated."},
  {"correction.velocity.sigma", "number or list", "above 0, or none", "no prior",
   "Prior standard deviation of the direction error, dimensionless, one entry a component."},
  {"correction.velocity.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.velocity.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.range.bias", "flag", "true, false", "true if bias_sigma_m is given",
   "Estimate a range bias."},
  {"correction.range.bias_sigma_m", "number", "above 0", "no prior", "Its prior."},
  {"correction.range.scale", "flag", "true, false", "true if scale_sigma_ppm is given",
   "Estimate a range scale."},
  {"correction.range.scale_sigma_ppm", "number", "above 0", "no prior", "Its prior."},
  {"correction.range.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.range.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.time.bias", "flag", "true, false", "true if bias_sigma_s is given",
   "Estimate an azimuth time bias."},
  {"correction.time.bias_sigma_s", "number", "above 0", "no prior", "Its prior."},
  {"correction.time.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.time.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.squint.bias", "flag", "true, false", "true if bias_sigma_deg is given",
   "Estimate a squint bias."},
  {"correction.squint.bias_sigma_deg", "number", "above 0", "no prior", "Its prior."},
  {"correction.squint.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.squint.shared", "flag", "true, false", "false", "One set for all these passes."},
  {"correction.troposphere.zenith", "flag", "true, false", "true if zenith_sigma_m is given",
   "Estimate the zenith delay."},
  {"correction.troposphere.zenith_sigma_m", "number", "above 0", "no prior", "Its prior."},
  {"correction.troposphere.scale_height_m", "number", "above 0", "7000",
   "Height over which the delay falls to 1/e."},
  {"correction.troposphere.passes", "list", "pass ids", "all", "Passes that have the correction."},
  {"correction.troposphere.shared", "flag", "true, false", "false",
   "One set for all these passes."},
});
// clang-format on

// Axes of `components = [...]` in their order there; all axes where it is left out.
std::vector<std::size_t> ReadComponents(const TomlTable& table,
                                        const std::vector<std::string>& axes) {
  std::vector<std::size_t> order;
  const auto given = table.Find("components");
  if (!given) {
    for (std::size_t i = 0; i < axes.size(); ++i) order.push_back(i);
    return order;
  }
  for (const TomlValue& entry : given->Entries()) {
    const std::size_t axis = entry.OneOf(axes);
    if (std::find(order.begin(), order.end(), axis) != order.end()) {
      entry.Fail(Quoted(axes[axis]) + " is given twice");
    }
    order.push_back(axis);
  }
  if (order.empty()) given->Fail("is empty, at least one of " + Listed(axes) + " is needed");
  return order;
}

bool IsNone(const TomlValue& value) { return value.IsText() && value.Text() == "none"; }

PriorSigma ReadPriorSigma(const TomlValue& value) {
  if (IsNone(value)) return kNotGiven;
  if (!value.IsNumber()) value.Fail("is no number, a number above 0 or \"none\" is allowed");
  return value.Positive();
}

// The entries of a list of priors by axis: one per component in the order of `components`, or one
// per axis. An axis without an entry is null.
std::vector<const TomlValue*> ListByAxis(const TomlValue& list,
                                         const std::vector<TomlValue>& entries,
                                         const std::vector<std::size_t>& components,
                                         std::size_t axis_count) {
  std::vector<const TomlValue*> by_axis(axis_count, nullptr);
  if (entries.size() == components.size()) {
    for (std::size_t i = 0; i < entries.size(); ++i) by_axis[components[i]] = &entries[i];
  } else if (entries.size() == axis_count) {
    for (const std::size_t axis : components) by_axis[axis] = &entries[axis];
  } else {
    std::string allowed = std::to_string(components.size());
    if (components.size() != axis_count)
      allowed += " (one per component) or " + std::to_string(axis_count) + " (one per axis)";
    list.Fail("the list has " + std::to_string(entries.size()) + " entries, " + allowed +
              " are needed");
  }
  return by_axis;
}

// One axis of position.sigma_m: a number, "none", or a list with one entry a degree.
std::vector<double> ReadDegrees(const TomlValue& value, const PositionCorrection& model) {
  if (IsNone(value)) return {};
  if (!value.IsArray()) return {ReadPriorSigma(value)};
  if (model.basis == PositionCorrection::Basis::kSpline) {
    value.Fail("is a list per degree, a spline has no degrees; one number is allowed");
  }
  const std::vector<TomlValue> entries = value.Entries();
  if (entries.size() != static_cast<std::size_t>(model.degree) + 1) {
    value.Fail("the list has " + std::to_string(entries.size()) + " entries, degree " +
               std::to_string(model.degree) + " needs " + std::to_string(model.degree + 1));
  }
  std::vector<double> sigmas;
  for (const TomlValue& entry : entries) sigmas.push_back(ReadPriorSigma(entry));
  return sigmas;
}

// Prior of a spline's coefficients with each other.
void ReadProcess(const TomlTable& table,
                 const std::vector<std::size_t>& components,
                 const std::optional<TomlValue>& sigma,
                 PositionCorrection* model) {
  using Process = PositionCorrection::Process;
  if (const auto process = table.Find("process")) {
    model->process = static_cast<Process>(process->OneOf({"white", "random-walk", "gauss-markov"}));
    const bool spline = model->basis == PositionCorrection::Basis::kSpline;
    if (model->process != Process::kWhite && !spline) {
      process->Fail("is one of the coefficients of a spline, basis = \"spline\" is needed");
    }
    if (model->process != Process::kWhite && (!sigma || IsNone(*sigma))) {
      process->Fail("needs sigma_m, its standard deviation");
    }
  }
  const auto time = table.Find("correlation_time_s");
  if (model->process == Process::kGaussMarkov) {
    model->correlation_time_s = table.Require("correlation_time_s", "a number above 0").Positive();
  } else if (time) {
    time->Fail("belongs to process = \"gauss-markov\"");
  }
  const auto start = table.Find("start_sigma_m");
  if (model->process == Process::kRandomWalk) {
    const TomlValue& value = table.Require("start_sigma_m", "a number above 0");
    if (value.IsArray()) {
      const std::vector<TomlValue> entries = value.Entries();
      const auto by_axis = ListByAxis(value, entries, components, 3);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (by_axis[axis] != nullptr) model->start_sigma_m[axis] = by_axis[axis]->Positive();
      }
    } else {
      for (const std::size_t axis : components) model->start_sigma_m[axis] = value.Positive();
    }
  } else if (start) {
    start->Fail("belongs to process = \"random-walk\"");
  }
}

PositionCorrection ReadPositionCorrection(const TomlTable& table) {
  PositionCorrection model;
  if (const auto basis = table.Find("basis")) {
    model.basis = static_cast<PositionCorrection::Basis>(basis->OneOf({"polynomial", "spline"}));
  }
  const auto degree = table.Find("degree");
  const auto spacing = table.Find("knot_spacing_s");
  if (model.basis == PositionCorrection::Basis::kSpline) {
    if (degree) degree->Fail("belongs to basis = \"polynomial\", a spline has knot_spacing_s");
    model.knot_spacing_s = table.Require("knot_spacing_s", "a number above 0").Positive();
  } else {
    if (spacing) spacing->Fail("belongs to basis = \"spline\", a polynomial has degree");
    if (degree) model.degree = degree->Integer(0, PositionCorrection::kMaxDegree);
  }
  if (const auto axes = table.Find("axes")) {
    model.axes = static_cast<PositionCorrection::Axes>(axes->OneOf({"track", "frame"}));
  }
  const bool track = model.axes == PositionCorrection::Axes::kTrack;
  const std::vector<std::string> names = track ? std::vector<std::string>{"along", "across", "up"}
                                               : std::vector<std::string>{"x", "y", "z"};
  const std::vector<std::size_t> components = ReadComponents(table, names);
  model.components = {false, false, false};
  for (const std::size_t axis : components) model.components[axis] = true;
  const auto sigma = table.Find("sigma_m");
  if (sigma && sigma->IsArray()) {
    const std::vector<TomlValue> entries = sigma->Entries();
    const auto by_axis = ListByAxis(*sigma, entries, components, 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (by_axis[axis] != nullptr) {
        model.prior_sigma_m[axis] = ReadDegrees(*by_axis[axis], model);
      }
    }
  } else if (sigma && !IsNone(*sigma)) {
    for (const std::size_t axis : components) model.prior_sigma_m[axis] = {ReadPriorSigma(*sigma)};
  }
  ReadProcess(table, components, sigma, &model);
  return model;
}

VelocityCorrection ReadVelocity(const TomlTable& table) {
  VelocityCorrection model;
  const std::vector<std::size_t> components = ReadComponents(table, {"across", "up"});
  model.components = {false, false};
  for (const std::size_t axis : components) model.components[axis] = true;
  const auto sigma = table.Find("sigma");
  if (sigma && sigma->IsArray()) {
    const std::vector<TomlValue> entries = sigma->Entries();
    const auto by_axis = ListByAxis(*sigma, entries, components, 2);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (by_axis[axis] != nullptr) model.prior_sigma[axis] = ReadPriorSigma(*by_axis[axis]);
    }
  } else if (sigma) {
    for (const std::size_t axis : components) model.prior_sigma[axis] = ReadPriorSigma(*sigma);
  }
  return model;
}

// `name` = true, or its prior `sigma_name`. Returns whether the parameter is on.
bool ReadParameter(const TomlTable& table,
                   std::string_view name,
                   std::string_view sigma_name,
                   double unit,
                   PriorSigma* prior_sigma) {
  const auto flag = table.Find(name);
  const auto sigma = table.Find(sigma_name);
  if (sigma) {
    *prior_sigma = sigma->Positive() * unit;
    if (*prior_sigma == 0.0)
      sigma->Fail("is too small, a number that is not 0 in SI units is allowed");
  }
  if (flag && !flag->Flag() && sigma) {
    flag->Fail("is false, yet " + std::string(sigma_name) +
               " is given; only one of both may stand");
  }
  return flag ? flag->Flag() : sigma.has_value();
}

[[noreturn]] void FailOff(const TomlTable& table, std::string_view name, const std::string& also) {
  throw InputError(table.PlaceOf(name),
                   "is not given, " + std::string(name) + " = true" + also + " is needed");
}

RangeCorrection ReadRange(const TomlTable& table) {
  RangeCorrection model;
  model.bias = ReadParameter(table, "bias", "bias_sigma_m", 1.0, &model.bias_prior_sigma_m);
  model.scale = ReadParameter(table, "scale", "scale_sigma_ppm", 1e-6, &model.scale_prior_sigma);
  if (!model.bias && !model.scale) {
    FailOff(table, "bias", ", bias_sigma_m, scale = true or scale_sigma_ppm");
  }
  return model;
}

TimeCorrection ReadTime(const TomlTable& table) {
  TimeCorrection model;
  if (!ReadParameter(table, "bias", "bias_sigma_s", 1.0, &model.bias_prior_sigma_s)) {
    FailOff(table, "bias", " or bias_sigma_s");
  }
  return model;
}

SquintCorrection ReadSquintCorrection(const TomlTable& table) {
  SquintCorrection model;
  double* const prior_rad = &model.bias_prior_sigma_rad;
  if (!ReadParameter(table, "bias", "bias_sigma_deg", kRadPerDeg, prior_rad)) {
    FailOff(table, "bias", " or bias_sigma_deg");
  }
  return model;
}

TroposphereCorrection ReadTroposphere(const TomlTable& table) {
  TroposphereCorrection model;
  if (!ReadParameter(table, "zenith", "zenith_sigma_m", 1.0, &model.zenith_prior_sigma_m)) {
    FailOff(table, "zenith", " or zenith_sigma_m");
  }
  if (const auto height_m = table.FindPositive("scale_height_m")) model.scale_height_m = *height_m;
  return model;
}

CorrectionGroup ReadGroup(std::size_t kind,
                          const std::string& name,
                          const TomlTable& table,
                          const std::vector<std::string>& pass_ids) {
  table.RefuseOthers(KeysWithin(kCorrectionOptions, "correction." + CorrectionKinds()[kind] + "."));
  CorrectionGroup group;
  group.name = name;
  switch (kind) {
    case 0:
      group.model = ReadPositionCorrection(table);
      break;
    case 1:
      group.model = ReadVelocity(table);
      break;
    case 2:
      group.model = ReadRange(table);
      break;
    case 3:
      group.model = ReadTime(table);
      break;
    case 4:
      group.model = ReadSquintCorrection(table);
      break;
    default:
      group.model = ReadTroposphere(table);
      break;
  }
  if (const auto shared = table.Find("shared")) group.shared = shared->Flag();
  const auto passes = table.Find("passes");
  if (!passes) return group;
  for (const TomlValue& entry : passes->Entries()) {
    const std::string id = entry.Text();
    if (std::find(pass_ids.begin(), pass_ids.end(), id) == pass_ids.end()) {
      entry.Fail("the block has no pass " + Quoted(id) + DidYouMean(NearestName(id, pass_ids)));
    }
    if (std::find(group.passes.begin(), group.passes.end(), id) != group.passes.end()) {
      entry.Fail("pass " + Quoted(id) + " is given twice");
    }
    group.passes.push_back(id);
  }
  if (group.passes.empty()) passes->Fail("is empty; left out, it means all passes");
  return group;
}

// A pass has one set of parameters of a kind, beside those it shares with others.
void RefuseOverlap(const std::vector<CorrectionGroup>& before,
                   const CorrectionGroup& group,
                   const TomlValue& value,
                   const std::vector<std::string>& pass_ids) {
  const auto covers = [](const CorrectionGroup& one, const std::string& id) {
    return one.passes.empty() ||
           std::find(one.passes.begin(), one.passes.end(), id) != one.passes.end();
  };
  for (const CorrectionGroup& other : before) {
    if (group.shared || other.shared || !Overlap(other, group)) continue;
    for (const std::string& id : pass_ids) {
      if (covers(group, id) && covers(other, id)) {
        value.Fail("pass " + Quoted(id) + " has a correction of this kind already (" + other.name +
                   "); one that is not shared is allowed" +
                   (group.model.index() == 0 ? " for a component" : ""));
      }
    }
  }
}

std::string SigmaText(double sigma) { return std::isnan(sigma) ? "\"none\"" : NumberText(sigma); }

std::string DegreesText(const std::vector<double>& sigmas) {
  if (sigmas.size() == 1) return SigmaText(sigmas[0]);
  std::string text = sigmas.empty() ? "\"none\"" : "[";
  for (std::size_t i = 0; i < sigmas.size(); ++i)
    text += (i > 0 ? ", " : "") + SigmaText(sigmas[i]);
  return sigmas.empty() ? text : text + "]";
}

class GroupDump {
 public:
  [[nodiscard]] const std::string& text() const { return text_; }

  void Line(std::string_view key, const std::string& value) {
    text_.append(key).append(" = ").append(value).append("\n");
  }
  void List(std::string_view key, const std::vector<std::string>& entries) {
    std::string value;
    for (const std::string& entry : entries) value += (value.empty() ? "" : ", ") + entry;
    Line(key, "[" + value + "]");
  }
  void Parameter(const std::string& name,
                 const std::string& sigma_name,
                 double sigma,
                 double unit) {
    if (std::isnan(sigma)) {
      Line(name, "true");
    } else {
      Line(sigma_name, NumberText(ToUnit(sigma, unit)));
    }
  }

  void operator()(const PositionCorrection& model) {
    const bool spline = model.basis == PositionCorrection::Basis::kSpline;
    const bool track = model.axes == PositionCorrection::Axes::kTrack;
    Line("basis", spline ? "\"spline\"" : "\"polynomial\"");
    if (spline) Line("knot_spacing_s", NumberText(model.knot_spacing_s));
    if (!spline) Line("degree", std::to_string(model.degree));
    Line("axes", track ? "\"track\"" : "\"frame\"");
    const char* const names[2][3] = {{"\"x\"", "\"y\"", "\"z\""},
                                     {"\"along\"", "\"across\"", "\"up\""}};
    std::vector<std::string> components, sigmas;
    bool prior = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!model.components[axis]) continue;
      components.emplace_back(names[track ? 1 : 0][axis]);
      sigmas.push_back(DegreesText(model.prior_sigma_m[axis]));
      prior = prior || !model.prior_sigma_m[axis].empty();
    }
    List("components", components);
    if (prior) List("sigma_m", sigmas);
    using Process = PositionCorrection::Process;
    if (model.process == Process::kGaussMarkov) {
      Line("process", "\"gauss-markov\"");
      Line("correlation_time_s", NumberText(model.correlation_time_s));
    } else if (model.process == Process::kRandomWalk) {
      std::vector<std::string> starts;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!model.components[axis]) continue;
        // An axis without a prior has no start; the list has one number a component.
        const double start_m = model.start_sigma_m[axis];
        starts.push_back(NumberText(std::isnan(start_m) ? 1.0 : start_m));
      }
      Line("process", "\"random-walk\"");
      List("start_sigma_m", starts);
    }
  }
  void operator()(const VelocityCorrection& model) {
    std::vector<std::string> components, sigmas;
    bool prior = false;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (!model.components[axis]) continue;
      components.emplace_back(axis == 0 ? "\"across\"" : "\"up\"");
      sigmas.push_back(SigmaText(model.prior_sigma[axis]));
      prior = prior || !std::isnan(model.prior_sigma[axis]);
    }
    List("components", components);
    if (prior) List("sigma", sigmas);
  }
  void operator()(const RangeCorrection& model) {
    if (model.bias) Parameter("bias", "bias_sigma_m", model.bias_prior_sigma_m, 1.0);
    if (model.scale) Parameter("scale", "scale_sigma_ppm", model.scale_prior_sigma, 1e-6);
  }
  void operator()(const TimeCorrection& model) {
    Parameter("bias", "bias_sigma_s", model.bias_prior_sigma_s, 1.0);
  }
  void operator()(const SquintCorrection& model) {
    Parameter("bias", "bias_sigma_deg", model.bias_prior_sigma_rad, kRadPerDeg);
  }
  void operator()(const TroposphereCorrection& model) {
    Parameter("zenith", "zenith_sigma_m", model.zenith_prior_sigma_m, 1.0);
    Line("scale_height_m", NumberText(model.scale_height_m));
  }

 private:
  std::string text_;
};

}  // namespace

std::span<const AdjustOption> CorrectionOptions() { return kCorrectionOptions; }

const std::vector<std::string>& CorrectionKinds() {
  static const std::vector<std::string> kinds(kCorrectionKinds.begin(), kCorrectionKinds.end());
  return kinds;
}

std::vector<std::string> KeysWithin(std::span<const AdjustOption> options,
                                    std::string_view prefix) {
  std::vector<std::string> keys;
  for (const AdjustOption& option : options) {
    if (!option.key.starts_with(prefix)) continue;
    const std::string_view rest = option.key.substr(prefix.size());
    if (rest.find('.') == rest.npos) keys.emplace_back(rest);
  }
  return keys;
}

std::vector<CorrectionGroup> ReadCorrections(const TomlTable& correction,
                                             const std::vector<std::string>& pass_ids) {
  const std::vector<std::string>& kinds = CorrectionKinds();
  correction.RefuseOthers(kinds);
  std::vector<CorrectionGroup> groups;
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    const auto value = correction.Find(kinds[kind]);
    if (!value) continue;
    std::vector<TomlValue> tables{*value};
    if (value->IsArray()) tables = value->Entries();
    for (std::size_t i = 0; i < tables.size(); ++i) {
      // Several shared groups are distinguished by their number, from 1.
      const std::string number = tables.size() > 1 ? "." + std::to_string(i + 1) : "";
      CorrectionGroup group = ReadGroup(kind, kinds[kind] + number, TomlTable(tables[i]), pass_ids);
      RefuseOverlap(groups, group, tables[i], pass_ids);
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

std::string DumpCorrections(const std::vector<CorrectionGroup>& groups) {
  std::string text;
  for (std::size_t kind = 0; kind < CorrectionKinds().size(); ++kind) {
    std::vector<const CorrectionGroup*> same;
    for (const CorrectionGroup& group : groups) {
      if (group.model.index() == kind) same.push_back(&group);
    }
    for (const CorrectionGroup* group : same) {
      const std::string header = "[adjust.correction." + CorrectionKinds()[kind] + "]";
      text += same.size() > 1 ? "[" + header + "]\n" : header + "\n";
      GroupDump dump;
      std::visit(dump, group->model);
      std::vector<std::string> ids;
      for (const std::string& id : group->passes) ids.push_back(TomlText(id));
      if (!ids.empty()) dump.List("passes", ids);
      if (group->shared) dump.Line("shared", "true");
      text += dump.text();
    }
  }
  return text;
}

namespace {

// clang-format off
constexpr std::array kPriorOptions = std::to_array<AdjustOption>({
  {"prior.NAME.passes", "list", "pass ids", "all that have the parameters",
   "Passes that have the prior, each its own draw."},
  {"prior.NAME.parameters", "list", "names of passes.csv, of one pass, no splines", "required",
   "Corrections whose joint prior this is; they have no standard deviation of their own."},
  {"prior.NAME.axes", "text", "correction, track, frame, ric, ric-inertial", "correction",
   "Axes of the position parameters; in ric radial, in-track, cross-track. Others than those of "
   "the correction are turned into them at the middle of the strip."},
  {"prior.NAME.covariance", "list", "rows of a symmetric, positive definite matrix",
   "sigma is needed", "Covariance in the units of passes.csv."},
  {"prior.NAME.sigma", "list", "one number above 0 a parameter", "covariance is needed",
   "Standard deviations in the units of passes.csv."},
  {"prior.NAME.correlation", "list", "rows of a symmetric, positive definite matrix",
   "none are correlated", "With sigma: correlations, 1 on the diagonal."},
});
// clang-format on

const std::vector<std::string> kAxes{"correction", "track", "frame", "ric", "ric-inertial"};

std::vector<std::string> ReadNames(const TomlValue& value) {
  std::vector<std::string> out;
  for (const TomlValue& entry : value.Entries()) out.push_back(entry.Text());
  if (out.empty()) value.Fail("is empty, at least one entry is needed");
  return out;
}

Eigen::MatrixXd ReadMatrix(const TomlValue& value) {
  const std::vector<TomlValue> rows = value.Entries();
  const auto size = static_cast<Eigen::Index>(rows.size());
  if (rows.empty()) value.Fail("is empty, one row per parameter is needed");
  Eigen::MatrixXd out(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const TomlValue& row = rows[static_cast<std::size_t>(i)];
    const std::vector<TomlValue> entries = row.Entries();
    if (entries.size() != rows.size()) {
      row.Fail("the row has " + std::to_string(entries.size()) + " entries, as many as rows are " +
               "needed: " + std::to_string(rows.size()));
    }
    for (Eigen::Index j = 0; j < size; ++j) {
      out(i, j) = entries[static_cast<std::size_t>(j)].Number();
    }
  }
  return out;
}

JointPrior ReadPrior(const std::string& name, const TomlTable& table) {
  table.RefuseOthers(KeysWithin(kPriorOptions, "prior.NAME."));
  JointPrior prior;
  prior.name = name;
  if (const auto passes = table.Find("passes")) prior.passes = ReadNames(*passes);
  if (const auto parameters = table.Find("parameters")) prior.parameters = ReadNames(*parameters);
  if (const auto axes = table.Find("axes")) {
    prior.axes = static_cast<JointPrior::Axes>(axes->OneOf(kAxes));
  }
  if (const auto covariance = table.Find("covariance")) prior.covariance = ReadMatrix(*covariance);
  if (const auto correlation = table.Find("correlation")) {
    prior.correlation = ReadMatrix(*correlation);
  }
  if (const auto sigma = table.Find("sigma")) {
    const std::vector<TomlValue> entries = sigma->Entries();
    for (const TomlValue& entry : entries) prior.sigma.push_back(entry.Positive());
    if (entries.empty()) sigma->Fail("is empty, one number a parameter is needed");
  }
  static_cast<void>(table.Require("parameters", "a list of names as in passes.csv"));
  return prior;
}

std::string TextsText(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : ", ") + TomlText(text);
  return "[" + out + "]";
}

std::string NumbersText(const std::vector<double>& numbers) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + NumberText(number);
  return "[" + out + "]";
}

std::string MatrixText(const DenseMatrix& matrix) {
  std::string out;
  for (std::size_t i = 0; i < matrix.rows; ++i) {
    std::vector<double> row;
    for (std::size_t j = 0; j < matrix.columns; ++j) row.push_back(matrix(i, j));
    out += (i > 0 ? ", " : "") + NumbersText(row);
  }
  return "[" + out + "]";
}

}  // namespace

std::span<const AdjustOption> PriorOptions() { return kPriorOptions; }

std::vector<JointPrior> ReadPriors(const TomlTable& priors) {
  std::vector<JointPrior> out;
  for (const auto& [key, node] : priors.table()) {
    const std::string name(key.str());
    out.push_back(ReadPrior(name, TomlTable(*priors.Find(name))));
  }
  return out;
}

void RequireFitting(const TomlTable& table,
                    const std::vector<std::string>& pass_ids,
                    const std::vector<CorrectionGroup>& groups,
                    const std::vector<JointPrior>& priors) {
  const JointPriorBindings bindings = BindJointPriors(pass_ids, groups, priors);
  if (!bindings.problem) return;
  const JointPriorProblem& problem = *bindings.problem;
  const TomlTable prior(*table.Find(priors[problem.prior].name));
  const auto field = prior.Find(problem.field);
  if (!field) throw InputError(prior.PlaceOf(problem.field), problem.problem);
  if (problem.entry >= 0) {
    field->Entries().at(static_cast<std::size_t>(problem.entry)).Fail(problem.problem);
  }
  field->Fail(problem.problem);
}

std::string DumpPriors(const std::vector<JointPrior>& priors) {
  std::string text;
  for (const JointPrior& prior : priors) {
    const auto line = [&text](const char* key, const std::string& value) {
      text.append(key).append(" = ").append(value).append("\n");
    };
    text += "[adjust.prior." + TomlKey(prior.name) + "]\n";
    if (!prior.passes.empty()) line("passes", TextsText(prior.passes));
    line("parameters", TextsText(prior.parameters));
    if (prior.axes != JointPrior::Axes::kCorrection) {
      line("axes", TomlText(kAxes[static_cast<std::size_t>(prior.axes)]));
    }
    if (!prior.covariance.empty()) line("covariance", MatrixText(prior.covariance));
    if (!prior.sigma.empty()) line("sigma", NumbersText(prior.sigma));
    if (!prior.correlation.empty()) line("correlation", MatrixText(prior.correlation));
  }
  return text;
}

namespace {

// A JSON value as a TOML value on one line: tables are inline, what is null is left out. Texts and
// numbers are written alike in both.
std::string TomlOf(const nlohmann::ordered_json& value) {
  std::string text;
  const auto append = [&text](const std::string& part) {
    text += (text.size() > 1 ? ", " : "") + part;
  };
  if (value.is_object()) {
    text = "{";
    for (const auto& [key, member] : value.items()) {
      if (!member.is_null()) append(nlohmann::ordered_json(key).dump() + " = " + TomlOf(member));
    }
    return text + "}";
  }
  if (value.is_array()) {
    text = "[";
    for (const auto& entry : value) append(TomlOf(entry));
    return text + "]";
  }
  return value.dump();
}

}  // namespace

std::vector<CorrectionGroup> CorrectionsOf(const ResultFile& result) {
  constexpr const char* kFile = "summary.json";
  std::vector<std::string> passes;
  for (const ResultPass& pass : result.passes) passes.push_back(pass.id);
  if (!result.summary.selected_model.empty()) {
    return ReadAdjustTable(result.summary.selected_model, kFile, passes).groups;
  }
  const JsonFile json(result.summary.json, kFile);
  const auto configuration = json.Root().Find("configuration");
  if (!configuration) return {};
  const auto chosen = configuration->Find("corrections");
  const auto correction = configuration->Find("correction");
  if (!chosen || chosen->Text() != "given" || !correction) return {};
  return ReadAdjustTable(
             "[adjust]\ncorrection = " + TomlOf(correction->Node()) + "\n", kFile, passes)
      .groups;
}

}  // namespace sarblock::files
