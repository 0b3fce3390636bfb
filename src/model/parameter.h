// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/corrections.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sarblock {

/// What a prior says of a parameter, in the unit of the parameter.
using PriorValue = double;

/// What a parameter corrects.
enum class ParameterKind : std::uint8_t {
  kPosition,  ///< of the antenna, along one axis
  kVelocityAcross,
  kVelocityUp,
  kRangeBias,
  kRangeScale,
  kTimeBias,
  kSquintBias,
  kZenithDelay,
};

/// One correction parameter of a block. Its name and unit are for people and files; what it does
/// is its kind.
struct Parameter {
  std::string owner;                   ///< pass id, or the group's name where shared
  std::string name;                    ///< "position.along.0", "range.bias", ...
  std::string unit;                    ///< "m", "s", "rad", "1"
  PriorSigma prior_sigma = kNotGiven;  ///< of a joint prior the root of its diagonal
  PriorValue prior_value = 0.0;  ///< in `unit`; what the prior says, drawn anew in a simulation
  ParameterKind kind = ParameterKind::kPosition;
  // Of kPosition:
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;
  int axis = 0;         ///< 0 along or x, 1 across or y, 2 up or z
  int degree = 0;       ///< of the polynomial; of a spline the number of its coefficient
  bool spline = false;  ///< coefficient of a spline
  int joint = -1;       ///< index into ParameterLayout::joint_priors; -1: none

  [[nodiscard]] bool has_prior() const { return prior_sigma == prior_sigma; }
  /// A prior that is independent of all others.
  [[nodiscard]] bool has_own_prior() const { return has_prior() && joint < 0; }
};

/// Names of position axes: along, across, up or x, y, z.
[[nodiscard]] const std::array<const char*, 3>& AxisNamesOf(PositionCorrection::Axes axes);

/// A coefficient of a position correction; `degree` is that of the polynomial or the number of the
/// spline's coefficient.
[[nodiscard]] Parameter PositionParameter(const PositionCorrection& position,
                                          std::size_t axis,
                                          std::size_t degree);

/// Parameters of a group in the order of their columns, without owner; none of a spline, whose
/// number depends on the strip. Throws InputError where the group has no parameter.
[[nodiscard]] std::vector<Parameter> ParametersOf(const CorrectionGroup& group);

}  // namespace sarblock
