// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/units.h"

#include <cmath>

#include "adjust_reader.h"
#include "number.h"

namespace sarblock {
namespace {

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
      Line(sigma_name, NumberText(InUnit(sigma, unit)));
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

}  // namespace sarblock
