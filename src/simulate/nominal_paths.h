// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/simulate/scene.h"

#include <vector>

namespace sarblock {

/// A pass as planned, with what deciding visibility needs.
struct NominalPass {
  Pass pass;
  double squint_rad = 0.0;
  SceneSwath swath;
  double reach_m = 0.0;  ///< no point of the strip is farther from the middle of the path
};

/// Nominal paths and strips of all flights, in file order. The states reach beyond the strip by
/// what six standard deviations of the navigation errors and noise can move a look's time.
/// Throws InputError where an orbit cannot see its aim.
[[nodiscard]] std::vector<NominalPass> PlanPasses(const Scene& scene);

}  // namespace sarblock
