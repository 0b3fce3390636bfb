// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geodesy/frame.h"
#include "sarblock/geometry/sight.h"

namespace sarblock::internal {

/// The point of one look's circle at a height above the reference surface, on the look side.
[[nodiscard]] Intersection CircleAtHeight(const Sight& sight, const Frame& frame, double height_m);

}  // namespace sarblock::internal
