// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/simplified.h"

#include <array>
#include <cstddef>

#include "model/problem.h"

namespace sarblock {

/// The simplifications in the order of the report.
enum SimplificationKind : std::size_t {
  kFlatFrame,
  kFixedTrackAxes,
  kLinearVelocity,
  kSimplificationKinds
};
inline constexpr std::array<const char*, kSimplificationKinds> kSimplificationNames{
    "flat-frame", "fixed-track-axes", "linear-velocity"};

/// A model without one part.
[[nodiscard]] Simplified OnlySimplified(std::size_t kind, const Eigen::Vector3d& middle_m);

/// Mean of the solved points.
[[nodiscard]] Eigen::Vector3d MiddleOfPoints(const AdjustmentProblem& problem,
                                             const BlockState& state);

}  // namespace sarblock
