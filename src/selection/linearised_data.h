// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "model/parameters.h"
#include "normals/reduced_system.h"
#include "quadratic_model.h"

namespace sarblock {

/// v'Pv as a quadratic function of the corrections of a system formed at `corrections`, with the
/// priors that `parameters` say; all but its redundancy.
[[nodiscard]] QuadraticModel::Data DataAt(const ReducedSystem& system,
                                          const Eigen::VectorXd& corrections,
                                          const std::vector<Parameter>& parameters);

}  // namespace sarblock
