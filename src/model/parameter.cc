// SPDX-License-Identifier: Apache-2.0
#include "parameter.h"

#include "sarblock/core/error.h"

#include <variant>

#include "geometry/track_axes.h"

namespace sarblock {
namespace {

double PriorOf(const PositionCorrection& position, std::size_t axis, std::size_t degree) {
  const std::vector<double>& sigma_m = position.prior_sigma_m[axis];
  if (sigma_m.empty()) return kNotGiven;
  return sigma_m.size() == 1 ? sigma_m[0] : sigma_m[degree];
}

Parameter OfKind(ParameterKind kind, const char* name, const char* unit, double prior_sigma) {
  Parameter out;
  out.kind = kind;
  out.name = name;
  out.unit = unit;
  out.prior_sigma = prior_sigma;
  return out;
}

}  // namespace

const std::array<const char*, 3>& AxisNamesOf(PositionCorrection::Axes axes) {
  return axes == PositionCorrection::Axes::kTrack ? kTrackAxisNames : kFrameAxisNames;
}

Parameter PositionParameter(const PositionCorrection& position,
                            std::size_t axis,
                            std::size_t degree) {
  Parameter out;
  out.name =
      std::string("position.") + AxisNamesOf(position.axes)[axis] + "." + std::to_string(degree);
  out.unit = "m";
  out.prior_sigma = PriorOf(position, axis, degree);
  out.axes = position.axes;
  out.axis = static_cast<int>(axis);
  out.degree = static_cast<int>(degree);
  out.spline = position.basis == PositionCorrection::Basis::kSpline;
  return out;
}

std::vector<Parameter> ParametersOf(const CorrectionGroup& group) {
  std::vector<Parameter> out;
  const auto add = [&out](ParameterKind kind, const char* name, const char* unit, double sigma) {
    out.push_back(OfKind(kind, name, unit, sigma));
  };
  if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
    if (position->basis == PositionCorrection::Basis::kSpline) return out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!position->components[axis]) continue;
      for (std::size_t k = 0; k <= static_cast<std::size_t>(position->degree); ++k) {
        out.push_back(PositionParameter(*position, axis, k));
      }
    }
  } else if (const auto* velocity = std::get_if<VelocityCorrection>(&group.model)) {
    const auto& sigma = velocity->prior_sigma;
    if (velocity->components[0]) {
      add(ParameterKind::kVelocityAcross, "velocity.across", "1", sigma[0]);
    }
    if (velocity->components[1]) add(ParameterKind::kVelocityUp, "velocity.up", "1", sigma[1]);
  } else if (const auto* range = std::get_if<RangeCorrection>(&group.model)) {
    if (range->bias) {
      add(ParameterKind::kRangeBias, "range.bias", "m", range->bias_prior_sigma_m);
    }
    if (range->scale) {
      add(ParameterKind::kRangeScale, "range.scale", "1", range->scale_prior_sigma);
    }
  } else if (const auto* time = std::get_if<TimeCorrection>(&group.model)) {
    add(ParameterKind::kTimeBias, "time.bias", "s", time->bias_prior_sigma_s);
  } else if (const auto* squint = std::get_if<SquintCorrection>(&group.model)) {
    add(ParameterKind::kSquintBias, "squint.bias", "rad", squint->bias_prior_sigma_rad);
  } else if (const auto* air = std::get_if<TroposphereCorrection>(&group.model)) {
    add(ParameterKind::kZenithDelay, "troposphere.zenith", "m", air->zenith_prior_sigma_m);
  }
  if (out.empty()) {
    throw InputError("correction." + group.name, "has no parameter, switch one on");
  }
  return out;
}

}  // namespace sarblock
